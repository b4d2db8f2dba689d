#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "vantage/math/sizes.h"
#include "vantage/math/spatial.h"

/// @file
/// Camera rigs: the camera's configuration space q_c (paper, eq. 4) with its limits.
///
/// Axes are metres and radians. Most kinds end in a pan-tilt head, a turn in the camera's own frame:
/// R(pan, tilt, roll) = Ry(pan) Rx(tilt) Rz(roll), zero where the rig alone would point the camera.
/// Positive pan turns the view to the right, positive tilt turns it up.

namespace vantage {

/// How a spherical rig turns its camera.
enum class RigOrientation {
  kLookAt,     ///< Optical axis through the target: R_WC = [e_phi | e_theta | -e_r] Rz(roll).
  kFixedDown,  ///< Optical axis along -Wz (paper, section 6): R_WC = diag(1, -1, -1) Rz(roll).
};

/// What carries a camera; the order of q_c's axes is each kind's own.
enum class RigKind {
  kFixed,      ///< No axes: the camera stands at `X_WC_fixed`.
  kSpherical,  ///< (R [m], theta [rad], phi [rad], roll [rad]) about `target_W`; or six axes: those,
               ///< then (pan, tilt), with R_WC = [e_phi | e_theta | -e_r] R(pan, tilt, roll).
  kPanTilt,    ///< (pan, tilt): turns about the centre of `X_WC_fixed`.
  kRail,       ///< (s [m]) or (s, pan, tilt): `X_WC_fixed` moved by s along `rail_W`, then turned.
  kFree,       ///< (x, y, z [m], pan, tilt, roll): `X_WC_fixed` moved by (x, y, z) along W's axes,
               ///< then turned in its own frame.
  kArm,  ///< Carried by an arm of its own: one axis for each of `joints`; `X_WC_fixed` at all 0.
};

/// One joint of the arm that carries a camera, by its axis where all joints stand at 0.
struct RigJoint {
  bool prismatic{false};  ///< Slides along its axis [m]; false: turns about it [rad].
  Eigen::Vector3d axis_W{Eigen::Vector3d::UnitZ()};  ///< Unit direction.
  Eigen::Vector3d point_W{Eigen::Vector3d::Zero()};  ///< On the axis of a revolute joint [m].
};

/// Bounds of one rig axis.
struct RigAxis {
  std::string name;              ///< "R", "theta", ...
  double lower{0.0};             ///< [m] or [rad].
  double upper{0.0};             ///< [m] or [rad]; >= lower.
  double max_speed{0.0};         ///< [m/s] or [rad/s]; >= 0. 0 locks the axis where it starts.
  double max_acceleration{0.0};  ///< [m/s²] or [rad/s²]; > 0 when max_speed > 0.
};

/// A rig: data only; what it does is in the functions below.
struct CameraRig {
  RigKind kind{RigKind::kFixed};  ///< What carries the camera; gives q_c its axes and their order.
  RigOrientation orientation{RigOrientation::kLookAt};          ///< Of a spherical rig.
  Eigen::Vector3d target_W{Eigen::Vector3d::Zero()};            ///< Sphere's centre [m].
  Eigen::Isometry3d X_WC_fixed{Eigen::Isometry3d::Identity()};  ///< Zero pose of the other kinds.
  Eigen::Vector3d rail_W{Eigen::Vector3d::UnitX()};             ///< Unit direction of a rail.
  std::vector<RigJoint> joints;                                 ///< Of an arm, base first.
  std::vector<RigAxis> axes;                                    ///< As the kind says.
  double max_linear_speed{0.4};  ///< Bound on the camera's own speed, all axes together [m/s]; > 0.

  [[nodiscard]] int size() const noexcept { return static_cast<int>(axes.size()); }
};

/// 6×m Jacobian of a rig.
using RigJacobianMatrix = Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::ColMajor, 6, kMaxRigAxes>;

/// Indices of the axes that turn the camera about its own centre, -1 for those the rig has not.
struct RigHead {
  int pan{-1};   ///< Turns the view to the right.
  int tilt{-1};  ///< Turns the view up.
  int roll{-1};  ///< Turns it about the optical axis.
};

/// True when the axis is an angle, false when it is a length.
/// @pre 0 <= axis < rig.size().
[[nodiscard]] bool AxisTurns(const CameraRig& rig, int axis) noexcept;

/// Spherical frame (docs/paper.md): e_r = (sθ cφ, sθ sφ, cθ), e_theta = (cθ cφ, cθ sφ, -sθ),
/// e_phi = (-sφ, cφ, 0); camera at target + R e_r. Defined at the poles too.
///
/// @param orientation  See RigOrientation.
/// @param q_c          (R [m], theta [rad], phi [rad], roll [rad]).
[[nodiscard]] Eigen::Isometry3d SphericalPose(RigOrientation orientation,
                                              const Eigen::Vector3d& target_W,
                                              const Eigen::Vector4d& q_c) noexcept;

/// Pose of the rig's camera at q_c. Real-time safe.
/// @pre q_c.size() == rig.size().
[[nodiscard]] Eigen::Isometry3d RigPose(const CameraRig& rig, const RigVector& q_c) noexcept;

/// Poses at chosen combinations of axis values. For many poses: of a spherical rig without a head each value costs
/// its sine once and not with every pose.
/// @param values  Of each axis [m or rad].
/// @param pick    For each pose an index into the values of each axis, one pose after the other.
/// @pre values.size() == rig.size(); pick.size() is a multiple of it.
void RigPoses(const CameraRig& rig, const std::vector<std::vector<double>>& values,
              const std::vector<int>& pick, std::vector<Eigen::Isometry3d>* X_WC);

/// 6×m Jacobian of RigPose(): V_WC_C = J * q̇_c (camera twist in camera axes). Closed form. Real-time
/// safe.
[[nodiscard]] RigJacobianMatrix RigJacobian(const CameraRig& rig, const RigVector& q_c) noexcept;

/// The rig coordinates whose pose is nearest to X_WC (position first, then orientation), inside the
/// limits; angles are taken on the turn nearest to q_c_near that the limits allow. Locked axes keep
/// the value of q_c_near. For an arm: the nearest on the branch that a search from q_c_near finds, where
/// a radian of orientation weighs as much as a decimetre. Real-time safe.
///
/// @param arm_steps  Most steps of that search; with fewer it may stop short.
/// @pre q_c_near.size() == rig.size().
[[nodiscard]] RigVector NearestRigCoordinates(const CameraRig& rig, const Eigen::Isometry3d& X_WC,
                                              const RigVector& q_c_near,
                                              int arm_steps = 100) noexcept;

/// q_c moved into the axis limits.
[[nodiscard]] RigVector ClampToLimits(const CameraRig& rig, const RigVector& q_c) noexcept;

/// The head's axes of this rig.
[[nodiscard]] RigHead HeadOf(const CameraRig& rig) noexcept;

/// q_c with pan and tilt set so that the optical axis passes through p_W, as far as the limits and
/// locked axes allow; the other axes as they are. q_c itself where the rig has no head or p_W is the
/// camera's centre. Real-time safe.
[[nodiscard]] RigVector AimAt(const CameraRig& rig, const RigVector& q_c,
                              const Eigen::Vector3d& p_W) noexcept;

/// Throws ConfigError (key "camera_rig...") when limits, speeds or the number of axes do not fit the
/// kind.
void Validate(const CameraRig& rig);

}  // namespace vantage
