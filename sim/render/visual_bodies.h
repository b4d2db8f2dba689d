#pragma once

#include <string>
#include <vector>

#include "sim/render/scene.h"
#include "vantage/robot/arm_model.h"

namespace vantage::sim {

/// Bodies from the visuals of an arm: primitives and mesh files, those of one colour on one link in one
/// body.
///
/// @param uncoloured  Of what has no colour of its own; red, green, blue in 0 to 1.
/// @param segments    Vertices round a primitive; >= 3.
/// @param warnings    Told of each mesh that cannot be read; the link's capsules are drawn in its
///   place. May be null.
[[nodiscard]] std::vector<Body> MakeVisualBodies(const ArmModel& arm,
                                                 const Eigen::Vector3f& uncoloured, int segments,
                                                 std::vector<std::string>* warnings = nullptr);

}  // namespace vantage::sim
