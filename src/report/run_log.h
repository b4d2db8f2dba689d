#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "vantage/config/scenario.h"
#include "vantage/messaging/codec.h"
#include "vantage/servo/servo_record.h"

namespace vantage {

/// Traffic of one channel of a log.
struct ChannelTraffic {
  std::string type;  ///< "vantage_msgs.joint_state_t"; "unknown" when it is none of ours.
  std::int64_t messages{0};
  std::int64_t bytes{0};
  std::int64_t refused{0};      ///< Messages of known channels that failed a check.
  std::int64_t first_utime{0};  ///< When recorded: the logger's wall clock [us].
  std::int64_t last_utime{0};
  double longest_gap{0.0};  ///< Between two messages, as recorded [s].

  /// Messages per second; 0 for fewer than two.
  [[nodiscard]] double rate() const;
};

/// Execution of one control period.
struct PeriodTiming {
  Duration lateness{0};   ///< Of its begin, after the deadline.
  Duration execution{0};  ///< Of the period before.
};

/// A log in memory, but for its images.
struct RunLog {
  std::map<std::string, ChannelTraffic> channels;  ///< By name, prefix included.
  RefusalCounts refused{};
  std::vector<ServoSetup> starts;    ///< One for each start of a servo.
  std::optional<Scenario> scenario;  ///< Of the first start, or the one given.

  std::vector<JointState> joint_states;
  std::vector<JointCommand> joint_commands;
  std::vector<CameraPose> camera_poses;
  std::vector<ImageFeatures> features;
  std::vector<ObservabilityReport> observability;
  std::vector<ServoStatus> statuses;
  std::vector<GroundTruth> truths;
  std::vector<PeriodTiming> periods;
  std::int64_t images{0};
  std::int64_t damaged_bytes{0};  ///< Of the file that belong to no whole message.

  /// Begin of the report's time axis: the first report with features in use, else the first stamp.
  Time t0{};
  Time end{};  ///< Last stamp.
  /// Seconds on the report's time axis [s].
  [[nodiscard]] double At(Time time) const { return ToSeconds(time - t0); }

  /// Whether the marker `id` is one in the scene that shows the goal; false without a scenario.
  [[nodiscard]] bool IsGoalMarker(int id) const;
};

/// Reads a log. Messages that are refused are counted and left out.
///
/// @param prefix    Of the channels.
/// @param scenario  Name or path to take instead of what the log says; empty: the log's.
/// Throws ConfigError when the log cannot be read or holds no message of ours with this prefix, or the scenario
/// does not load.
[[nodiscard]] RunLog ReadRunLog(const std::string& path, const std::string& prefix,
                                const std::string& scenario);

}  // namespace vantage
