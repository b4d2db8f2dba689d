#pragma once

#include <cstdint>
#include <random>
#include <string>

#include "vantage/config/sim_options.h"
#include "vantage/robot/arm_model.h"
#include "vantage/robot/joint_state.h"

namespace vantage::sim {

/// What a monitor in the plant counts: commands and motion outside the arm's limits.
struct LimitViolations {
  std::int64_t velocity{0};  ///< Commands beyond a velocity limit.
  std::int64_t acceleration{
      0};                      ///< Commands that change faster than the acceleration limit allows.
  std::int64_t position{0};    ///< Plant steps with a joint outside its range.
  std::int64_t not_finite{0};  ///< Commands with a NaN or infinity, or of the wrong size.
  [[nodiscard]] std::int64_t total() const noexcept {
    return velocity + acceleration + position + not_finite;
  }
};

/// A velocity-controlled arm: first-order lag, encoders with noise and bias, a watchdog of its own.
class ArmPlant {
 public:
  /// Throws ConfigError when the start lies outside the limits.
  ArmPlant(ArmModel arm, const JointVector& q_start, const ArmEffects& effects, std::uint64_t seed);

  /// A command received at `now`. Checked by the monitor; a command that is not finite is not obeyed.
  void Accept(const JointCommand& command, Time now);

  /// The arm is another program's: it stands where that one says, and commands are only looked at.
  /// A state of another size is not taken.
  void Follow(const JointState& state);

  /// Moves the arm for dt [s] up to the time `now`.
  void Step(Time now, double dt);

  /// What the encoders say.
  [[nodiscard]] JointState Read(Time now);

  [[nodiscard]] const JointVector& q() const noexcept { return q_; }  ///< The truth [rad or m].
  [[nodiscard]] const LimitViolations& violations() const noexcept { return violations_; }
  [[nodiscard]] const ArmModel& arm() const noexcept { return arm_; }

 private:
  ArmModel arm_;
  ArmEffects effects_;
  std::mt19937_64 random_;
  JointVector bias_, q_, qdot_, target_;
  JointVector last_qdot_;  // as commanded, for the monitor
  Time last_stamp_{};
  Time last_command_{};
  bool commanded_{false};
  bool follows_{false};
  LimitViolations violations_;
};

}  // namespace vantage::sim
