#include "vantage/control/servo_law.h"

#include <algorithm>
#include <array>
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

// Bound on the speed towards a stop that is `distance` away; outside the range (distance < 0) a joint may
// only move back in, at a speed it can still brake from.
double SpeedTowards(double distance, const JointLimits& limit, double period) noexcept {
  const double braking = 0.5 * limit.velocity / limit.acceleration + period;
  if (distance >= limit.velocity * braking) return limit.velocity;
  const double speed = distance < 0.0 ? -BrakingSpeed(-distance, limit.acceleration, period)
                                      : BrakingSpeed(distance, limit.acceleration, period);
  return std::min(limit.velocity, speed);
}

// Share of the half range about the middle in which a joint is left alone.
constexpr double kCalm = 0.7;

}  // namespace

VelocityBounds ComputeVelocityBounds(const std::vector<JointLimits>& limits,
                                     const JointVector& q_least, const JointVector& q_most,
                                     const JointVector& qdot, double period) noexcept {
  const int n = static_cast<int>(limits.size());
  assert(q_least.size() == n && q_most.size() == n && qdot.size() == n);
  VelocityBounds bounds{JointVector(n), JointVector(n)};
  for (int i = 0; i < n; ++i) {
    const JointLimits& limit = limits[i];
    const double slowest = qdot(i) - limit.acceleration * period;
    const double fastest = qdot(i) + limit.acceleration * period;
    const double lower = -SpeedTowards(q_least(i) - limit.lower, limit, period);
    const double upper = SpeedTowards(limit.upper - q_most(i), limit, period);
    bounds.lower(i) = std::clamp(lower, slowest, fastest);
    bounds.upper(i) = std::max(bounds.lower(i), std::clamp(upper, slowest, fastest));
    if (lower > upper)
      bounds.lower(i) = bounds.upper(i) = std::clamp(0.5 * (lower + upper), slowest, fastest);
  }
  return bounds;
}

JointVector LimitAvoidance(const std::vector<JointLimits>& limits, const JointVector& q,
                           double share) noexcept {
  JointVector velocity(q.size());
  for (int i = 0; i < q.size(); ++i) {
    const JointLimits& limit = limits[i];
    const double place =
        (q(i) - 0.5 * (limit.lower + limit.upper)) / (0.5 * (limit.upper - limit.lower));
    const double depth = std::clamp((std::abs(place) - kCalm) / (1.0 - kCalm), 0.0, 1.0);
    velocity(i) = -std::copysign(depth * share * limit.velocity, place);
  }
  return velocity;
}

JointVector CompositeAscent(const ServoLawOptions& options, const std::vector<JointLimits>& limits,
                            const JointVector& gradient) noexcept {
  const auto n = static_cast<Eigen::Index>(limits.size());
  if (gradient.size() != n || !gradient.allFinite()) return JointVector::Zero(n);
  JointVector velocity = options.ascent_gain * gradient;
  double largest = 1.0;  // in units of what is allowed
  for (int i = 0; i < n; ++i) {
    const double allowed = options.self_motion * limits[i].velocity;
    if (std::abs(velocity(i)) > largest * allowed) largest = std::abs(velocity(i)) / allowed;
  }
  if (!std::isfinite(largest)) return JointVector::Zero(n);  // self_motion is 0
  return velocity / largest;
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

ServoLawResult ServoLaw(const ServoLawOptions& options, const ServoDemand& demand,
                        const TaskJacobian& J_c, const SingularSystem& system,
                        const VelocityBounds& bounds) noexcept {
  const int n = static_cast<int>(bounds.lower.size());
  const FeatureVector& e = demand.e;
  assert(J_c.cols() == n && J_c.rows() == e.size() && demand.e_rate.size() == e.size());
  ServoLawResult result;
  result.qdot = JointVector::Zero(n);
  if (system.measure.status != MeasureStatus::kOk || !e.allFinite() || !demand.e_rate.allFinite())
    return result;

  const double max_error = e.lpNorm<Eigen::Infinity>();
  result.lambda = options.textbook ? options.gain_at_zero : AdaptiveGain(options, max_error);
  const double rate =
      options.textbook
          ? result.lambda
          : std::min(result.lambda, options.max_error_rate / std::max(max_error, 1e-12));
  const FeatureVector target = -demand.effort * rate * e - demand.e_rate;

  const Measure& measure = system.measure;
  const double sigma_1 = measure.sigma(0);
  const bool moves_itself = demand.self_motion.size() == n;
  JointVector free = moves_itself ? demand.self_motion : JointVector(JointVector::Zero(n));
  std::array<double, kMaxJoints> mu2{};
  for (int i = 0; i < measure.size(); ++i) {
    // Directions below the rank tolerance carry no information: they are left alone.
    const double sigma = measure.sigma(i);
    if (sigma <= kSigmaTolerance * sigma_1) continue;
    if (!options.textbook && sigma < options.damping_onset) {
      const double ratio = sigma / options.damping_onset;
      mu2[i] = options.damping * options.damping * (1.0 - ratio * ratio);
      result.damping = std::sqrt(std::max(mu2[i], result.damping * result.damping));
    }
    double along = system.axes.col(i).dot(target) / (sigma * sigma + mu2[i]);
    if (moves_itself) along -= system.directions.col(i).dot(demand.self_motion);
    free += along * system.directions.col(i);
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
  // A trace of attraction to the wanted self-motion keeps the problem strictly convex when columns of J_c
  // depend on each other.
  const double floor = 1e-12 * sigma_1 * sigma_1 + 1e-12;
  JointMatrix H = J_c.transpose().lazyProduct(J_c);
  JointVector g = J_c.transpose().lazyProduct(target);
  H.diagonal().array() += floor;
  if (moves_itself) g += floor * demand.self_motion;
  for (int i = 0; i < measure.size(); ++i) {
    if (mu2[i] > 0.0) {
      const auto v = system.directions.col(i);
      H.noalias() += (mu2[i] * v).lazyProduct(v.transpose());
    }
  }
  const BoxSolution box = MinimiseInBox(H, g, bounds.lower, bounds.upper, free);
  result.qdot = box.x;
  result.bounds_active = box.active;
  return result;
}

}  // namespace vantage
