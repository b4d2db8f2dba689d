#include "vantage/servo/servo_report.h"

namespace vantage {

void CompleteReport(const FeatureJacobian& J_v, const ArmJacobian& J_r,
                    ObservabilityReport* report) noexcept {
  report->sigma_min_v = MeasureOf(J_v).sigma_min;
  report->sigma_min_r = MeasureOf(J_r).sigma_min;
}

const char* Name(ServoState state) noexcept {
  switch (state) {
    case ServoState::kIdle:
      return "IDLE";
    case ServoState::kAcquiring:
      return "ACQUIRING";
    case ServoState::kServoing:
      return "SERVOING";
    case ServoState::kRepositioning:
      return "REPOSITIONING";
    case ServoState::kHolding:
      return "HOLDING";
    case ServoState::kConverged:
      return "CONVERGED";
    case ServoState::kFault:
      return "FAULT";
  }
  return "UNKNOWN";
}

const char* Name(HoldReason reason) noexcept {
  switch (reason) {
    case HoldReason::kNone:
      return "NONE";
    case HoldReason::kNoJointState:
      return "NO_JOINT_STATE";
    case HoldReason::kStaleJointState:
      return "STALE_JOINT_STATE";
    case HoldReason::kNoCameraPose:
      return "NO_CAMERA_POSE";
    case HoldReason::kStaleCameraPose:
      return "STALE_CAMERA_POSE";
    case HoldReason::kNoFeatures:
      return "NO_FEATURES";
    case HoldReason::kStaleFeatures:
      return "STALE_FEATURES";
    case HoldReason::kTooFewFeatures:
      return "TOO_FEW_FEATURES";
    case HoldReason::kNotFinite:
      return "NOT_FINITE";
    case HoldReason::kPointBehindCamera:
      return "POINT_BEHIND_CAMERA";
    case HoldReason::kArmSingular:
      return "ARM_SINGULAR";
    case HoldReason::kJointLimit:
      return "JOINT_LIMIT";
    case HoldReason::kOperator:
      return "OPERATOR";
    case HoldReason::kArmNotFollowing:
      return "ARM_NOT_FOLLOWING";
  }
  return "UNKNOWN";
}

const char* Name(InputFault fault) noexcept {
  switch (fault) {
    case InputFault::kMalformed:
      return "MALFORMED";
    case InputFault::kWrongSize:
      return "WRONG_SIZE";
    case InputFault::kNotFinite:
      return "NOT_FINITE";
    case InputFault::kOutOfRange:
      return "OUT_OF_RANGE";
    case InputFault::kReordered:
      return "REORDERED";
    case InputFault::kFuture:
      return "FUTURE";
  }
  return "UNKNOWN";
}

std::string DescribeRefused(const ServoStatus& status) {
  std::string text;
  for (int i = 0; i < kNumInputFaults; ++i) {
    const std::int64_t count = status.refused_by[static_cast<std::size_t>(i)];
    if (count == 0) continue;
    if (!text.empty()) text += ", ";
    text += std::to_string(count) + " " + Name(static_cast<InputFault>(i));
  }
  return text.empty() ? "none" : text;
}

}  // namespace vantage
