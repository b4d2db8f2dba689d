#include "sim/render/occluders.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "sim/render/arm_scene.h"
#include "sim/render/renderer.h"
#include "sim/render/visible_triangles.h"
#include "toy_scene.h"

namespace vantage::sim {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

// How far points of the ellipsoid's surface reach past the planes of the mesh's faces [m]; < 0: not.
double ReachPastFaces(const Ellipsoid& ellipsoid, const TriangleMesh& mesh) {
  const Eigen::Matrix3d from_unit = ellipsoid.to_unit.inverse();
  double reach = -1e9;
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    const auto corner = [&](std::size_t k) -> Vector3d {
      return mesh.vertices[mesh.indices[i + k]].cast<double>();
    };
    const Vector3d n = (corner(1) - corner(0)).cross(corner(2) - corner(0));
    if (n.norm() < 1e-12) continue;
    const Vector3d normal = n.normalized();
    reach = std::max(
        reach, normal.dot(ellipsoid.centre - corner(0)) + (from_unit.transpose() * normal).norm());
  }
  return reach;
}

struct Solid {
  const char* name;
  TriangleMesh mesh;
};

std::vector<Solid> Solids() {
  return {{"box", BoxMesh({0.1, 0.2, 0.4})},
          {"sphere", CapsuleMesh({1, 2, 3}, {1, 2, 3}, 0.1)},
          {"capsule", CapsuleMesh({0.1, 0.2, 0.3}, {0.3, -0.1, 0.5}, 0.06, 10)},
          {"bevelled cylinder", CylinderMesh({0, 0, 0.1}, {0.2, 0.1, 0.1}, 0.15, 0.02)},
          {"sharp cylinder", CylinderMesh({0, 0, 0}, {0, 0, 0.01}, 0.1, 0.0)}};
}

TEST(Occluders, LieWithinSolidsByTheMargin) {
  for (const Solid& solid : Solids()) {
    const std::vector<Ellipsoid> occluders = FindOccluders(solid.mesh);
    ASSERT_EQ(occluders.size(), 1U) << solid.name;
    const double margin = kOccluderMargin * occluders[0].semi_axes.minCoeff();
    EXPECT_LE(ReachPastFaces(occluders[0], solid.mesh), -margin) << solid.name;
  }
}

// A disc that a camera looks onto hides what is behind nearly all of it.
TEST(Occluders, FillAPlate) {
  const auto occluders = FindOccluders(CylinderMesh({0, 0, 0}, {0, 0, 0.01}, 0.1, 0.001));
  ASSERT_EQ(occluders.size(), 1U);
  EXPECT_GT(occluders[0].semi_axes.maxCoeff(), 0.09);
}

TEST(Occluders, AreOneForEachPart) {
  TriangleMesh mesh = BoxMesh({0.1, 0.1, 0.1});
  Append(&mesh, BoxMesh({0.1, 0.1, 0.1}), Isometry3d(Eigen::Translation3d(0.5, 0.0, 0.0)));
  EXPECT_EQ(FindOccluders(mesh).size(), 2U);
}

TEST(Occluders, AreNoneInAnOpenMesh) {
  TriangleMesh mesh = BoxMesh({0.1, 0.1, 0.1});
  mesh.indices.resize(mesh.indices.size() - 3);
  EXPECT_TRUE(FindOccluders(mesh).empty());
}

TEST(Occluders, AreNoneInAMeshBentInwards) {
  TriangleMesh mesh = CapsuleMesh({0, 0, 0}, {0, 0, 0}, 0.1);
  Eigen::Vector3f dented = mesh.vertices[mesh.indices[mesh.indices.size() / 2]];
  for (Eigen::Vector3f& p : mesh.vertices) {
    if (p == dented) p *= 0.8F;
  }
  EXPECT_TRUE(FindOccluders(mesh).empty());
}

TEST(Occluders, AreNoneInASheet) {
  TriangleMesh mesh;
  AppendQuad(&mesh, {Vector3d(0, 0, 0), {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, Vector3d::UnitZ());
  AppendQuad(&mesh, {Vector3d(0, 0, 0), {0, 1, 0}, {1, 1, 0}, {1, 0, 0}}, -Vector3d::UnitZ());
  EXPECT_TRUE(FindOccluders(mesh).empty());
}

TEST(Occluders, ChangeNoPixel) {
  const std::vector<Marker> tool = test::ToolMarkers(0.03, 0.06, Vector3d::UnitX(), true);
  Scene scene = test::ToyScene(tool, {});
  std::size_t occluders = 0;
  for (const Body& body : scene.bodies) occluders += FindOccluders(body.mesh).size();
  for (const Marker& marker : tool) occluders += FindOccluders(PlainMarkerPlate(marker)).size();
  ASSERT_GT(occluders, tool.size() + 3);
  Renderer with = test::MakeRenderer(test::Camera(), scene);
  VisibleTriangles fewer(scene, test::Camera(), 0.03);
  scene.shortcuts.hidden = false;
  Renderer without = test::MakeRenderer(test::Camera(), scene);
  VisibleTriangles all(scene, test::Camera(), 0.03);
  std::mt19937 random(11);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  GreyImage a;
  GreyImage b;
  std::vector<LitVertex> vertices(all.vertex_count());
  std::vector<std::uint32_t> indices;
  const RayBounds image = BoundRays(test::Camera(), {0, 0, 640, 480});
  std::size_t left_out = 0;
  for (int i = 0; i < 200; ++i) {
    // From near enough to be within a body, now and then, to far.
    const double distance = 0.1 + 3.0 * std::pow(std::abs(uniform(random)), 2.0);
    const Vector3d aim(0.3, 0.1 * uniform(random), 0.35);
    const Vector3d way(uniform(random), uniform(random), 0.2 + std::abs(uniform(random)));
    const Isometry3d X_WC = test::LookAt(aim + distance * way.normalized(), aim);
    const SceneState state = test::ToyState(uniform(random), uniform(random), uniform(random));
    with.RenderGrey(X_WC, state, &a);
    without.RenderGrey(X_WC, state, &b);
    ASSERT_EQ(a.pixels, b.pixels) << "view " << i;
    for (VisibleTriangles* triangles : {&all, &fewer}) {
      triangles->Place(X_WC.inverse(), state, {image}, vertices.data());
    }
    left_out += all.Select(image, &indices) - fewer.Select(image, &indices);
  }
  EXPECT_GT(left_out, 200U * 3U * 100U);
}

}  // namespace
}  // namespace vantage::sim
