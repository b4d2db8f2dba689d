#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

/// @file
/// Rigid motions. A twist is (v, ω): the velocity of the frame's origin [m/s], then the angular
/// velocity [rad/s]. A pose X_AB maps coordinates in B to coordinates in A: p_AP = X_AB * p_BP.

namespace vantage {

/// Velocity of a body: (v [m/s], omega [rad/s]).
using Twist = Eigen::Matrix<double, 6, 1>;
/// Maps twists.
using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// Matrix of the cross product: Skew(a) * b = a × b.
[[nodiscard]] Eigen::Matrix3d Skew(const Eigen::Vector3d& a) noexcept;

/// Twist map of one rigid body between two frames fixed to it: V_WA_A = AdjointMap(X_AB) * V_WB_B.
///
/// @return 6×6; the upper right block is in [m].
/// @see K. M. Lynch, F. C. Park, "Modern Robotics", Cambridge 2017, sec. 3.3.2 (there (ω, v)).
[[nodiscard]] Matrix6d AdjointMap(const Eigen::Isometry3d& X_AB) noexcept;

/// Pose reached from X_WA by moving for 1 s at a constant twist V_WA_A, that is X_WA * exp(V).
/// V may be any step: a displacement (translation [m], rotation vector [rad]).
[[nodiscard]] Eigen::Isometry3d Advance(const Eigen::Isometry3d& X_WA,
                                        const Twist& step_A) noexcept;

/// The displacement that Advance() needs to go from X_WA to X_WB; rotation angle in [0, π].
[[nodiscard]] Twist Displacement(const Eigen::Isometry3d& X_WA,
                                 const Eigen::Isometry3d& X_WB) noexcept;

/// The pose a fraction of the way from X_WA to X_WB, on the screw motion that leads there: 0 is X_WA, 1 is
/// X_WB; beyond them, the motion goes on.
[[nodiscard]] Eigen::Isometry3d PoseBetween(const Eigen::Isometry3d& X_WA,
                                            const Eigen::Isometry3d& X_WB,
                                            double fraction) noexcept;

/// Angle of the one rotation that takes A's axes to B's [rad], in [0, π]; of the axes of two poses:
/// AngleBetween(X_WA.linear(), X_WB.linear()).
[[nodiscard]] double AngleBetween(const Eigen::Matrix3d& R_WA,
                                  const Eigen::Matrix3d& R_WB) noexcept;

/// True when every entry is finite and the rotation is orthonormal to 1e-6.
[[nodiscard]] bool IsPose(const Eigen::Isometry3d& X) noexcept;

}  // namespace vantage
