#pragma once

#include <string>
#include <vector>

#include "sim/render/scene.h"
#include "vantage/robot/arm_model.h"

namespace vantage::sim {

/// How an arm looks where its description does not say.
struct ArmLook {
  Eigen::Vector3f link{0.90F, 0.42F, 0.08F};  ///< Red, green, blue; 0 to 1.
  Eigen::Vector3f joint{0.24F, 0.26F, 0.29F};
  Eigen::Vector3f base{0.30F, 0.32F, 0.35F};
  Eigen::Vector3f mesh{0.72F, 0.73F, 0.75F};   ///< Of meshes and primitives without a colour.
  Eigen::Vector3f plate{0.36F, 0.38F, 0.41F};  ///< What the markers are glued on.
  int segments{24};                            ///< Vertices round a link; >= 3.
};

/// Bodies of an arm: its visuals (see MakeVisualBodies()), on links without visuals its capsules. An arm
/// without any visual gets a drum at each revolute joint that stands on the arm as well; the joints'
/// axes are found from the forward kinematics, so that any convention of link frames will do.
/// @param warnings  Told of each mesh that cannot be read; may be null.
[[nodiscard]] std::vector<Body> MakeArmBodies(const ArmModel& arm, const ArmLook& look = {},
                                              std::vector<std::string>* warnings = nullptr);

/// A whole scene: the arm, `tool_markers` on plates on its end effector, `goal_markers` on plates in
/// the goal's frame.
[[nodiscard]] Scene MakeArmScene(const ArmModel& arm, const std::vector<Marker>& tool_markers,
                                 const std::vector<Marker>& goal_markers, const ArmLook& look = {},
                                 std::vector<std::string>* warnings = nullptr);

}  // namespace vantage::sim
