#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "vantage/camera/camera_model.h"
#include "vantage/features/feature_set.h"
#include "vantage/math/sizes.h"
#include "vantage/math/spatial.h"

/// @file
/// How a number φ that is made of an image Jacobian changes with the camera and with the joints: the
/// second derivatives of the features, contracted with ∂φ/∂J. With GradientOfLog() of
/// observability/measures.h for ∂φ/∂J they are the gradients of log w_v and log w_c; any other function
/// of J_v or J_c will do.
///
/// Closed forms: the features' second derivatives by their pixels (PixelHessian()), those of the
/// projection, and those of the arm's points, which follow from the columns of J_r alone.

namespace vantage {

/// Where camera and end effector stand and what the joints do.
struct ViewGeometry {
  Eigen::Isometry3d X_WC{Eigen::Isometry3d::Identity()};  ///< Camera pose.
  Eigen::Vector3d p_WE{Eigen::Vector3d::Zero()};          ///< E's origin [m].
  /// 6×n, columns from the base to the tip: that order decides which joint moves which.
  ArmJacobian J_r{ArmJacobian::Zero(6, 1)};
  bool eye_in_hand{false};  ///< The camera is carried by E.
};

/// Gradient of φ.
struct ViewGradient {
  /// By a displacement δ = (translation [m], rotation vector [rad]) of the camera in its own axes,
  /// X_WC -> X_WC exp(δ), of a carried camera X_EC -> X_EC exp(δ). By the coordinates of a rig it is
  /// RigJacobian()ᵀ times this.
  Twist camera{Twist::Zero()};
  /// By the entries [fx skew; - fy] of the camera's matrix [1/px]; (1, 0) has no meaning and is 0.
  /// By a common focal length fx = fy = f it is the trace.
  Eigen::Matrix2d calibration{Eigen::Matrix2d::Zero()};
  JointVector joints;  ///< n, by the joints [1/rad or 1/m]; a carried camera goes with them.
};

/// Gradient of φ(J_c).
///
/// @param views  As FeatureSet::Evaluate() had them.
/// @param rows   What it made of them: row i of J_c belongs to feature rows.feature[i].
/// @param by_J_c ∂φ/∂J_c, k×n.
/// @pre by_J_c.rows() == rows.size(), by_J_c.cols() == geometry.J_r.cols().
[[nodiscard]] ViewGradient GradientThroughComposite(
    const FeatureSet& set, const CameraModel& camera, const PointViews& views,
    const FeatureRows& rows, const ViewGeometry& geometry, const TaskJacobian& by_J_c);

/// Gradient of φ(J_v).
/// @param by_J_v  ∂φ/∂J_v, k×6.
/// @pre by_J_v.rows() == rows.size(), by_J_v.cols() == 6.
[[nodiscard]] ViewGradient GradientThroughView(const FeatureSet& set, const CameraModel& camera,
                                               const PointViews& views, const FeatureRows& rows,
                                               const ViewGeometry& geometry,
                                               const TaskJacobian& by_J_v);

}  // namespace vantage
