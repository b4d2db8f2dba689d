#include "vantage/servo/servo_options.h"

#include <cmath>
#include <string>

#include "vantage/math/error.h"

namespace vantage {
namespace {

void Refuse(const char* key, const std::string& bound, double value) {
  throw ConfigError("", std::string("servo.") + key,
                    "must be " + bound + ", is " + std::to_string(value));
}

void RequireNotNegative(const char* key, double value, const char* unit) {
  if (value >= 0.0 && std::isfinite(value)) return;
  Refuse(key, std::string(">= 0 ") + unit, value);
}

void RequirePositive(const char* key, double value, const char* unit) {
  if (value > 0.0 && std::isfinite(value)) return;
  Refuse(key, std::string("> 0 ") + unit, value);
}

void RequireLaw(const ServoLawOptions& law) {
  RequirePositive("gain_at_zero", law.gain_at_zero, "1/s");
  RequirePositive("gain_at_infinity", law.gain_at_infinity, "1/s");
  RequireNotNegative("gain_slope", law.gain_slope, "1/(s px)");
  RequireNotNegative("damping", law.damping, "px/rad");
  RequireNotNegative("damping_onset", law.damping_onset, "px/rad");
  RequirePositive("max_error_rate", law.max_error_rate, "px/s");
  RequireNotNegative("start_time", law.start_time, "s");
  RequireNotNegative("ascent_gain", law.ascent_gain, "");
  if (!(law.self_motion >= 0.0 && law.self_motion <= 1.0)) {
    Refuse("self_motion", "in [0, 1]", law.self_motion);
  }
}

void RequireCalibration(const CalibrationPrior& prior) {
  RequireNotNegative("calibration.position", prior.position, "m");
  RequireNotNegative("calibration.rotation", prior.rotation, "rad");
  RequireNotNegative("calibration.focal", prior.focal, "");
  RequireNotNegative("calibration.joint", prior.joint, "rad or m");
}

}  // namespace

void Validate(const ServoOptions& options) {
  if (!(options.period >= 0.0005 && options.period <= 0.1)) {
    Refuse("period", "in [0.0005, 0.1] s", options.period);
  }
  RequireLaw(options.law);
  RequirePositive("path.reach", options.path.reach, "rad or m");
  RequireNotNegative("path.trust", options.path.trust, "px/rad");
  RequirePositive("staleness.joint_state", options.staleness.joint_state, "s");
  RequirePositive("staleness.camera_pose", options.staleness.camera_pose, "s");
  RequirePositive("staleness.features", options.staleness.features, "s");
  RequireNotNegative("staleness.marker", options.staleness.marker, "s");
  RequireNotNegative("staleness.hidden_marker", options.staleness.hidden_marker, "s");
  RequirePositive("convergence.tolerance_px", options.convergence.tolerance_px, "px");
  RequireNotNegative("convergence.settle_time", options.convergence.settle_time, "s");
  RequirePositive("convergence.max_mm_per_px", options.convergence.max_mm_per_px, "mm/px");
  RequirePositive("convergence.tolerance_mm", options.convergence.tolerance_mm, "mm");
  RequireNotNegative("limit_margin", options.limit_margin, "rad or m");
  RequirePositive("wait_mm_per_px", options.wait_mm_per_px, "mm/px");
  RequirePositive("stall_time", options.stall_time, "s");
  RequirePositive("feature_noise_px", options.feature_noise_px, "px");
  RequireNotNegative("calibration_px", options.calibration_px, "px");
  RequireNotNegative("offset_time", options.offset_time, "s");
  RequireCalibration(options.calibration);
}

}  // namespace vantage
