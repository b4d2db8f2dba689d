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

// Knot i of the clamped uniform cubic: 0 four times, then even steps, 1 four times.
double Knot(int i) noexcept {
  return std::clamp(static_cast<double>(i - 3) / RigPath::kSpans, 0.0, 1.0);
}

int SpanOf(double s) noexcept {
  return std::clamp(static_cast<int>(s * RigPath::kSpans), 0, RigPath::kSpans - 1);
}

// Value at s in `span` of the curve of degree D (the cubic's derivative of that degree) whose points
// there are the first D + 1 of *d.
template <int D>
RigVector DeBoor(std::array<RigVector, 4>* d, int span, double s) noexcept {
  const int k = span + 3;  // Knots k and k + 1 hold the span, whatever the degree.
  for (int level = 1; level <= D; ++level) {
    for (int i = D; i >= level; --i) {
      const double low = Knot(k - D + i);
      const double high = Knot(k + 1 + i - level);
      const double share = (s - low) / (high - low);
      (*d)[i] = (1.0 - share) * (*d)[i - 1] + share * (*d)[i];
    }
  }
  return (*d)[D];
}

}  // namespace

RigPath RigPath::Straight(const RigVector& start, const RigVector& end) {
  RigPath path;
  for (int i = 0; i < kPoints; ++i) {
    path.points_[i] = (1.0 - Station(i)) * start + Station(i) * end;
  }
  return path;
}

RigPath RigPath::Parabola(const RigVector& start, const RigVector& control, const RigVector& end) {
  // Control point i is the curve's polar form at the knots i + 1, i + 2, i + 3; that of a parabola seen
  // as a cubic is the mean of its own over the three pairs. Each pair is a mean of the three points.
  const auto polar = [&](double u, double v) -> RigVector {
    return (1.0 - u) * (1.0 - v) * start + (u * (1.0 - v) + v * (1.0 - u)) * control + u * v * end;
  };
  RigPath path;
  for (int i = 0; i < kPoints; ++i) {
    const double u = Knot(i + 1), v = Knot(i + 2), w = Knot(i + 3);
    path.points_[i] = (polar(u, v) + polar(v, w) + polar(u, w)) / 3.0;
  }
  path.points_.front() = start;
  path.points_.back() = end;
  return path;
}

double RigPath::Station(int point) noexcept {
  return (Knot(point + 1) + Knot(point + 2) + Knot(point + 3)) / 3.0;
}

RigPath RigPath::StartingAt(const RigVector& start) const {
  RigPath path = *this;
  for (int i = 0; i < kPoints; ++i) {
    const double rest = 1.0 - Station(i);
    path.points_[i] += rest * rest * rest * (start - points_.front());
  }
  path.points_.front() = start;
  return path;
}

RigVector RigPath::At(double s) const noexcept {
  std::array<RigVector, 4> d;
  const int span = SpanOf(s);
  for (int i = 0; i < 4; ++i) d[i] = points_[span + i];
  return DeBoor<3>(&d, span, s);
}

RigVector RigPath::Slope(double s) const noexcept {
  std::array<RigVector, 4> d;
  const int span = SpanOf(s);
  for (int i = 0; i < 3; ++i) d[i] = SlopePoint(span + i);
  return DeBoor<2>(&d, span, s);
}

RigVector RigPath::Bend(double s) const noexcept {
  std::array<RigVector, 4> d;
  const int span = SpanOf(s);
  for (int i = 0; i < 2; ++i) d[i] = BendPoint(span + i);
  return DeBoor<1>(&d, span, s);
}

RigVector RigPath::SlopePoint(int i) const noexcept {
  return 3.0 / (Knot(i + 4) - Knot(i + 1)) * (points_[i + 1] - points_[i]);
}

RigVector RigPath::BendPoint(int i) const noexcept {
  return 2.0 / (Knot(i + 4) - Knot(i + 2)) * (SlopePoint(i + 1) - SlopePoint(i));
}

RigVector RigPath::SlopeBound() const noexcept {
  RigVector bound = SlopePoint(0).cwiseAbs();
  for (int i = 1; i + 1 < kPoints; ++i) bound = bound.cwiseMax(SlopePoint(i).cwiseAbs());
  return bound;
}

double RigPath::Length() const noexcept {
  double length = 0.0;
  for (int i = 0; i + 1 < kPoints; ++i) length += (points_[i + 1] - points_[i]).lpNorm<1>();
  return length;
}

RigMotion::RigMotion(const RigVector& q_c) : path_(RigPath::Straight(q_c, q_c)), s_(1.0) {}

RigMotion::RigMotion(const CameraRig& rig, const RigPath& path) : path_(path) {
  assert(path.start().size() == rig.size());
  double bent = 0.0;
  for (int k = 0; k <= RigPath::kSpans; ++k) {
    bent = std::max(bent, path.Bend(static_cast<double>(k) / RigPath::kSpans).lpNorm<1>());
  }
  const bool straight = bent < 1e-9;
  const double along = straight ? 1.0 : kAlongShare;

  const RigVector slope_bound = path.SlopeBound();
  acceleration_ = kInfinity;
  for (int i = 0; i < rig.size(); ++i) {
    if (slope_bound(i) < kNoMotion) continue;
    acceleration_ = std::min(acceleration_, along * rig.axes[i].max_acceleration / slope_bound(i));
  }
  if (acceleration_ == kInfinity) {  // Nothing moves: already there.
    acceleration_ = 0.0;
    s_ = 1.0;
    return;
  }
  for (int k = 0; k <= kGrid; ++k) {
    const double s = static_cast<double>(k) / kGrid;
    const RigVector slope = path.Slope(s);
    const RigVector bend = path.Bend(s);
    double rate = kInfinity;
    double bend_rate2 = kInfinity;
    for (int i = 0; i < rig.size(); ++i) {
      const double size = std::abs(slope(i));
      if (size >= kNoMotion) rate = std::min(rate, rig.axes[i].max_speed / size);
      const double across = (1.0 - along) * rig.axes[i].max_acceleration;
      if (!straight && std::abs(bend(i)) > kNoMotion) {
        bend_rate2 = std::min(bend_rate2, across / std::abs(bend(i)));
      }
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
