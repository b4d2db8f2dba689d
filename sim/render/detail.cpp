#include "sim/render/detail.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include <meshoptimizer.h>

namespace vantage::sim {
namespace {

constexpr double kFinestError = 2.5e-4;  // [m].
constexpr double kCoarsestShare = 0.05;  // Of the mesh's size.
// Quadrics tell less than the greatest distance: up to 2.1 times less on the tests' solids.
constexpr double kDoubt = 2.5;
constexpr double kWorthIt = 0.75;             // A level with more of the triangles is not kept.
constexpr std::size_t kFewestTriangles = 64;  // No levels of less.

static_assert(sizeof(Eigen::Vector3f) == 3 * sizeof(float));

const float* Positions(const TriangleMesh& mesh) {
  return mesh.vertices.front().data();
}

// The mesh with other vertices: `remap` has the new place of each old one.
TriangleMesh Remap(const TriangleMesh& mesh, const std::vector<std::uint32_t>& indices,
                   const std::vector<std::uint32_t>& remap, std::size_t vertices) {
  const std::size_t count = mesh.vertices.size();
  TriangleMesh result;
  result.vertices.resize(vertices);
  result.normals.resize(vertices);
  result.indices.resize(indices.size());
  meshopt_remapVertexBuffer(result.vertices.data(), mesh.vertices.data(), count,
                            sizeof(Eigen::Vector3f), remap.data());
  meshopt_remapVertexBuffer(result.normals.data(), mesh.normals.data(), count,
                            sizeof(Eigen::Vector3f), remap.data());
  meshopt_remapIndexBuffer(result.indices.data(), indices.data(), indices.size(), remap.data());
  return result;
}

// Vertices that are the same become one: the simplifier moves none of which there are more than two at a place.
TriangleMesh Weld(const TriangleMesh& mesh) {
  constexpr std::size_t kSize = sizeof(Eigen::Vector3f);
  const std::array<meshopt_Stream, 2> streams{
      {{mesh.vertices.data(), kSize, kSize}, {mesh.normals.data(), kSize, kSize}}};
  std::vector<std::uint32_t> remap(mesh.vertices.size());
  const std::size_t vertices =
      meshopt_generateVertexRemapMulti(remap.data(), mesh.indices.data(), mesh.indices.size(),
                                       mesh.vertices.size(), streams.data(), streams.size());
  return Remap(mesh, mesh.indices, remap, vertices);
}

// Without the vertices that no triangle has.
TriangleMesh Compact(const TriangleMesh& mesh, const std::vector<std::uint32_t>& indices) {
  std::vector<std::uint32_t> remap(mesh.vertices.size());
  const std::size_t vertices = meshopt_optimizeVertexFetchRemap(
      remap.data(), indices.data(), indices.size(), mesh.vertices.size());
  return Remap(mesh, indices, remap, vertices);
}

}  // namespace

std::vector<CoarseMesh> MakeLevelsOfDetail(const TriangleMesh& mesh) {
  std::vector<CoarseMesh> levels{{mesh, 0.0}};
  if (mesh.indices.size() < 3 * kFewestTriangles) return levels;
  const double size =
      meshopt_simplifyScale(Positions(mesh), mesh.vertices.size(), sizeof(Eigen::Vector3f));
  CoarseMesh last{Weld(mesh), 0.0};
  for (double error = kFinestError; error < kCoarsestShare * size; error *= 2.0) {
    if (last.mesh.indices.size() < 3 * kFewestTriangles) break;
    const double allowed = (error - last.error) / kDoubt;  // Errors add up.
    std::vector<std::uint32_t> indices(last.mesh.indices.size());
    float reached = 0.0F;
    const std::size_t count = meshopt_simplify(
        indices.data(), last.mesh.indices.data(), indices.size(), Positions(last.mesh),
        last.mesh.vertices.size(), sizeof(Eigen::Vector3f), /*target_index_count=*/0,
        static_cast<float>(allowed / size), /*options=*/0, &reached);
    if (count == 0 || static_cast<double>(count) > kWorthIt * static_cast<double>(indices.size()))
      continue;
    indices.resize(count);
    last = {Compact(last.mesh, indices), last.error + kDoubt * size * reached};
    levels.push_back(last);
  }
  return levels;
}

int ChooseLevelOfDetail(const std::vector<double>& errors, double tolerance) noexcept {
  const auto above = std::upper_bound(errors.begin(), errors.end(), tolerance);
  return std::max(0, static_cast<int>(above - errors.begin()) - 1);
}

}  // namespace vantage::sim
