#pragma once

#include <map>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <urdf_model/model.h>

#include "urdf_document.h"
#include "vantage/robot/arm_model.h"

/// @file
/// Private to the module: the joints between two links of a URDF file, and what hangs on them.

namespace vantage {

[[nodiscard]] Eigen::Isometry3d ToEigen(const urdf::Pose& pose);
[[nodiscard]] Eigen::Vector3d ToEigen(const urdf::Vector3& v);

/// The joints from the base link down to the tip link, fixed ones among them.
struct UrdfChain {
  std::string base_link, tip_link;
  std::vector<urdf::JointConstSharedPtr> joints;
  /// Links that would have done as well for a tip that was not named.
  std::vector<std::string> other_tips;
};

/// Finds the chain; empty names stand for defaults. Throws ConfigError.
[[nodiscard]] UrdfChain FindChain(const UrdfDocument& document, const std::string& base_link,
                                  const std::string& tip_link);

/// The joints of the chain that move, in order. Throws ConfigError when one cannot be part of an arm,
/// there is none, or there are too many.
[[nodiscard]] std::vector<urdf::JointConstSharedPtr> MovingJoints(const UrdfDocument& document,
                                                                  const UrdfChain& chain);

/// Where a URDF link sits: on which of the arm's links (-1: base), and how.
struct Attachment {
  int link{-1};
  Eigen::Isometry3d X_LU{
      Eigen::Isometry3d::Identity()};  ///< The URDF link's frame in the arm link's.
};

/// Of each link of the file. Joints off the chain are frozen; those whose value that fixes are named in
/// *frozen.
[[nodiscard]] std::map<std::string, Attachment> AttachLinks(const UrdfDocument& document,
                                                            const UrdfChain& chain,
                                                            std::vector<std::string>* frozen);

}  // namespace vantage
