#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "vantage/math/sizes.h"
#include "vantage/math/spatial.h"

/// @file
/// Camera rigs: the camera's configuration space q_c (paper, eq. 4) with its limits.

namespace vantage {

/// How a spherical rig turns its camera.
enum class RigOrientation {
  kLookAt,     ///< Optical axis through the target: R_WC = [e_phi | e_theta | -e_r] Rz(roll).
  kFixedDown,  ///< Optical axis along -Wz (paper, section 6): R_WC = diag(1, -1, -1) Rz(roll).
};

enum class RigKind {
  kFixed,      ///< No axes: the camera stands at `X_WC_fixed`.
  kSpherical,  ///< (R [m], theta [rad], phi [rad], roll [rad]) about `target_W`.
};

/// Bounds of one rig axis.
struct RigAxis {
  std::string name;             ///< "R", "theta", ...
  double lower{0.0};            ///< [m] or [rad].
  double upper{0.0};            ///< [m] or [rad]; >= lower.
  double max_speed{0.0};        ///< [m/s] or [rad/s]; >= 0. 0 locks the axis where it starts.
  double max_acceleration{0.0}; ///< [m/s²] or [rad/s²]; > 0 when max_speed > 0.
};

/// A rig: data only; what it does is in the functions below.
struct CameraRig {
  RigKind kind{RigKind::kFixed};
  RigOrientation orientation{RigOrientation::kLookAt};
  Eigen::Vector3d target_W{Eigen::Vector3d::Zero()};              ///< Sphere's centre [m].
  Eigen::Isometry3d X_WC_fixed{Eigen::Isometry3d::Identity()};    ///< Of a fixed rig.
  std::vector<RigAxis> axes;                                      ///< As the kind says.
  double max_linear_speed{0.4};  ///< Bound on the camera's own speed, all axes together [m/s].

  [[nodiscard]] int size() const noexcept { return static_cast<int>(axes.size()); }
};

/// Spherical frame of PAPER_NOTES 14: e_r = (sθ cφ, sθ sφ, cθ), e_theta = (cθ cφ, cθ sφ, -sθ),
/// e_phi = (-sφ, cφ, 0); camera at target + R e_r. Defined at the poles too.
///
/// @param orientation  See RigOrientation.
/// @param q_c          (R [m], theta [rad], phi [rad], roll [rad]).
[[nodiscard]] Eigen::Isometry3d SphericalPose(RigOrientation orientation,
                                              const Eigen::Vector3d& target_W,
                                              const Eigen::Vector4d& q_c) noexcept;

/// Pose of the rig's camera at q_c.
/// @pre q_c.size() == rig.size().
[[nodiscard]] Eigen::Isometry3d RigPose(const CameraRig& rig, const RigVector& q_c) noexcept;

/// 6×m Jacobian of RigPose(): V_WC_C = J * q̇_c (camera twist in camera axes). Closed form.
[[nodiscard]] Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::ColMajor, 6, kMaxRigAxes> RigJacobian(
    const CameraRig& rig, const RigVector& q_c) noexcept;

/// The rig coordinates whose pose is nearest to X_WC (position first, then orientation), inside the
/// limits; angles are taken on the turn nearest to q_c_near.
[[nodiscard]] RigVector NearestRigCoordinates(const CameraRig& rig, const Eigen::Isometry3d& X_WC,
                                              const RigVector& q_c_near) noexcept;

/// q_c moved into the axis limits.
[[nodiscard]] RigVector ClampToLimits(const CameraRig& rig, const RigVector& q_c) noexcept;

/// Throws ConfigError (key "camera_rig...") when limits, speeds or the number of axes do not fit the
/// kind.
void Validate(const CameraRig& rig);

}  // namespace vantage
