#pragma once

#include <string>
#include <vector>

#include "vantage/robot/arm_model.h"

/// @file
/// Arms from URDF files, read through urdfdom.

namespace vantage {

/// How a URDF file is read.
struct UrdfOptions {
  /// Folders that package://name/... is looked up in: each is the package itself or holds it. The
  /// folders above the URDF file are looked through as well.
  std::vector<std::string> package_folders;
  /// URDF has no acceleration limits. Each joint's is its velocity limit divided by this time [s];
  /// > 0.
  double acceleration_time{0.2};
};

/// An arm from a URDF file.
struct UrdfArm {
  ArmModel arm;           ///< The joints from base_link to tip_link.
  std::string base_link;  ///< Its frame is the world frame W of the arm.
  std::string tip_link;   ///< Its frame is the end effector frame E.
  /// What is missing and was replaced: each a sentence that names file and element.
  std::vector<std::string> warnings;
  /// What the file leaves open and was chosen.
  std::vector<std::string> notes;
};

/// Reads the chain from base_link to tip_link.
///
/// Without a base link the file's root is taken. Without a tip link the chain with the most moving
/// joints is taken; it ends before mimic joints and those that others mimic (grippers). The tip is then
/// a link of its last body called ...tool0..., ...tcp..., ...end_effector... or ...ee_link..., in this
/// order, else the one behind the most fixed joints.
///
/// Joints of the arm are revolute, continuous and prismatic ones; their names are the file's, and link
/// i's frame is that of the URDF link behind joint i. Fixed joints are merged into them. Joints off
/// the chain are frozen, at 0 or the nearest value within their limits.
///
/// A continuous joint gets the range ±2π. Capsules are fitted to each link's collision geometry, or to
/// the visual one when there is no other; capsules within others of the same link are left out. A mesh
/// that cannot be read is a warning: a capsule from joint to joint takes its place.
///
/// Throws ConfigError, with file, line, element and reason, when the file is missing, too large, no
/// valid XML or no valid URDF; a link is unknown; the chain is ambiguous, empty or longer than
/// kMaxJoints; a joint of the chain is floating or planar, mimics another or lacks limits.
[[nodiscard]] UrdfArm LoadUrdfArm(const std::string& path, const std::string& base_link = "",
                                  const std::string& tip_link = "",
                                  const UrdfOptions& options = {});

/// Folders that ROS keeps packages in: of ROS_PACKAGE_PATH, and share/ of those of AMENT_PREFIX_PATH.
[[nodiscard]] std::vector<std::string> RosPackageFolders();

}  // namespace vantage
