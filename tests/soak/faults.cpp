#include "faults.h"

#include <limits>

namespace vantage::soak {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr Duration kAhead = std::chrono::seconds(10);

}  // namespace

const char* Faults::Name(Kind kind) noexcept {
  switch (kind) {
    case Kind::kNoJoints:
      return "no joint state";
    case Kind::kJointsNotFinite:
      return "joint state with a NaN";
    case Kind::kJointMissing:
      return "joint state of one joint too few";
    case Kind::kJointsFrozen:
      return "the same joint state again";
    case Kind::kJointsFromTheFuture:
      return "joint state from the future";
    case Kind::kNoPose:
      return "no camera pose";
    case Kind::kPoseNotFinite:
      return "camera pose with a NaN";
    case Kind::kPoseFromTheFuture:
      return "camera pose from the future";
    case Kind::kNoFeatures:
      return "no features";
    case Kind::kFeaturesNotFinite:
      return "features with a NaN";
    case Kind::kFeaturesFromTheFuture:
      return "features from the future";
    case Kind::kNoMarkers:
      return "no marker seen";
    case Kind::kSomeMarkers:
      return "half of the markers seen";
    case Kind::kNone:
    case Kind::kCount:
      break;
  }
  return "none";
}

void Faults::Choose(Time now) {
  const auto uniform = [&](double from, double to) {
    return FromSeconds(std::uniform_real_distribution<double>(from, to)(random_));
  };
  if (next_ == Time{}) next_ = now + uniform(0.5, 3.0);
  if (kind_ != Kind::kNone && now >= end_) {
    kind_ = Kind::kNone;
    frozen_.reset();
    next_ = now + uniform(0.3, 3.0);
  }
  if (kind_ == Kind::kNone && now >= next_) {
    const int last = static_cast<int>(Kind::kCount) - 1;
    kind_ = static_cast<Kind>(std::uniform_int_distribution<int>(1, last)(random_));
    end_ = now + uniform(0.02, 1.0);
    ++counts_[Name(kind_)];
  }
}

void Faults::Spoil(PeriodInputs* inputs) {
  Choose(inputs->now);
  // A message that is spoilt and there has to be refused.
  const auto refuse = [&](bool is_there) { to_be_refused_ += is_there ? 1 : 0; };
  switch (kind_) {
    case Kind::kNoJoints:
      inputs->has_joints = false;
      break;
    case Kind::kJointsNotFinite:
      inputs->joints.q(0) = kNan;
      refuse(inputs->has_joints);
      break;
    case Kind::kJointMissing:
      inputs->joints.q.conservativeResize(inputs->joints.q.size() - 1);
      refuse(inputs->has_joints);
      break;
    case Kind::kJointsFrozen:
      refuse(frozen_.has_value());
      if (!frozen_) frozen_ = inputs->joints;
      inputs->joints = *frozen_;
      break;
    case Kind::kJointsFromTheFuture:
      inputs->joints.stamp += kAhead;
      refuse(inputs->has_joints);
      break;
    case Kind::kNoPose:
      inputs->has_pose = false;
      break;
    case Kind::kPoseNotFinite:
      inputs->pose.X_WC.translation().y() = kNan;
      refuse(inputs->has_pose);
      break;
    case Kind::kPoseFromTheFuture:
      inputs->pose.stamp += kAhead;
      refuse(inputs->has_pose);
      break;
    case Kind::kNoFeatures:
      inputs->has_features = false;
      break;
    case Kind::kFeaturesNotFinite:
      inputs->features.markers[0].pixel.x() = kNan;
      inputs->features.markers[0].valid = true;
      refuse(inputs->has_features);
      break;
    case Kind::kFeaturesFromTheFuture:
      inputs->features.exposure += kAhead;
      refuse(inputs->has_features);
      break;
    case Kind::kNoMarkers:
      for (MarkerMeasurement& marker : inputs->features.markers) marker.valid = false;
      break;
    case Kind::kSomeMarkers:
      for (std::size_t i = 0; i < inputs->features.markers.size(); i += 2) {
        inputs->features.markers[i].valid = false;
      }
      break;
    case Kind::kNone:
    case Kind::kCount:
      break;
  }
}

void Faults::Restart() {
  kind_ = Kind::kNone;
  next_ = end_ = Time{};
  frozen_.reset();
  to_be_refused_ = 0;
}

}  // namespace vantage::soak
