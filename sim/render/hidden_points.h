#pragma once

#include <cstdint>

#include <Eigen/Geometry>

#include "sim/render/occluders.h"

/// @file
/// Which points lie behind a solid as a camera sees them, many at a time.

namespace vantage::sim {

/// Coordinates of points in a body's frame [m].
struct PointArrays {
  const float* x;
  const float* y;
  const float* z;
  std::uint32_t count;
};

/// Marks the points that the solid hides from the camera, which is the origin of the solid's frame: those for which the
/// segment from the camera meets the solid. Nothing is hidden from a camera within it. Exact to 1e-3 of the solid's size.
/// @param X_CB    Pose of the body in the solid's frame.
/// @param bit     Is set in `marks`.
/// @param marks   One for each point.
void MarkHidden(const SweptEllipsoid& solid_C, const Eigen::Isometry3d& X_CB,
                const PointArrays& points_B, std::uint32_t bit, std::uint32_t* marks);

}  // namespace vantage::sim
