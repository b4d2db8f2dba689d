#pragma once

#include <cstddef>

#include "vantage/math/sizes.h"
#include "vantage/messaging/codec.h"

/// @file
/// Drake's messages for a Franka Panda (drake.lcmt_panda_status, drake.lcmt_panda_command), as its driver
/// speaks them: for vantage-panda-bridge.

namespace vantage {

inline constexpr char kPandaStatusChannel[] = "PANDA_STATUS";    ///< PandaStatus.
inline constexpr char kPandaCommandChannel[] = "PANDA_COMMAND";  ///< PandaCommand.

/// What the driver of the Panda does with commands.
enum class PandaMode : int {
  kOther = 0,
  kIdle = 1,
  kMove = 2,
  kGuiding = 3,
  kReflex = 4,
  kUserStopped = 5,
  kAutomaticErrorRecovery = 6,
};

/// "OTHER", "IDLE", "MOVE", ...
[[nodiscard]] const char* Name(PandaMode mode) noexcept;

/// What of the status is used here.
struct PandaStatus {
  Time stamp{};                       ///< On the driver's clock, whichever that is.
  JointVector q;                      ///< Measured joints [rad].
  JointVector qdot;                   ///< Measured joint velocities [rad/s].
  PandaMode mode{PandaMode::kOther};  ///< Robot mode as libfranka has it.
  bool position_control{false};       ///< The driver takes positions.
  bool velocity_control{false};       ///< The driver takes velocities.
};

/// What Drake's driver of the Panda obeys: drake::lcmt_panda_command.
struct PandaCommand {
  Time stamp{};      ///< When the command was computed, on the sender's clock.
  JointVector q;     ///< Wanted joints [rad].
  JointVector qdot;  ///< Wanted joint velocities [rad/s].
  /// Mode the driver is believed to be in; in velocity mode otherwise.
  bool position_control{false};
};

/// As the codecs of codec.h: *out is untouched unless kNone is returned.
[[nodiscard]] Refusal Decode(const void* data, std::size_t size, PandaStatus* out) noexcept;
[[nodiscard]] Refusal Decode(const void* data, std::size_t size, PandaCommand* out) noexcept;
/// Desired values are set to the measured ones, torques to zero.
void Encode(const PandaStatus& value, Bytes* out);
void Encode(const PandaCommand& value, Bytes* out);

}  // namespace vantage
