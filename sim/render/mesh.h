#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

/// @file
/// Triangle meshes and the primitives that arms are drawn from.

namespace vantage::sim {

/// Indexed triangles, counter-clockwise seen from outside, with a unit normal at each vertex.
struct TriangleMesh {
  std::vector<Eigen::Vector3f> vertices;  ///< [m].
  std::vector<Eigen::Vector3f> normals;   ///< As many as vertices.
  std::vector<std::uint32_t> indices;     ///< Three to a triangle.

  [[nodiscard]] int triangles() const noexcept { return static_cast<int>(indices.size() / 3); }
};

/// Adds `part`, moved by X, to `mesh`.
void Append(TriangleMesh* mesh, const TriangleMesh& part,
            const Eigen::Isometry3d& X = Eigen::Isometry3d::Identity());

/// Adds a flat face with four corners [m], counter-clockwise seen from the side that `normal` points to.
/// @param normal  Unit.
void AppendQuad(TriangleMesh* mesh, const std::array<Eigen::Vector3d, 4>& corners,
                const Eigen::Vector3d& normal);

/// Cylinder with round ends between two points (a sphere when they coincide).
/// @param segments  Vertices round the axis; >= 3.
[[nodiscard]] TriangleMesh CapsuleMesh(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                       double radius, int segments = 24);

/// Cylinder with flat ends and bevelled edges between two points. The last `segments` triangles are the end at b.
/// @param bevel  Width of the bevel [m]; < radius and < half the length. 0: sharp edges.
/// @pre a != b.
[[nodiscard]] TriangleMesh CylinderMesh(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                        double radius, double bevel, int segments = 32);

/// Box of the given edge lengths about the origin, axes along the frame's.
[[nodiscard]] TriangleMesh BoxMesh(const Eigen::Vector3d& size);

/// A sphere that holds every vertex: centre of the bounding box, farthest vertex.
struct BoundingSphere {
  Eigen::Vector3d centre{Eigen::Vector3d::Zero()};
  double radius{0.0};
};
[[nodiscard]] BoundingSphere Bound(const TriangleMesh& mesh);

}  // namespace vantage::sim
