#include "sim/render/occluders.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <utility>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

namespace vantage::sim {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Of a part: whether it is bent inwards is found out from each face with each corner.
constexpr std::size_t kMostTriangles = 5000;

using Corners = std::array<int, 3>;

// A mesh without the corners that only differ in their normals.
struct Surface {
  std::vector<Vector3d> points;
  std::vector<Corners> triangles;
};

Surface Weld(const TriangleMesh& mesh) {
  Surface surface;
  std::map<std::array<float, 3>, int> found;
  std::vector<int> welded;
  for (const Eigen::Vector3f& p : mesh.vertices) {
    const auto next = static_cast<int>(surface.points.size());
    const auto [entry, is_new] = found.try_emplace({p.x(), p.y(), p.z()}, next);
    if (is_new) surface.points.emplace_back(p.cast<double>());
    welded.push_back(entry->second);
  }
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    const Corners t{welded[mesh.indices[i]], welded[mesh.indices[i + 1]],
                    welded[mesh.indices[i + 2]]};
    if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) surface.triangles.push_back(t);
  }
  return surface;
}

// Triangles that hang together by their corners.
std::vector<std::vector<Corners>> SplitParts(const Surface& surface) {
  std::vector<int> parent(surface.points.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  for (const Corners& t : surface.triangles) {
    parent[root(t[1])] = root(t[0]);
    parent[root(t[2])] = root(t[0]);
  }
  std::map<int, std::vector<Corners>> parts;
  for (const Corners& t : surface.triangles) parts[root(t[0])].push_back(t);
  std::vector<std::vector<Corners>> result;
  for (auto& [unused, part] : parts) result.push_back(std::move(part));
  return result;
}

// Each edge is passed once each way.
bool IsClosed(const std::vector<Corners>& part) {
  std::map<std::pair<int, int>, int> passed;
  for (const Corners& t : part) {
    for (int k = 0; k < 3; ++k) ++passed[{t[k], t[(k + 1) % 3]}];
  }
  return std::all_of(passed.begin(), passed.end(), [&](const auto& edge) {
    const auto back = passed.find({edge.first.second, edge.first.first});
    return edge.second == 1 && back != passed.end();
  });
}

std::vector<Vector3d> PointsOf(const Surface& surface, const std::vector<Corners>& part) {
  std::vector<int> used;
  for (const Corners& t : part) used.insert(used.end(), t.begin(), t.end());
  std::sort(used.begin(), used.end());
  used.erase(std::unique(used.begin(), used.end()), used.end());
  std::vector<Vector3d> points;
  for (const int i : used) points.push_back(surface.points[i]);
  return points;
}

// The ellipsoid along the part's principal axes, as long as the part each way, shrunk until it is within.
std::optional<Ellipsoid> Inscribe(const Surface& surface, const std::vector<Corners>& part) {
  const std::vector<Vector3d> points = PointsOf(surface, part);
  Vector3d mean = Vector3d::Zero();
  for (const Vector3d& p : points) mean += p / static_cast<double>(points.size());
  Matrix3d spread = Matrix3d::Zero();
  for (const Vector3d& p : points) spread += (p - mean) * (p - mean).transpose();
  const Matrix3d axes = Eigen::SelfAdjointEigenSolver<Matrix3d>(spread).eigenvectors();
  Eigen::AlignedBox3d box;
  for (const Vector3d& p : points) box.extend(axes.transpose() * p);

  Ellipsoid ellipsoid;
  ellipsoid.centre = axes * box.center();
  ellipsoid.semi_axes = 0.5 * box.sizes();
  const double tolerance = 1e-5 * box.sizes().maxCoeff();  // Meshes are in single precision.
  double scale = 1.0;
  for (const Corners& t : part) {
    const Vector3d& a = surface.points[t[0]];
    const Vector3d n = (surface.points[t[1]] - a).cross(surface.points[t[2]] - a).normalized();
    for (const Vector3d& p : points) {
      if (n.dot(p - a) > tolerance) return std::nullopt;
    }
    const double reach = ellipsoid.semi_axes.cwiseProduct(axes.transpose() * n).norm();
    scale = std::min(scale, n.dot(a - ellipsoid.centre) / reach);
  }
  ellipsoid.semi_axes *= (1.0 - kOccluderMargin) * scale;
  if (!(ellipsoid.semi_axes.minCoeff() > 10.0 * tolerance)) return std::nullopt;
  ellipsoid.to_unit = axes * ellipsoid.semi_axes.cwiseInverse().asDiagonal() * axes.transpose();
  return ellipsoid;
}

}  // namespace

std::vector<Ellipsoid> FindOccluders(const TriangleMesh& mesh) {
  const Surface surface = Weld(mesh);
  std::vector<Ellipsoid> occluders;
  for (const std::vector<Corners>& part : SplitParts(surface)) {
    if (part.size() > kMostTriangles || !IsClosed(part)) continue;
    if (const auto ellipsoid = Inscribe(surface, part)) occluders.push_back(*ellipsoid);
  }
  return occluders;
}

}  // namespace vantage::sim
