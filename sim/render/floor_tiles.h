#pragma once

#include <cstddef>

#include <Eigen/Geometry>

#include "sim/render/mesh.h"
#include "sim/render/ray_bounds.h"
#include "sim/render/scene.h"

/// @file
/// The floor of grey images: squares that are darker than the background.

namespace vantage::sim {

/// Every other square of the floor, in W, by rising x; none where the floor is not visible.
[[nodiscard]] TriangleMesh DarkTiles(const Floor& floor);

/// Some of a mesh's indices.
struct IndexRange {
  std::size_t first{0}, count{0};
};

/// The indices of DarkTiles(floor) of which a camera without distortion may see something within the bounds, and of some
/// tiles more.
/// @param X_WC  Above the floor.
[[nodiscard]] IndexRange TilesSeen(const Floor& floor, const Eigen::Isometry3d& X_WC,
                                   const RayBounds& bounds);

}  // namespace vantage::sim
