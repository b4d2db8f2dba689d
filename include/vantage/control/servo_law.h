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
  double damping_onset{40.0};    ///< σ_i below which its direction is damped [px/rad]; >= 0.
  double max_error_rate{800.0};  ///< Bound on the image speed asked for, max over rows [px/s]; > 0.
  /// Time constant with which the task's gain comes up after a rest [s]; 0: at once.
  double start_time{0.1};
  /// Ascent of log w_c by joint motions that the features do not see [rad²/s]; 0: none. Where the features
  /// leave the joints no freedom it does nothing.
  double ascent_gain{0.2};
  /// Share of a joint's velocity limit that motions the features do not see may use; in [0, 1].
  double self_motion{0.2};
  /// The textbook's law, for comparison: the constant gain_at_zero, the pseudo-inverse without damping,
  /// each joint cut off at its bounds.
  bool textbook{false};
};

/// What bounds a joint in this period, after velocity, acceleration and position limits are put
/// together.
struct VelocityBounds {
  JointVector lower;  ///< Least velocity of each joint [rad/s or m/s].
  JointVector upper;  ///< Greatest velocity of each joint [rad/s or m/s]; >= lower.
};

/// Bounds on the joint velocity of the next period such that every later period can still respect
/// all limits (the joint can always brake before its stop).
///
/// @param q_least    Joint positions at the start of the period...
/// @param q_most     ...of which only bounds are known: where the arm is and where it was told to be by now
///                   differ by what it lags behind. Each limit minds the nearer one.
/// @param qdot       Velocity commanded in the last period.
/// @param period     [s]; > 0.
/// When limits contradict each other (the arm starts outside them) the acceleration limit wins, and
/// the joint brakes, or creeps back inside, as fast as it allows. Real-time safe.
[[nodiscard]] VelocityBounds ComputeVelocityBounds(const std::vector<JointLimits>& limits,
                                                   const JointVector& q_least,
                                                   const JointVector& q_most,
                                                   const JointVector& qdot, double period) noexcept;

/// Velocity away from the position limits for joints in the outer parts of their ranges: grows from 0 at
/// seven tenths of the way from the middle to `share` of the velocity limit at the stop. Real-time safe.
[[nodiscard]] JointVector LimitAvoidance(const std::vector<JointLimits>& limits,
                                         const JointVector& q, double share) noexcept;

/// Velocity up the gradient of log w_c [1/rad]: ascent_gain times it, scaled down as a whole to
/// self_motion of the velocity limits. 0 for a gradient of another size or not finite. Real-time safe.
[[nodiscard]] JointVector CompositeAscent(const ServoLawOptions& options,
                                          const std::vector<JointLimits>& limits,
                                          const JointVector& gradient) noexcept;

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
  double damping{0.0};   ///< Largest μ_i used [px/rad].
};

/// What one period asks of the joints.
struct ServoDemand {
  FeatureVector e;  ///< Image error s - s*, k rows [px].
  FeatureVector
      e_rate;  ///< ė_ext: the error's rate that the joints do not cause (camera, goal) [px/s].
  double effort{1.0};  ///< Share of the gain, in [0, 1]: less at a smooth start.
  /// Joint velocity wanted where the features do not mind; n or no rows (none).
  JointVector self_motion{};
};

/// min ‖J_c q̇ + λ e + ė_ext‖² + Σ μ_i² (v_iᵀ q̇)² subject to bounds.lower <= q̇ <= bounds.upper, and of all
/// minimisers the one nearest to demand.self_motion.
///
/// μ_i² = damping² (1 - (σ_i/onset)²) for σ_i below the onset, else 0: what is seen well keeps its exact
/// inverse. Without damping and self-motion this is the solution of least norm. While no bound is active it
/// comes from the singular values; with bounds, to 1e-6 or so, from a solver for the box.
///
/// @param J_c     k×n [px/rad]; n = bounds.lower.size().
/// @param system  Decompose(J_c): the measures need it anyway.
/// Real-time safe.
/// @see F. Chaumette, S. Hutchinson, "Visual servo control, Part I", IEEE RAM 13(4), 2006;
///   Y. Nakamura, H. Hanafusa, J. Dyn. Sys. Meas. Control 108, 1986 (variable damping); A. Maciejewski,
///   C. Klein, J. Robotic Systems 5, 1988 (of single directions).
[[nodiscard]] ServoLawResult ServoLaw(const ServoLawOptions& options, const ServoDemand& demand,
                                      const TaskJacobian& J_c, const SingularSystem& system,
                                      const VelocityBounds& bounds) noexcept;

}  // namespace vantage
