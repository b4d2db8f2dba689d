#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "vantage/servo/servo_record.h"

/// @file
/// Replay: the recorded inputs of a servo through the same code, on the log's clock, and the outputs
/// compared with those in the log (docs/monitoring.md).

namespace vantage {

/// Settings of a replay.
struct ReplayOptions {
  std::string prefix;  ///< Of the channels in the log.
  /// Numbers agree when |logged - replayed| <= tolerance max(1, |logged|).
  double tolerance{1e-9};
};

/// One value of one message that a replay did not reproduce.
struct ReplayDifference {
  double t{0.0};         ///< Since the start of the servo, on the log's clock [s].
  std::string channel;   ///< Without prefix.
  std::string field;     ///< "velocity[2]"
  std::string logged;    ///< As text.
  std::string replayed;  ///< As text.
};

/// How the messages of one channel compare.
struct ChannelComparison {
  std::string channel;        ///< Without prefix.
  std::int64_t compared{0};   ///< Messages in the log that a replayed one belongs to.
  std::int64_t unmatched{0};  ///< Messages in the log that no replayed one belongs to.
  std::int64_t different{0};  ///< Of those compared.
  double worst{0.0};          ///< Largest |logged - replayed| / max(1, |logged|).
};

/// Outcome for one start of a servo.
struct ReplayReport {
  std::string program;                      ///< Name and version of what was recorded.
  std::string scenario_name;                ///< Of the scenario in the record.
  bool active_camera{true};                 ///< False: started with the camera held fixed.
  std::int64_t periods{0};                  ///< Control periods replayed.
  std::int64_t camera_steps{0};             ///< Steps of the active camera replayed.
  double duration{0.0};                     ///< Of what was replayed, on the log's clock [s].
  std::vector<ChannelComparison> channels;  ///< One for each channel that is compared.
  /// The earliest one.
  std::optional<ReplayDifference> first_difference;
  /// Why the replay could not go to the end of the log; empty when it did.
  std::string cut_short;

  /// Everything was replayed, something was compared, and nothing differs.
  [[nodiscard]] bool reproduced() const;
};

/// Replays every start of a servo that a log holds, in order.
///
/// Compared are JOINT_COMMAND, OBSERVABILITY, SERVO_STATUS and CAMERA_POSE_COMMAND, in all fields but those
/// that tell of the machine and not of the servo: loop times, deadline misses, dropped and refused messages.
/// Throws ConfigError when the log cannot be read, holds no record of a servo or a damaged one, or the scenario
/// in it does not load.
[[nodiscard]] std::vector<ReplayReport> Replay(const std::string& log_path,
                                               const ReplayOptions& options = {});

}  // namespace vantage
