#include "vantage/active/rig_motion.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace vantage {
namespace {

// The bounds are evaluated at points of the path; what lies between them gets this much room.
constexpr double kSpeedShare = 0.98;
// Braking is planned with a share of what is allowed, so that it is never needed in full.
constexpr double kBrakeShare = 0.9;
// On a bent path the acceleration has a part along it and a part across it, from the bend.
constexpr double kAlongShare = 0.7;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// Steps of the path smaller than this are no motion [m or rad].
constexpr double kNoMotion = 1e-12;
// The end counts as reached within this share of the path.
constexpr double kArrived = 1e-8;

}  // namespace

RigPath RigPath::Straight(const RigVector& start, const RigVector& end) {
  return {start, 0.5 * (start + end), end};
}

RigVector RigPath::At(double s) const noexcept {
  const double r = 1.0 - s;
  return r * r * start + 2.0 * s * r * control + s * s * end;
}

RigVector RigPath::Slope(double s) const noexcept {
  return 2.0 * ((1.0 - s) * (control - start) + s * (end - control));
}

RigVector RigPath::Bend() const noexcept {
  return 2.0 * (start - 2.0 * control + end);
}

RigMotion::RigMotion(const RigVector& q_c) : path_{q_c, q_c, q_c}, s_(1.0) {}

RigMotion::RigMotion(const CameraRig& rig, const RigPath& path) : path_(path) {
  assert(path.start.size() == rig.size());
  const RigVector bend = path.Bend();
  const double bent = bend.size() > 0 ? bend.cwiseAbs().maxCoeff() : 0.0;
  const bool straight = bent < 1e-9;
  const double along = straight ? 1.0 : kAlongShare;

  // Speed bounds at the grid's points; the largest slope of each axis bounds the acceleration.
  acceleration_ = kInfinity;
  double bend_rate2 = kInfinity;
  for (int i = 0; i < rig.size(); ++i) {
    // The slope is linear in s: its extremes are at the ends.
    const double slope = std::max(std::abs(path.Slope(0.0)(i)), std::abs(path.Slope(1.0)(i)));
    if (slope < kNoMotion) continue;
    acceleration_ = std::min(acceleration_, along * rig.axes[i].max_acceleration / slope);
    if (!straight && std::abs(bend(i)) > 0.0) {
      bend_rate2 =
          std::min(bend_rate2, (1.0 - along) * rig.axes[i].max_acceleration / std::abs(bend(i)));
    }
  }
  if (acceleration_ == kInfinity) {  // Nothing moves: already there.
    acceleration_ = 0.0;
    s_ = 1.0;
    return;
  }
  for (int k = 0; k <= kGrid; ++k) {
    const double s = static_cast<double>(k) / kGrid;
    const RigVector slope = path.Slope(s);
    double rate = kInfinity;
    for (int i = 0; i < rig.size(); ++i) {
      const double size = std::abs(slope(i));
      if (size >= kNoMotion) rate = std::min(rate, rig.axes[i].max_speed / size);
    }
    const double linear = (RigJacobian(rig, path.At(s)).topRows<3>() * slope).norm();
    if (linear >= kNoMotion) rate = std::min(rate, rig.max_linear_speed / linear);
    rate *= kSpeedShare;
    rate2_[k] = std::min(rate * rate, bend_rate2);
  }
  // From every point the motion must be able to slow down to what comes after.
  const double step = 1.0 / kGrid;
  rate2_[kGrid] = 0.0;
  for (int k = kGrid - 1; k >= 0; --k) {
    rate2_[k] = std::min(rate2_[k], rate2_[k + 1] + 2.0 * kBrakeShare * acceleration_ * step);
  }
  // Time: the same, speeding up from rest.
  double reached2 = 0.0;
  for (int k = 0; k < kGrid; ++k) {
    const double next2 = std::min(rate2_[k + 1], reached2 + 2.0 * acceleration_ * step);
    time_[k + 1] = time_[k] + 2.0 * step / (std::sqrt(reached2) + std::sqrt(next2) + 1e-12);
    reached2 = next2;
  }
  duration_ = time_[kGrid];
}

double RigMotion::RateBound(double s) const noexcept {
  const double at = std::clamp(s, 0.0, 1.0) * kGrid;
  const int k = std::min(static_cast<int>(at), kGrid - 1);
  const double share = at - k;
  return std::sqrt((1.0 - share) * rate2_[k] + share * rate2_[k + 1]);
}

double RigMotion::TimeAt(double s) const noexcept {
  const double at = std::clamp(s, 0.0, 1.0) * kGrid;
  const int k = std::min(static_cast<int>(at), kGrid - 1);
  return time_[k] + (at - k) * (time_[k + 1] - time_[k]);
}

void RigMotion::Step(double dt, bool brake) noexcept {
  if (dt <= 0.0 || Done()) return;
  const double slowest = std::max(0.0, rate_ - acceleration_ * dt);
  const double fastest = rate_ + acceleration_ * dt;
  const auto s_after = [&](double rate) { return s_ + 0.5 * (rate_ + rate) * dt; };
  double next = slowest;
  if (!brake && fastest <= RateBound(s_after(fastest)) && s_after(fastest) <= 1.0) {
    next = fastest;
  } else if (!brake && slowest < RateBound(s_after(slowest))) {
    // Between the two lies the fastest rate that the bounds at its own end admit.
    double low = slowest, high = fastest;
    for (int i = 0; i < 50; ++i) {
      const double middle = 0.5 * (low + high);
      const bool admitted = s_after(middle) <= 1.0 && middle <= RateBound(s_after(middle));
      (admitted ? low : high) = middle;
    }
    next = low;
  }
  // Braking to rest may take less than the whole step.
  const double braking_time = rate_ / std::max(acceleration_, 1e-300);
  s_ = next == 0.0 && braking_time < dt ? s_ + 0.5 * rate_ * braking_time : s_after(next);
  s_ = std::min(s_, 1.0);
  rate_ = next;
  // What is left is less than a hundred-millionth of the path: neither seen nor felt.
  if (!brake && 1.0 - s_ < kArrived && rate_ < kArrived) rate_ = 0.0;
}

RigVector RigMotion::StopCoordinates() const noexcept {
  if (rate_ == 0.0) return q_c();
  return path_.At(std::min(1.0, s_ + 0.5 * rate_ * rate_ / acceleration_));
}

bool RigMotion::Done() const noexcept {
  return rate_ == 0.0 && 1.0 - s_ < kArrived;
}

}  // namespace vantage
