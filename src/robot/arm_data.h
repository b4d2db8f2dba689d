#pragma once

#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "vantage/robot/arm_model.h"

/// @file
/// Private to the module: what an ArmModel holds.

namespace vantage {

/// What stands about a joint's motion: X_before, the motion, X_after to the joint's link.
struct ArmJoint {
  bool has_before{false};  ///< X_before is not the identity.
  Eigen::Isometry3d X_before{Eigen::Isometry3d::Identity()};
  Eigen::Isometry3d X_after{Eigen::Isometry3d::Identity()};
};

struct ArmModel::Data {
  std::string name;
  std::vector<std::string> joint_names;
  std::vector<JointKind> joint_kinds;
  std::vector<JointLimits> limits;
  std::vector<Capsule> capsules;
  std::vector<ArmVisual> visuals;
  Eigen::Isometry3d X_WBase{Eigen::Isometry3d::Identity()};
  Eigen::Isometry3d X_LastE{Eigen::Isometry3d::Identity()};

  std::vector<ArmJoint> joints;
  /// What stands between two joints' motions, multiplied out: chain[0] from the base to joint 0,
  /// chain[n] from the last joint to E. Kept by UpdateChain().
  std::vector<Eigen::Isometry3d> chain;

  [[nodiscard]] int size() const noexcept { return static_cast<int>(joints.size()); }

  void UpdateChain() {
    chain.clear();
    Eigen::Isometry3d X = X_WBase;
    for (const ArmJoint& joint : joints) {
      chain.push_back(joint.has_before ? X * joint.X_before : X);
      X = joint.X_after;
    }
    chain.push_back(X * X_LastE);
  }
};

}  // namespace vantage
