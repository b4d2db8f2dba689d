#include "sim/render/occluders.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <optional>
#include <utility>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <meshoptimizer.h>

#include "vantage/math/angles.h"

namespace vantage::sim {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// A solid that has to be made smaller than this share of its size hides too little to be worth its cost.
constexpr double kLeastLeft = 0.8;

using Corners = std::array<int, 3>;

// A mesh without the corners that only differ in their normals.
struct Surface {
  std::vector<Vector3d> points;
  std::vector<Corners> triangles;
};

Surface Weld(const TriangleMesh& mesh) {
  std::vector<Eigen::Vector3f> points = mesh.vertices;
  for (Eigen::Vector3f& p : points)
    p.array() += 0.0F;  // -0 is 0, which equality to the bit would deny.
  std::vector<unsigned> welded(points.size());
  const std::size_t different = meshopt_generateVertexRemap(
      welded.data(), nullptr, points.size(), points.data(), points.size(), sizeof(Eigen::Vector3f));
  Surface surface;
  surface.points.resize(different);
  for (std::size_t i = 0; i < points.size(); ++i) {
    surface.points[welded[i]] = points[i].cast<double>();
  }
  for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
    const auto corner = [&](std::size_t k) {
      return static_cast<int>(welded[mesh.indices[i + k]]);
    };
    const Corners t{corner(0), corner(1), corner(2)};
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
  std::vector<int> part_of(surface.points.size(), -1);
  std::vector<std::vector<Corners>> parts;
  for (const Corners& t : surface.triangles) {
    int& part = part_of[root(t[0])];
    if (part < 0) {
      part = static_cast<int>(parts.size());
      parts.emplace_back();
    }
    parts[part].push_back(t);
  }
  return parts;
}

// Each edge is passed once each way.
bool IsClosed(const std::vector<Corners>& part) {
  std::vector<std::pair<int, int>> there;
  std::vector<std::pair<int, int>> back;
  for (const Corners& t : part) {
    for (int k = 0; k < 3; ++k) {
      there.emplace_back(t[k], t[(k + 1) % 3]);
      back.emplace_back(t[(k + 1) % 3], t[k]);
    }
  }
  std::sort(there.begin(), there.end());
  std::sort(back.begin(), back.end());
  return there == back && std::adjacent_find(there.begin(), there.end()) == there.end();
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

// The plane of a face: its inner side is where normal . p <= distance.
struct FacePlane {
  Vector3d normal;
  double distance;
};

std::vector<FacePlane> PlanesOf(const Surface& surface, const std::vector<Corners>& part) {
  std::vector<FacePlane> planes;
  for (const Corners& t : part) {
    const Vector3d& a = surface.points[t[0]];
    const Vector3d n = (surface.points[t[1]] - a).cross(surface.points[t[2]] - a);
    if (n.squaredNorm() > 0.0) planes.push_back({n.normalized(), n.normalized().dot(a)});
  }
  return planes;
}

SweptEllipsoid Scale(const SweptEllipsoid& solid, double scale) {
  return {solid.centre, scale * solid.half, solid.to_unit / scale, scale * solid.semi_axes};
}

// Made smaller about its centre until it is on the inner side of all planes by the margin; where the centre is not, it
// comes out empty. A solid that no face's plane cuts lies within the part, convex or not.
SweptEllipsoid FitWithin(const std::vector<FacePlane>& planes, const Vector3d& centre,
                         const Matrix3d& axes, const Vector3d& semi_axes, const Vector3d& half) {
  double scale = 1.0;
  for (const FacePlane& plane : planes) {
    const double reach = std::abs(plane.normal.dot(half)) +
                         semi_axes.cwiseProduct(axes.transpose() * plane.normal).norm();
    scale = std::min(scale, (plane.distance - plane.normal.dot(centre)) / reach);
  }
  const SweptEllipsoid whole{
      centre, half, axes * semi_axes.cwiseInverse().asDiagonal() * axes.transpose(), semi_axes};
  return Scale(whole, std::max(scale, 0.0) * (1.0 - kOccluderMargin));
}

double Volume(const SweptEllipsoid& solid) {
  // Of the section, over the length along the segment: to_unit maps the section's area to that of a unit disc.
  const double length = solid.half.norm();
  const double ellipsoid = 4.0 / 3.0 * kPi * solid.semi_axes.prod();
  if (length == 0.0) return ellipsoid;
  const double stretch = (solid.to_unit * solid.half).norm() / length;
  return ellipsoid + 2.0 * length * kPi * solid.semi_axes.prod() * stretch;
}

// Along the part's principal axes and as long as the part each way: an ellipsoid, or a bar with rounded ends,
// whichever fills more of it.
std::optional<SweptEllipsoid> Inscribe(const Surface& surface, const std::vector<Corners>& part) {
  const std::vector<Vector3d> points = PointsOf(surface, part);
  Vector3d mean = Vector3d::Zero();
  for (const Vector3d& p : points) mean += p / static_cast<double>(points.size());
  Matrix3d spread = Matrix3d::Zero();
  for (const Vector3d& p : points) spread += (p - mean) * (p - mean).transpose();
  const Matrix3d axes = Eigen::SelfAdjointEigenSolver<Matrix3d>(spread).eigenvectors();
  Eigen::AlignedBox3d box;
  for (const Vector3d& p : points) box.extend(axes.transpose() * p);
  const Vector3d centre = axes * box.center();
  const Vector3d reach = 0.5 * box.sizes();

  const double tolerance = 1e-5 * box.sizes().maxCoeff();  // Meshes are in single precision.
  const std::vector<FacePlane> planes = PlanesOf(surface, part);
  int along = 0;
  reach.maxCoeff(&along);
  Vector3d ends = reach;
  ends[along] = reach.minCoeff();
  const Vector3d half = (reach[along] - ends[along]) * axes.col(along);
  const SweptEllipsoid ellipsoid = FitWithin(planes, centre, axes, reach, Vector3d::Zero());
  const SweptEllipsoid bar = FitWithin(planes, centre, axes, ends, half);
  const SweptEllipsoid& best = Volume(bar) > Volume(ellipsoid) ? bar : ellipsoid;
  if (!(best.semi_axes.minCoeff() > 10.0 * tolerance)) return std::nullopt;
  return best;
}

}  // namespace

SweptEllipsoid Move(const Eigen::Isometry3d& X, const SweptEllipsoid& solid) {
  return {X * solid.centre, X.linear() * solid.half,
          X.linear() * solid.to_unit * X.linear().transpose(), solid.semi_axes};
}

// A plane (1, 0, -x) through the camera touches an ellipsoid where its distance to the centre is its reach: a quadratic
// in x, and one in y alike.
std::optional<RayBounds> BoundRays(const SweptEllipsoid& solid_C) {
  const Matrix3d from_unit = solid_C.to_unit.inverse();
  const Matrix3d Q = from_unit * from_unit.transpose();
  RayBounds bounds;
  for (const double end : {-1.0, 1.0}) {
    const Vector3d c = solid_C.centre + end * solid_C.half;
    const double zz = c.z() * c.z() - Q(2, 2);
    if (c.z() <= 0.0 || zz <= 0.0) return std::nullopt;
    const auto touching = [&](int axis) {
      const double middle = (c[axis] * c.z() - Q(axis, 2)) / zz;
      const double product = (c[axis] * c[axis] - Q(axis, axis)) / zz;
      const double half = std::sqrt(std::max(middle * middle - product, 0.0));
      return std::pair(middle - half, middle + half);
    };
    const auto [x0, x1] = touching(0);
    const auto [y0, y1] = touching(1);
    bounds = Union(bounds, {x0, x1, y0, y1});
  }
  return bounds;
}

Occluders FindOccluders(const TriangleMesh& mesh) {
  const Surface surface = Weld(mesh);
  const std::vector<std::vector<Corners>> parts = SplitParts(surface);
  Occluders found;
  for (const std::vector<Corners>& part : parts) {
    if (!IsClosed(part)) continue;
    if (const auto solid = Inscribe(surface, part)) found.solids.push_back(*solid);
  }
  found.one_part = parts.size() == 1 && found.solids.size() == 1;
  return found;
}

std::optional<SweptEllipsoid> Shrink(const SweptEllipsoid& solid, double distance) {
  const double scale = 1.0 - distance / solid.semi_axes.minCoeff();
  if (scale < kLeastLeft) return std::nullopt;
  return Scale(solid, scale);
}

}  // namespace vantage::sim
