#pragma once

#include <optional>

#include "vantage/robot/joint_state.h"

namespace vantage {

/// Seam between the control loop and an arm. Implemented by the LCM driver and by the simulated
/// plant; there is no other inheritance around it.
class RobotDriver {
 public:
  virtual ~RobotDriver() = default;

  /// Latest joint state, or nullopt when none came since the last call. Real-time safe.
  [[nodiscard]] virtual std::optional<JointState> Read() noexcept = 0;

  /// Sends joint velocities. Real-time safe. The arm stops by itself when no command came for the
  /// driver's watchdog time.
  virtual void Send(const JointCommand& command) noexcept = 0;
};

}  // namespace vantage
