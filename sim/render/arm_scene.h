#pragma once

#include <vector>

#include "sim/render/scene.h"
#include "vantage/robot/arm_model.h"

namespace vantage::sim {

/// How an arm without meshes looks.
struct ArmLook {
  Eigen::Vector3f link{0.90F, 0.42F, 0.08F};  ///< Red, green, blue; 0 to 1.
  Eigen::Vector3f joint{0.24F, 0.26F, 0.29F};
  Eigen::Vector3f base{0.30F, 0.32F, 0.35F};
  Eigen::Vector3f plate{0.36F, 0.38F, 0.41F};  ///< What the markers are glued on.
  int segments{24};                            ///< Vertices round a link; >= 3.
};

/// Bodies of an arm from its capsules, with a drum at each revolute joint that stands on the arm and a
/// rail at each prismatic one. The joints' axes are found from the forward kinematics, so that any
/// convention of link frames will do.
[[nodiscard]] std::vector<Body> MakeArmBodies(const ArmModel& arm, const ArmLook& look = {});

/// A whole scene: the arm, `tool_markers` on plates on its end effector, `world_markers` on plates in
/// the world.
[[nodiscard]] Scene MakeArmScene(const ArmModel& arm, const std::vector<Marker>& tool_markers,
                                 const std::vector<Marker>& world_markers,
                                 const ArmLook& look = {});

}  // namespace vantage::sim
