#include "vantage/servo/servo_report.h"

#include "vantage/math/angles.h"
#include "vantage/math/format.h"

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

namespace {

// "3 REORDERED, 1 NOT_FINITE": the counts that are not 0, by name.
template <typename Reason, std::size_t kCount>
std::string DescribeCounts(const std::array<std::int64_t, kCount>& counts) {
  std::string text;
  for (std::size_t i = 0; i < kCount; ++i) {
    if (counts[i] == 0) continue;
    if (!text.empty()) text += ", ";
    text += std::to_string(counts[i]) + " " + Name(static_cast<Reason>(i));
  }
  return text.empty() ? "none" : text;
}

}  // namespace

std::string DescribeRefused(const ServoStatus& status) {
  return DescribeCounts<InputFault>(status.refused_by);
}

std::string DescribeStops(const ServoStatus& status) {
  return DescribeCounts<HoldReason>(status.stops_by);
}

std::string Describe(const CalibrationFound& found) {
  const std::string turns = Format("%.2f deg", kDegreesPerRadian * found.revolute);
  const std::string slides = Format("%.1f mm", 1e3 * found.prismatic);
  // An arm may have joints of one kind only.
  std::string encoders = turns;
  if (found.prismatic > 0.0) encoders = found.revolute > 0.0 ? turns + " and " + slides : slides;
  return Format(
      "camera off by %.1f mm and %.2f deg, focal length by %+.2f %%, encoders by up to %s",
      1e3 * found.position, kDegreesPerRadian * found.rotation, 100.0 * found.focal,
      encoders.c_str());
}

}  // namespace vantage
