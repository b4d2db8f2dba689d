#pragma once

#include <Eigen/Geometry>

#include "vantage/camera/camera_rig.h"
#include "vantage/robot/arm_model.h"

namespace vantage {

/// The rig of a camera that a second arm carries: one axis for each of its joints, with their names,
/// limits, speeds and accelerations. The arm's body is no obstacle to the view (docs/active-camera.md).
///
/// @param X_EC              Camera in the carrying arm's end effector.
/// @param max_linear_speed  Bound on the camera's own speed [m/s].
/// Throws ConfigError when what comes out does not validate.
[[nodiscard]] CameraRig RigOnArm(const ArmModel& arm, const Eigen::Isometry3d& X_EC,
                                 double max_linear_speed);

}  // namespace vantage
