#pragma once

#include <map>
#include <string>
#include <vector>

#include "urdf_chain.h"
#include "urdf_document.h"
#include "vantage/robot/arm_visual.h"

/// @file
/// Private to the module: bodies of the links of a URDF file, for occlusion and for the eye.

namespace vantage {

struct UrdfBodies {
  std::vector<Capsule> capsules;
  std::vector<ArmVisual> visuals;
};

/// @param stand_in_radius  Of the capsules from joint to joint that replace meshes [m].
/// Appends to *warnings what is missing. Throws ConfigError for shapes without size.
[[nodiscard]] UrdfBodies MakeBodies(const UrdfDocument& document,
                                    const std::map<std::string, Attachment>& attachments,
                                    const std::vector<std::string>& package_folders,
                                    double stand_in_radius, std::vector<std::string>* warnings);

}  // namespace vantage
