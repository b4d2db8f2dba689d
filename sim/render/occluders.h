#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "sim/render/mesh.h"
#include "sim/render/ray_bounds.h"

/// @file
/// Simple convex solids within the parts of a mesh. What lies behind one of them cannot be seen, and that is cheap to
/// find out: the shadow of a convex body is convex, so a triangle with all corners in it is hidden.

namespace vantage::sim {

/// A solid ellipsoid swept along a segment: the points p for which there is an s in [-1, 1] with
/// |to_unit (p - centre - s half)| <= 1. An ellipsoid where `half` is 0, a capsule where the semi-axes are alike.
struct SweptEllipsoid {
  Eigen::Vector3d centre{Eigen::Vector3d::Zero()};       ///< [m].
  Eigen::Vector3d half{Eigen::Vector3d::Zero()};         ///< Half of the segment [m].
  Eigen::Matrix3d to_unit{Eigen::Matrix3d::Identity()};  ///< [1/m].
  Eigen::Vector3d semi_axes{Eigen::Vector3d::Ones()};    ///< Of the ellipsoid [m].
};

[[nodiscard]] SweptEllipsoid Move(const Eigen::Isometry3d& X, const SweptEllipsoid& solid);

/// Bounds of the rays through a solid in the camera's frame; nullopt when it is not wholly in front of the camera.
[[nodiscard]] std::optional<RayBounds> BoundRays(const SweptEllipsoid& solid_C);

struct Occluders {
  std::vector<SweptEllipsoid> solids;
  bool one_part{false};  ///< The mesh is one part, and has a solid: it hides no face of its own.
};

/// One solid within each part of the mesh that is closed and whose faces can all be seen from its middle; parts that
/// share no corner are parts of their own. It keeps kOccluderMargin from the faces. Other parts give none.
[[nodiscard]] Occluders FindOccluders(const TriangleMesh& mesh);

/// Distance between an occluder and the faces round it, in its shortest semi-axes.
inline constexpr double kOccluderMargin = 0.01;

/// The solid, made smaller until it keeps a distance from where its surface was [m]; nullopt when little of it is left.
[[nodiscard]] std::optional<SweptEllipsoid> Shrink(const SweptEllipsoid& solid, double distance);

}  // namespace vantage::sim
