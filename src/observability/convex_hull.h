#pragma once

#include <vector>

#include <Eigen/Core>

namespace vantage {

/// Indices of the points that can be farthest in some direction: the vertices of the convex hull, to
/// 1e-10 of the set's extent (a point that sticks out by less is left out). Planar and collinear sets and
/// sets of one point are served. Ascending.
[[nodiscard]] std::vector<int> ConvexHullVertices(const std::vector<Eigen::Vector3d>& points);

}  // namespace vantage
