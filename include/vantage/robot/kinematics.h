#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "vantage/math/sizes.h"
#include "vantage/robot/arm_model.h"

namespace vantage {

/// Pose and Jacobian of the end effector at one configuration.
struct Kinematics {
  Eigen::Isometry3d X_WE{Eigen::Isometry3d::Identity()};  ///< Pose of the end effector.
  /// 6×n: V_WE_W = J_WE_W q̇, the velocity of E's origin [m/s] and E's angular velocity [rad/s], both
  /// in world axes. This is the paper's J_r (eq. 18).
  ArmJacobian J_WE_W{ArmJacobian::Zero(6, 1)};
};

/// Forward kinematics, from the base out.
/// @pre q.size() == arm.size(). Real-time safe.
[[nodiscard]] Kinematics ComputeKinematics(const ArmModel& arm, const JointVector& q) noexcept;

/// Pose of the end effector alone. Real-time safe.
[[nodiscard]] Eigen::Isometry3d EndEffectorPose(const ArmModel& arm, const JointVector& q) noexcept;

/// Poses of the links 0..n-1 in W (array entries past n-1 are identity). The base is not in it: its
/// pose is X_WBase. Real-time safe.
using LinkPoses = std::array<Eigen::Isometry3d, kMaxJoints>;
[[nodiscard]] LinkPoses ComputeLinkPoses(const ArmModel& arm, const JointVector& q) noexcept;

/// One capsule of the arm, placed in the world.
struct PlacedCapsule {
  Eigen::Vector3d p_WA;  ///< One end of the axis [m].
  Eigen::Vector3d p_WB;  ///< The other end [m].
  double radius;         ///< [m].
  int link;              ///< As in Capsule.
};

/// The arm's capsules at q, written to *out (its capacity is kept). Real-time safe once *out has the
/// capacity of arm.capsules().
void PlaceCapsules(const ArmModel& arm, const JointVector& q, std::vector<PlacedCapsule>* out);

/// True when the segment from p_WA to p_WB passes through the capsule. Real-time safe.
[[nodiscard]] bool SegmentHitsCapsule(const Eigen::Vector3d& p_WA, const Eigen::Vector3d& p_WB,
                                      const PlacedCapsule& capsule) noexcept;

/// Joint configuration that brings points fixed to the end effector onto points in the world.
struct PointGoalSolution {
  JointVector q;          ///< Within the arm's limits.
  double rms_error{0.0};  ///< Root mean square distance left [m].
  bool converged{false};  ///< rms_error below the tolerance asked for.
};

/// Levenberg-Marquardt with the joints' limits as bounds on |X_WE(q) p_EP - p_WP| over all points.
///
/// @param q_start    Where the search starts; the nearest branch is found.
/// @param tolerance  rms error that counts as converged [m].
/// @pre p_EP.size() == p_WP.size() >= 1.
[[nodiscard]] PointGoalSolution SolveForPoints(const ArmModel& arm,
                                               const std::vector<Eigen::Vector3d>& p_EP,
                                               const std::vector<Eigen::Vector3d>& p_WP,
                                               const JointVector& q_start, double tolerance = 1e-6);

}  // namespace vantage
