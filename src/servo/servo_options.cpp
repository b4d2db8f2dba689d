#include "vantage/servo/servo_options.h"

#include <cmath>
#include <limits>
#include <string>

#include "vantage/math/error.h"

namespace vantage {
namespace {

constexpr double kAny = std::numeric_limits<double>::max();

// Refuses what is not in [least, most], or is not finite.
void Require(const char* key, double value, double least, double most, const char* unit) {
  if (value >= least && value <= most) return;
  const std::string bound =
      most == kAny ? ">= " + std::to_string(least) + " and finite"
                   : "in [" + std::to_string(least) + ", " + std::to_string(most) + "]";
  throw ConfigError("", std::string("servo.") + key,
                    "must be " + bound + " " + unit + ", is " + std::to_string(value));
}

void RequirePositive(const char* key, double value, const char* unit) {
  if (value > 0.0 && std::isfinite(value)) return;
  throw ConfigError("", std::string("servo.") + key,
                    std::string("must be > 0 ") + unit + ", is " + std::to_string(value));
}

void RequireLaw(const ServoLawOptions& law) {
  RequirePositive("gain_at_zero", law.gain_at_zero, "1/s");
  RequirePositive("gain_at_infinity", law.gain_at_infinity, "1/s");
  Require("gain_slope", law.gain_slope, 0.0, kAny, "1/(s px)");
  Require("damping", law.damping, 0.0, kAny, "px/rad");
  Require("damping_onset", law.damping_onset, 0.0, kAny, "px/rad");
  RequirePositive("max_error_rate", law.max_error_rate, "px/s");
  Require("start_time", law.start_time, 0.0, kAny, "s");
  Require("ascent_gain", law.ascent_gain, 0.0, kAny, "");
  Require("self_motion", law.self_motion, 0.0, 1.0, "");
}

void RequireCalibration(const CalibrationPrior& prior) {
  Require("calibration.position", prior.position, 0.0, kAny, "m");
  Require("calibration.rotation", prior.rotation, 0.0, kAny, "rad");
  Require("calibration.focal", prior.focal, 0.0, kAny, "");
  Require("calibration.joint", prior.joint, 0.0, kAny, "rad or m");
}

}  // namespace

void Validate(const ServoOptions& options) {
  Require("period", options.period, 0.0005, 0.1, "s");
  RequireLaw(options.law);
  RequirePositive("path.reach", options.path.reach, "rad or m");
  Require("path.trust", options.path.trust, 0.0, kAny, "px/rad");
  RequirePositive("staleness.joint_state", options.staleness.joint_state, "s");
  RequirePositive("staleness.camera_pose", options.staleness.camera_pose, "s");
  RequirePositive("staleness.features", options.staleness.features, "s");
  Require("staleness.marker", options.staleness.marker, 0.0, kAny, "s");
  Require("staleness.hidden_marker", options.staleness.hidden_marker, 0.0, kAny, "s");
  RequirePositive("convergence.tolerance_px", options.convergence.tolerance_px, "px");
  Require("convergence.settle_time", options.convergence.settle_time, 0.0, kAny, "s");
  RequirePositive("convergence.max_mm_per_px", options.convergence.max_mm_per_px, "mm/px");
  RequirePositive("convergence.tolerance_mm", options.convergence.tolerance_mm, "mm");
  Require("limit_margin", options.limit_margin, 0.0, kAny, "rad or m");
  RequirePositive("wait_mm_per_px", options.wait_mm_per_px, "mm/px");
  RequirePositive("stall_time", options.stall_time, "s");
  RequirePositive("feature_noise_px", options.feature_noise_px, "px");
  Require("calibration_px", options.calibration_px, 0.0, kAny, "px");
  Require("offset_time", options.offset_time, 0.0, kAny, "s");
  RequireCalibration(options.calibration);
}

}  // namespace vantage
