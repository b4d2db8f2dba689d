#pragma once

#include <vector>

#include "vantage/math/sizes.h"
#include "vantage/observability/measures.h"
#include "vantage/robot/arm_model.h"

/// @file
/// The joint velocity of one control period: bounded least squares on the image error.

namespace vantage {

/// Gains of the law. The gain falls from `gain_at_zero` to `gain_at_infinity` as the error grows, in
/// ViSP's form λ(x) = (λ0 - λ∞) exp(-x slope / (λ0 - λ∞)) + λ∞ with x = max |e| [px].
struct ServoLawOptions {
  double gain_at_zero{3.0};      ///< λ near the goal [1/s]; > 0.
  double gain_at_infinity{1.2};  ///< λ far from it [1/s]; > 0, <= gain_at_zero.
  double gain_slope{0.02};       ///< Slope at zero error [1/(s px)]; >= 0.
  double damping{10.0};          ///< Largest μ of the damped inverse [px/rad]; >= 0.
  double damping_onset{40.0};    ///< σ_min below which damping sets in [px/rad]; >= 0.
  double max_error_rate{800.0};  ///< Bound on the image speed asked for, max over rows [px/s]; > 0.
  /// The textbook's law, for comparison: the constant gain_at_zero, the pseudo-inverse without damping,
  /// each joint cut off at its bounds.
  bool textbook{false};
};

/// What bounds a joint in this period, after velocity, acceleration and position limits are put
/// together.
struct VelocityBounds {
  JointVector lower, upper;  ///< [rad/s or m/s]; lower <= upper.
};

/// Bounds on the joint velocity of the next period such that every later period can still respect
/// all limits (the joint can always brake before its stop).
///
/// @param q          Joint positions at the start of the period.
/// @param qdot       Velocity commanded in the last period.
/// @param period     [s]; > 0.
/// When limits contradict each other (the arm starts outside them) the acceleration limit wins, and
/// the joint brakes, or creeps back inside, as fast as it allows. Real-time safe.
[[nodiscard]] VelocityBounds ComputeVelocityBounds(const std::vector<JointLimits>& limits,
                                                   const JointVector& q, const JointVector& qdot,
                                                   double period) noexcept;

/// Velocity that comes to rest as fast as the acceleration limits allow. Real-time safe.
[[nodiscard]] JointVector RampToRest(const std::vector<JointLimits>& limits,
                                     const JointVector& qdot, double period) noexcept;

/// λ for an error of `max_error` pixels [1/s].
[[nodiscard]] double AdaptiveGain(const ServoLawOptions& options, double max_error) noexcept;

/// Outcome of one period.
struct ServoLawResult {
  JointVector qdot;      ///< Within the bounds; zero when not finite.
  bool finite{false};    ///< False: an input or the result was not; qdot is zero.
  int bounds_active{0};  ///< Joints that stand at a bound.
  double lambda{0.0};    ///< Gain used [1/s].
  double damping{0.0};   ///< μ used [px/rad].
};

/// min ‖J_c q̇ + λ e + ė_ext‖² + μ² ‖q̇‖² subject to bounds.lower <= q̇ <= bounds.upper.
///
/// μ² = damping² (1 - (σ_min/onset)²) below the onset, else 0; without damping the solution of least
/// norm. While no bound is active this is the damped pseudo-inverse, by singular values.
///
/// @param e       Image error s - s*, k rows [px].
/// @param J_c     k×n [px/rad]; n = bounds.lower.size().
/// @param system  Decompose(J_c): the measures need it anyway.
/// @param e_rate  ė_ext: the error's rate that the joints do not cause (camera and goal motion) [px/s].
/// Real-time safe.
/// @see F. Chaumette, S. Hutchinson, "Visual servo control, Part I", IEEE RAM 13(4), 2006;
///   Y. Nakamura, H. Hanafusa, J. Dyn. Sys. Meas. Control 108, 1986 (variable damping).
[[nodiscard]] ServoLawResult ServoLaw(const ServoLawOptions& options, const FeatureVector& e,
                                      const TaskJacobian& J_c, const SingularSystem& system,
                                      const FeatureVector& e_rate,
                                      const VelocityBounds& bounds) noexcept;

}  // namespace vantage
