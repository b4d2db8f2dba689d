#pragma once

#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <kdl/frames.hpp>

#include "vantage/robot/arm_model.h"

/// @file
/// Private to the module: what an ArmModel holds, and frames from KDL, which knows the conventions of Denavit
/// and Hartenberg.

namespace vantage {

[[nodiscard]] inline Eigen::Vector3d FromKdl(const KDL::Vector& p) {
  return {p.x(), p.y(), p.z()};
}

[[nodiscard]] inline Eigen::Isometry3d FromKdl(const KDL::Frame& X) {
  Eigen::Isometry3d result = Eigen::Isometry3d::Identity();
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) result.linear()(i, j) = X.M(i, j);
  }
  result.translation() = FromKdl(X.p);
  return result;
}

/// One joint with its link: X_before, the joint's motion, X_after.
struct ArmJoint {
  JointKind kind{JointKind::kRevolute};
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
