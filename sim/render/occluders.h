#pragma once

#include <vector>

#include <Eigen/Core>

#include "sim/render/mesh.h"

/// @file
/// Ellipsoids within the solid parts of a mesh. What lies behind one of them cannot be seen, and that is cheap
/// to find out: the shadow of a convex body is convex, so a triangle with all corners in it is hidden.

namespace vantage::sim {

/// A solid ellipsoid: the points p with |to_unit (p - centre)| <= 1.
struct Ellipsoid {
  Eigen::Vector3d centre{Eigen::Vector3d::Zero()};       ///< [m].
  Eigen::Matrix3d to_unit{Eigen::Matrix3d::Identity()};  ///< [1/m].
  Eigen::Vector3d semi_axes{Eigen::Vector3d::Ones()};    ///< [m].
};

/// One ellipsoid within each part of the mesh that is closed and convex; parts that share no corner are
/// parts of their own. It keeps kOccluderMargin from the faces. Parts that are open or bent inwards, and those of
/// more than 5000 triangles, give none.
[[nodiscard]] std::vector<Ellipsoid> FindOccluders(const TriangleMesh& mesh);

/// Distance between an occluder and the faces round it, in its shortest semi-axes.
inline constexpr double kOccluderMargin = 0.03;

}  // namespace vantage::sim
