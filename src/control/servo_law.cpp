#include "vantage/control/servo_law.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "vantage/control/bounded_least_squares.h"

namespace vantage {
namespace {

// Singular values below this share of the largest are rounding.
constexpr double kSigmaTolerance = 1e-12;

// Largest speed from which a joint that moves `distance` [m or rad] towards its stop, first for one
// period at that speed, then braking, comes to rest in time: v period + v²/(2a) = distance.
double BrakingSpeed(double distance, double acceleration, double period) noexcept {
  const double reach = std::max(0.0, distance);
  const double a_dt = acceleration * period;
  return -a_dt + std::sqrt(a_dt * a_dt + 2.0 * acceleration * reach);
}

}  // namespace

VelocityBounds ComputeVelocityBounds(const std::vector<JointLimits>& limits, const JointVector& q,
                                     const JointVector& qdot, double period) noexcept {
  const int n = static_cast<int>(limits.size());
  assert(q.size() == n && qdot.size() == n);
  VelocityBounds bounds{JointVector(n), JointVector(n)};
  for (int i = 0; i < n; ++i) {
    const JointLimits& limit = limits[i];
    const double slowest = qdot(i) - limit.acceleration * period;
    const double fastest = qdot(i) + limit.acceleration * period;
    // Outside its range a joint may only move back in, at a speed it can still brake from.
    const double up = q(i) > limit.upper
                          ? -BrakingSpeed(q(i) - limit.upper, limit.acceleration, period)
                          : BrakingSpeed(limit.upper - q(i), limit.acceleration, period);
    const double down = q(i) < limit.lower
                            ? BrakingSpeed(limit.lower - q(i), limit.acceleration, period)
                            : -BrakingSpeed(q(i) - limit.lower, limit.acceleration, period);
    const double lower = std::max(-limit.velocity, down);
    const double upper = std::min(limit.velocity, up);
    bounds.lower(i) = std::clamp(lower, slowest, fastest);
    bounds.upper(i) = std::max(bounds.lower(i), std::clamp(upper, slowest, fastest));
    if (lower > upper)
      bounds.lower(i) = bounds.upper(i) = std::clamp(0.5 * (lower + upper), slowest, fastest);
  }
  return bounds;
}

JointVector RampToRest(const std::vector<JointLimits>& limits, const JointVector& qdot,
                       double period) noexcept {
  JointVector next = qdot;
  for (int i = 0; i < next.size(); ++i) {
    const double step = limits[i].acceleration * period;
    next(i) = std::isfinite(qdot(i)) ? qdot(i) - std::clamp(qdot(i), -step, step) : 0.0;
  }
  return next;
}

double AdaptiveGain(const ServoLawOptions& options, double max_error) noexcept {
  const double range = options.gain_at_zero - options.gain_at_infinity;
  if (range <= 0.0) return options.gain_at_zero;
  return options.gain_at_infinity + range * std::exp(-max_error * options.gain_slope / range);
}

ServoLawResult ServoLaw(const ServoLawOptions& options, const FeatureVector& e,
                        const TaskJacobian& J_c, const SingularSystem& system,
                        const FeatureVector& e_rate, const VelocityBounds& bounds) noexcept {
  const int n = static_cast<int>(bounds.lower.size());
  assert(J_c.cols() == n && J_c.rows() == e.size() && e_rate.size() == e.size());
  ServoLawResult result;
  result.qdot = JointVector::Zero(n);
  if (system.measure.status != MeasureStatus::kOk || !e.allFinite() || !e_rate.allFinite())
    return result;

  const double max_error = e.lpNorm<Eigen::Infinity>();
  result.lambda = options.textbook ? options.gain_at_zero : AdaptiveGain(options, max_error);
  const double rate =
      options.textbook
          ? result.lambda
          : std::min(result.lambda, options.max_error_rate / std::max(max_error, 1e-12));
  const FeatureVector target = -rate * e - e_rate;

  const Measure& measure = system.measure;
  const double sigma_1 = measure.sigma(0);
  double mu2 = 0.0;
  if (!options.textbook && measure.sigma_min < options.damping_onset) {
    const double ratio = measure.sigma_min / options.damping_onset;
    mu2 = options.damping * options.damping * (1.0 - ratio * ratio);
  }
  result.damping = std::sqrt(mu2);

  JointVector free = JointVector::Zero(n);
  for (int i = 0; i < measure.size(); ++i) {
    // Directions below the rank tolerance carry no information: they are left alone.
    const double sigma2 = measure.sigma(i) * measure.sigma(i);
    if (measure.sigma(i) <= kSigmaTolerance * sigma_1) continue;
    free += system.directions.col(i) * (system.axes.col(i).dot(target) / (sigma2 + mu2));
  }
  if (!free.allFinite()) return result;
  result.finite = true;

  if ((free.array() >= bounds.lower.array()).all() &&
      (free.array() <= bounds.upper.array()).all()) {
    result.qdot = free;
    return result;
  }
  if (options.textbook) {
    result.qdot = free.cwiseMax(bounds.lower).cwiseMin(bounds.upper);
    return result;
  }
  // A trace of damping keeps the problem strictly convex when columns of J_c depend on each other.
  const double floor = 1e-12 * sigma_1 * sigma_1 + 1e-12;
  const JointMatrix H = J_c.transpose() * J_c + (mu2 + floor) * JointMatrix::Identity(n, n);
  const JointVector g = J_c.transpose() * target;
  const BoxSolution box = MinimiseInBox(H, g, bounds.lower, bounds.upper, free);
  result.qdot = box.x;
  result.bounds_active = box.active;
  return result;
}

}  // namespace vantage
