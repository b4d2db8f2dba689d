#pragma once

#include "vantage/camera/camera_pose.h"
#include "vantage/camera/camera_rig.h"

namespace vantage::sim {

/// A camera on a rig: follows pose commands at bounded speeds. What the rig cannot reach it does not.
class RigPlant {
 public:
  /// Throws ConfigError when the rig does not validate.
  RigPlant(CameraRig rig, const RigVector& q_c_start);

  /// The rig coordinates nearest to the commanded pose become the target. A pose that is not one is
  /// not obeyed.
  void Accept(const CameraPose& command);

  /// Moves the rig for dt [s].
  void Step(double dt);

  /// Where the camera truly is.
  [[nodiscard]] Eigen::Isometry3d X_WC() const { return RigPose(rig_, q_c_); }

 private:
  CameraRig rig_;
  RigVector q_c_, target_;
};

}  // namespace vantage::sim
