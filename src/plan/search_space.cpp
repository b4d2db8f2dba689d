#include "search_space.h"

#include <algorithm>
#include <cmath>

#include "vantage/math/angles.h"

namespace vantage::plan {
namespace {

bool HasRoom(const RigAxis& axis) {
  return axis.upper > axis.lower;
}

}  // namespace

SearchSpace::SearchSpace(const CameraRig& rig, const RigVector& q_c_start)
    : rig_(rig), q_c_fixed_(q_c_start) {
  for (int i = 0; i < rig.size(); ++i) {
    const RigAxis& axis = rig.axes[i];
    if (!HasRoom(axis)) {
      q_c_fixed_(i) = axis.lower;
      continue;
    }
    axes_.push_back(i);
    range_.push_back(axis.upper - axis.lower);
    round_.push_back(AxisTurns(rig, i) && range_.back() >= 2.0 * kPi - 1e-9);
  }
  // Whether a camera can step back does not depend on how fast its axes are.
  unlocked_ = rig_;
  for (RigAxis& axis : unlocked_.axes)
    axis.max_speed = std::max(axis.max_speed, HasRoom(axis) ? 1.0 : 0);
  const bool all_free = size() == rig.size();
  if (rig.kind == RigKind::kSpherical && rig.orientation == RigOrientation::kLookAt) {
    if (rig.size() == 4 && HasRoom(rig.axes[0])) step_ = Step::kRadius;
    if (rig.size() == 6 && all_free) step_ = Step::kPose;
  } else if (rig.kind == RigKind::kFree && HasRoom(rig.axes[0]) && HasRoom(rig.axes[1]) &&
             HasRoom(rig.axes[2])) {
    step_ = Step::kPose;
  }
  // The positive root of x^(d+1) = x + 1.
  double phi = 2.0;
  for (int i = 0; i < 40; ++i) phi = std::pow(1.0 + phi, 1.0 / (size() + 1));
  for (int i = 0; i < size(); ++i) ratio_.push_back(std::pow(phi, -(i + 1)));
}

RigVector SearchSpace::ToRig(const SearchVector& u) const noexcept {
  RigVector q_c = q_c_fixed_;
  for (int i = 0; i < size(); ++i) {
    const double share = round_[i] ? u(i) - std::floor(u(i)) : std::clamp(u(i), 0.0, 1.0);
    q_c(axes_[i]) =
        share == 1.0 ? rig_.axes[axes_[i]].upper : rig_.axes[axes_[i]].lower + share * range_[i];
  }
  return q_c;
}

RigVector SearchSpace::ToRigFreely(const SearchVector& u) const noexcept {
  RigVector q_c = q_c_fixed_;
  for (int i = 0; i < size(); ++i) q_c(axes_[i]) = rig_.axes[axes_[i]].lower + u(i) * range_[i];
  return q_c;
}

SearchVector SearchSpace::FromRig(const RigVector& q_c) const noexcept {
  SearchVector u(size());
  for (int i = 0; i < size(); ++i) {
    u(i) = (q_c(axes_[i]) - rig_.axes[axes_[i]].lower) / range_[i];
  }
  return u;
}

double SearchSpace::Excess(const SearchVector& u) const noexcept {
  double excess = 0.0;
  for (int i = 0; i < size(); ++i) {
    if (!round_[i]) excess += std::max({0.0, -u(i), u(i) - 1.0});
  }
  return excess;
}

double SearchSpace::Distance(const SearchVector& a, const SearchVector& b) const noexcept {
  double distance = 0.0;
  for (int i = 0; i < size(); ++i) {
    double d = std::abs(a(i) - b(i));
    if (round_[i]) {
      const double turn = 2.0 * kPi / range_[i];
      d = std::abs(d - turn * std::round(d / turn));  // std::remainder() takes ten times as long
    }
    distance = std::max(distance, d);
  }
  return distance;
}

SearchVector SearchSpace::Spread(std::int64_t i) const noexcept {
  SearchVector u(size());
  for (int j = 0; j < size(); ++j) {
    const double at = 0.5 + static_cast<double>(i + 1) * ratio_[j];
    u(j) = at - std::floor(at);
  }
  return u;
}

RigVector SearchSpace::StepBack(const RigVector& q_c, double back) const noexcept {
  if (step_ == Step::kNone) return q_c;
  RigVector moved = q_c;
  if (step_ == Step::kRadius) {
    moved(0) = std::clamp(q_c(0) + back, rig_.axes[0].lower, rig_.axes[0].upper);
    return moved;
  }
  Eigen::Isometry3d X_WC = RigPose(rig_, q_c);
  const Eigen::Vector3d shift_W = -back * X_WC.linear().col(2);
  if (rig_.kind == RigKind::kFree) {
    for (int i = 0; i < 3; ++i) {
      moved(i) = std::clamp(q_c(i) + shift_W(i), rig_.axes[i].lower, rig_.axes[i].upper);
    }
    return moved;
  }
  X_WC.translation() += shift_W;
  return NearestRigCoordinates(unlocked_, X_WC, q_c);
}

}  // namespace vantage::plan
