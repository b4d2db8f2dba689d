#include "sim/render/mesh.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "vantage/math/angles.h"

namespace vantage::sim {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

// Rotation about the line of a and b that takes z to the direction from a to b.
Isometry3d AxisFrame(const Vector3d& a, const Vector3d& b) {
  Isometry3d X = Isometry3d::Identity();
  X.translation() = a;
  if (!a.isApprox(b)) {
    X.linear() = Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), b - a).toRotationMatrix();
  }
  return X;
}

// One point of a profile that is turned round the z axis: distance, height, normal in that plane.
struct ProfilePoint {
  double distance, height;
  double normal_out, normal_up;
};

// Surface of revolution; the profile runs from the bottom to the top on the outside. A point given
// twice with two normals makes a sharp edge; neighbours at the same place get no triangles.
TriangleMesh Turn(const std::vector<ProfilePoint>& profile, int segments) {
  TriangleMesh mesh;
  for (const ProfilePoint& point : profile) {
    for (int i = 0; i < segments; ++i) {
      const double angle = 2.0 * kPi * i / segments;
      const double c = std::cos(angle);
      const double s = std::sin(angle);
      mesh.vertices.push_back(
          Vector3d(point.distance * c, point.distance * s, point.height).cast<float>());
      mesh.normals.push_back(Vector3d(point.normal_out * c, point.normal_out * s, point.normal_up)
                                 .normalized()
                                 .cast<float>());
    }
  }
  const auto n = static_cast<std::uint32_t>(segments);
  for (std::uint32_t row = 0; row + 1 < profile.size(); ++row) {
    const ProfilePoint& low = profile[row];
    const ProfilePoint& high = profile[row + 1];
    if (low.distance == high.distance && low.height == high.height) continue;
    for (std::uint32_t i = 0; i < n; ++i) {
      const std::uint32_t j = (i + 1) % n;
      const std::uint32_t a = row * n + i;
      const std::uint32_t b = row * n + j;
      const std::uint32_t c = (row + 1) * n + i;
      const std::uint32_t d = (row + 1) * n + j;
      if (low.distance > 0.0) mesh.indices.insert(mesh.indices.end(), {a, b, d});
      if (high.distance > 0.0) mesh.indices.insert(mesh.indices.end(), {a, d, c});
    }
  }
  return mesh;
}

}  // namespace

void Append(TriangleMesh* mesh, const TriangleMesh& part, const Isometry3d& X) {
  const auto offset = static_cast<std::uint32_t>(mesh->vertices.size());
  for (std::size_t i = 0; i < part.vertices.size(); ++i) {
    mesh->vertices.emplace_back((X * part.vertices[i].cast<double>()).cast<float>());
    mesh->normals.emplace_back((X.linear() * part.normals[i].cast<double>()).cast<float>());
  }
  for (const std::uint32_t index : part.indices) mesh->indices.push_back(index + offset);
}

void AppendQuad(TriangleMesh* mesh, const std::array<Vector3d, 4>& corners,
                const Vector3d& normal) {
  const auto first = static_cast<std::uint32_t>(mesh->vertices.size());
  for (const Vector3d& corner : corners) {
    mesh->vertices.emplace_back(corner.cast<float>());
    mesh->normals.emplace_back(normal.cast<float>());
  }
  for (const std::uint32_t i : {0U, 1U, 2U, 0U, 2U, 3U}) mesh->indices.push_back(first + i);
}

TriangleMesh CapsuleMesh(const Vector3d& a, const Vector3d& b, double radius, int segments) {
  assert(segments >= 3 && radius > 0.0);
  const double length = (b - a).norm();
  const int rings = std::max(2, segments / 4);
  std::vector<ProfilePoint> profile;
  for (int end = 0; end < 2; ++end) {
    for (int i = 0; i <= rings; ++i) {
      const double latitude =
          0.5 * kPi *
          (end == 0 ? static_cast<double>(i) / rings - 1.0 : static_cast<double>(i) / rings);
      const bool pole = i == (end == 0 ? 0 : rings);
      const double c = pole ? 0.0 : std::cos(latitude);
      const double s = std::sin(latitude);
      profile.push_back({radius * c, radius * s + end * length, c, s});
    }
  }
  TriangleMesh mesh;
  Append(&mesh, Turn(profile, segments), AxisFrame(a, b));
  return mesh;
}

TriangleMesh CylinderMesh(const Vector3d& a, const Vector3d& b, double radius, double bevel,
                          int segments) {
  const double length = (b - a).norm();
  assert(length > 0.0 && bevel >= 0.0 && bevel < radius && 2.0 * bevel < length);
  std::vector<ProfilePoint> profile{{0.0, 0.0, 0.0, -1.0}, {radius - bevel, 0.0, 0.0, -1.0}};
  if (bevel > 0.0) {
    profile.push_back({radius - bevel, 0.0, 1.0, -1.0});
    profile.push_back({radius, bevel, 1.0, -1.0});
  }
  profile.push_back({radius, bevel, 1.0, 0.0});
  profile.push_back({radius, length - bevel, 1.0, 0.0});
  if (bevel > 0.0) {
    profile.push_back({radius, length - bevel, 1.0, 1.0});
    profile.push_back({radius - bevel, length, 1.0, 1.0});
  }
  profile.push_back({radius - bevel, length, 0.0, 1.0});
  profile.push_back({0.0, length, 0.0, 1.0});
  TriangleMesh mesh;
  Append(&mesh, Turn(profile, segments), AxisFrame(a, b));
  return mesh;
}

TriangleMesh BoxMesh(const Vector3d& size) {
  TriangleMesh mesh;
  for (int axis = 0; axis < 3; ++axis) {
    for (const int side : {-1, 1}) {
      const Vector3d normal = side * Vector3d::Unit(axis);
      const Vector3d e1 = Vector3d::Unit((axis + 1) % 3);
      const Vector3d e2 = normal.cross(e1);
      const auto corner = [&](int x, int y) -> Vector3d {
        return 0.5 * size.cwiseProduct(normal + x * e1 + y * e2);
      };
      AppendQuad(&mesh, {corner(-1, -1), corner(1, -1), corner(1, 1), corner(-1, 1)}, normal);
    }
  }
  return mesh;
}

BoundingSphere Bound(const TriangleMesh& mesh) {
  if (mesh.vertices.empty()) return {};
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& vertex : mesh.vertices) box.extend(vertex);
  BoundingSphere sphere;
  sphere.centre = box.center().cast<double>();
  for (const Eigen::Vector3f& vertex : mesh.vertices) {
    sphere.radius = std::max(sphere.radius, (vertex.cast<double>() - sphere.centre).norm());
  }
  return sphere;
}

}  // namespace vantage::sim
