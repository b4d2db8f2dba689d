#pragma once

#include <vector>

#include "sim/render/mesh.h"

/// @file
/// Meshes from fewer triangles for bodies that are far away. An arm's own meshes often have more triangles than its image
/// has pixels.

namespace vantage::sim {

/// A mesh and how far its surface may be from that of the mesh it was made from: twice and a half what meshoptimizer's
/// quadrics tell [m].
struct CoarseMesh {
  TriangleMesh mesh;
  double error{0.0};
};

/// The mesh itself and coarser ones, each with less than three quarters of the triangles of the one before and no smaller
/// error, from 0.25 mm to a twentieth of its size. Vertices and their normals are some of the mesh's own; what is closed stays
/// closed.
[[nodiscard]] std::vector<CoarseMesh> MakeLevelsOfDetail(const TriangleMesh& mesh);

/// Which of the levels, by the errors that they have, is the coarsest within a tolerance [m]. The finest where none is.
/// @param errors  Of the levels [m]; rising, not empty.
[[nodiscard]] int ChooseLevelOfDetail(const std::vector<double>& errors, double tolerance) noexcept;

}  // namespace vantage::sim
