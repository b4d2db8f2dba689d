#pragma once

#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <kdl/frames.hpp>
#include <kdl/segment.hpp>

#include "vantage/robot/arm_model.h"

/// @file
/// Private to the module: the arm in KDL's terms.

namespace vantage {

[[nodiscard]] inline KDL::Frame ToKdl(const Eigen::Isometry3d& X) {
  const auto R = X.linear();
  const auto p = X.translation();
  return KDL::Frame(KDL::Rotation(R(0, 0), R(0, 1), R(0, 2), R(1, 0), R(1, 1), R(1, 2), R(2, 0),
                                  R(2, 1), R(2, 2)),
                    KDL::Vector(p.x(), p.y(), p.z()));
}

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

/// One joint with its link. The segment's joint is always RotZ or TransZ: KDL's joints about an
/// arbitrary axis cache their last pose in a mutable member, which two threads would race for.
struct ArmJoint {
  bool has_before{false};  ///< X_before is not the identity.
  KDL::Frame X_before{KDL::Frame::Identity()};
  KDL::Segment segment;
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
  KDL::Frame base;  ///< X_WBase.
  KDL::Frame tool;  ///< X_LastE.

  [[nodiscard]] int size() const noexcept { return static_cast<int>(joints.size()); }
};

}  // namespace vantage
