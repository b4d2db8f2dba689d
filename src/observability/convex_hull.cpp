#include "convex_hull.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include <Eigen/Geometry>

namespace vantage {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kTolerance = 1e-10;  // of the extent

// Andrew's monotone chain.
std::vector<int> PlanarHull(const std::vector<Vector2d>& p, double tolerance) {
  std::vector<int> order(p.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](int a, int b) {
    return p[a].x() < p[b].x() || (p[a].x() == p[b].x() && p[a].y() < p[b].y());
  });
  // True when c is left of the line a -> b by more than the tolerance.
  const auto left = [&](int a, int b, int c) {
    const Vector2d u = p[b] - p[a];
    const Vector2d v = p[c] - p[a];
    return u.x() * v.y() - u.y() * v.x() > tolerance * u.norm();
  };
  std::vector<int> hull;
  for (int pass = 0; pass < 2; ++pass) {
    const std::size_t start = hull.size();
    for (const int i : order) {
      while (hull.size() >= start + 2 && !left(hull[hull.size() - 2], hull.back(), i)) {
        hull.pop_back();
      }
      hull.push_back(i);
    }
    std::reverse(order.begin(), order.end());
  }
  return hull;
}

struct Face {
  std::array<int, 3> vertex;  // counter-clockwise seen from outside
  Vector3d normal;
  double offset;
  std::vector<int> outside;  // points beyond the face, each in the list of one face
  bool alive{true};
};

double Height(const Face& face, const Vector3d& p) {
  return face.normal.dot(p) - face.offset;
}

Face MakeFace(const std::vector<Vector3d>& p, int a, int b, int c) {
  Face face;
  face.vertex = {a, b, c};
  const Vector3d n = (p[b] - p[a]).cross(p[c] - p[a]);
  const double length = n.norm();
  face.normal = length > 0.0 ? Vector3d(n / length) : Vector3d::Zero();
  face.offset = face.normal.dot((p[a] + p[b] + p[c]) / 3.0);
  return face;
}

// Quickhull: the farthest point beyond some face joins the hull until none is left.
std::vector<int> SpatialHull(const std::vector<Vector3d>& p, std::array<int, 4> start,
                             double tolerance) {
  if (Height(MakeFace(p, start[0], start[1], start[2]), p[start[3]]) > 0.0) {
    std::swap(start[1], start[2]);
  }
  std::vector<Face> faces{
      MakeFace(p, start[0], start[1], start[2]), MakeFace(p, start[0], start[3], start[1]),
      MakeFace(p, start[1], start[3], start[2]), MakeFace(p, start[2], start[3], start[0])};
  const auto assign = [&](int i, std::size_t first_face) {
    for (std::size_t f = first_face; f < faces.size(); ++f) {
      if (faces[f].alive && Height(faces[f], p[i]) > tolerance) {
        faces[f].outside.push_back(i);
        return;
      }
    }
  };
  for (int i = 0; i < static_cast<int>(p.size()); ++i) {
    if (std::find(start.begin(), start.end(), i) == start.end()) assign(i, 0);
  }
  for (std::size_t f = 0; f < faces.size(); ++f) {
    if (!faces[f].alive || faces[f].outside.empty()) continue;
    const int apex = *std::max_element(
        faces[f].outside.begin(), faces[f].outside.end(),
        [&](int a, int b) { return Height(faces[f], p[a]) < Height(faces[f], p[b]); });
    std::vector<int> loose;
    std::vector<std::pair<int, int>> edges;  // of the faces that the apex sees
    for (Face& face : faces) {
      if (!face.alive || Height(face, p[apex]) <= tolerance) continue;
      face.alive = false;
      loose.insert(loose.end(), face.outside.begin(), face.outside.end());
      face.outside.clear();
      for (int k = 0; k < 3; ++k) edges.emplace_back(face.vertex[k], face.vertex[(k + 1) % 3]);
    }
    const std::size_t first_new = faces.size();
    for (const auto& [a, b] : edges) {
      // Edges between two such faces vanish; the others are the horizon.
      if (std::find(edges.begin(), edges.end(), std::make_pair(b, a)) == edges.end()) {
        faces.push_back(MakeFace(p, a, b, apex));
      }
    }
    for (const int i : loose) {
      if (i != apex) assign(i, first_new);
    }
  }
  std::vector<int> hull;
  for (const Face& face : faces) {
    if (face.alive) hull.insert(hull.end(), face.vertex.begin(), face.vertex.end());
  }
  return hull;
}

template <typename Measure>
int Farthest(const std::vector<Vector3d>& p, Measure&& measure) {
  int best = 0;
  for (int i = 1; i < static_cast<int>(p.size()); ++i) {
    if (measure(p[i]) > measure(p[best])) best = i;
  }
  return best;
}

}  // namespace

std::vector<int> ConvexHullVertices(const std::vector<Vector3d>& p) {
  if (p.empty()) return {};
  const int a = Farthest(p, [&](const Vector3d& x) { return -x.x(); });
  const int b = Farthest(p, [&](const Vector3d& x) { return (x - p[a]).squaredNorm(); });
  const double extent = (p[b] - p[a]).norm();
  const double tolerance = kTolerance * extent;
  std::vector<int> hull;
  if (!(extent > 0.0)) {
    hull = {a};
  } else {
    const Vector3d along = (p[b] - p[a]) / extent;
    const auto off_line = [&](const Vector3d& x) { return along.cross(x - p[a]).norm(); };
    const int c = Farthest(p, off_line);
    if (off_line(p[c]) <= tolerance) {
      hull = {a, b};
    } else {
      const Vector3d normal = along.cross(p[c] - p[a]).normalized();
      const auto off_plane = [&](const Vector3d& x) { return std::abs(normal.dot(x - p[a])); };
      const int d = Farthest(p, off_plane);
      if (off_plane(p[d]) <= tolerance) {
        const Vector3d across = normal.cross(along);
        std::vector<Vector2d> flat;
        for (const Vector3d& x : p) flat.emplace_back(along.dot(x - p[a]), across.dot(x - p[a]));
        hull = PlanarHull(flat, tolerance);
      } else {
        hull = SpatialHull(p, {a, b, c, d}, tolerance);
      }
    }
  }
  std::sort(hull.begin(), hull.end());
  hull.erase(std::unique(hull.begin(), hull.end()), hull.end());
  return hull;
}

}  // namespace vantage
