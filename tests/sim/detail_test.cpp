#include "sim/render/detail.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "sim/render/renderer.h"
#include "sim/render/visible_triangles.h"
#include "toy_scene.h"

namespace vantage::sim {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using Eigen::Vector3f;

// Distance of a point to a triangle.
double Distance(const Vector3d& p, const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const Vector3d n = (b - a).cross(c - a);
  const auto to_edge = [&](const Vector3d& s, const Vector3d& e) {
    const double share = std::clamp((p - s).dot(e - s) / (e - s).squaredNorm(), 0.0, 1.0);
    return (s + share * (e - s) - p).norm();
  };
  const bool over = n.squaredNorm() > 0.0 && n.dot((b - a).cross(p - a)) >= 0.0 &&
                    n.dot((c - b).cross(p - b)) >= 0.0 && n.dot((a - c).cross(p - c)) >= 0.0;
  if (over) return std::abs(n.normalized().dot(p - a));
  return std::min({to_edge(a, b), to_edge(b, c), to_edge(c, a)});
}

// The farthest that a vertex of the fine mesh, or the middle of one of its triangles, is from the coarse one.
double Deviation(const TriangleMesh& fine, const TriangleMesh& coarse) {
  std::vector<Vector3d> points;
  for (std::size_t i = 0; i < fine.indices.size(); i += 3) {
    Vector3d middle = Vector3d::Zero();
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector3d corner = fine.vertices[fine.indices[i + k]].cast<double>();
      if (i % 15 == 0) points.push_back(corner);
      middle += corner / 3.0;
    }
    points.push_back(middle);
  }
  double farthest = 0.0;
  for (const Vector3d& p : points) {
    double nearest = 1e9;
    for (std::size_t i = 0; i < coarse.indices.size(); i += 3) {
      const auto corner = [&](std::size_t k) -> Vector3d {
        return coarse.vertices[coarse.indices[i + k]].cast<double>();
      };
      nearest = std::min(nearest, Distance(p, corner(0), corner(1), corner(2)));
    }
    farthest = std::max(farthest, nearest);
  }
  return farthest;
}

// Every edge between two corners in space is run through as often one way as the other.
bool IsClosed(const TriangleMesh& mesh) {
  using Point = std::tuple<float, float, float>;
  std::map<std::pair<Point, Point>, int> edges;
  const auto at = [&](std::size_t i) {
    const Vector3f& p = mesh.vertices[mesh.indices[i]];
    return Point(p.x(), p.y(), p.z());
  };
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Point a = at(i + k);
      const Point b = at(i + (k + 1) % 3);
      if (a == b) continue;
      a < b ? ++edges[{a, b}] : --edges[{b, a}];
    }
  }
  return std::all_of(edges.begin(), edges.end(), [](const auto& e) { return e.second == 0; });
}

struct Solid {
  const char* name;
  TriangleMesh mesh;
};

std::vector<Solid> Solids() {
  TriangleMesh two = CapsuleMesh({0, 0, 0}, {0, 0, 0.3}, 0.04, 40);
  Append(&two, CylinderMesh({0, -0.05, 0.3}, {0, 0.05, 0.3}, 0.05, 0.006, 60));
  return {{"ball", CapsuleMesh({1, 2, 3}, {1, 2, 3}, 0.1, 64)},
          {"capsule", CapsuleMesh({0, 0, 0}, {0.2, 0.1, 0.3}, 0.05, 48)},
          {"bevelled cylinder", CylinderMesh({0, 0, 0}, {0, 0, 0.2}, 0.08, 0.01, 96)},
          {"two parts", two}};
}

TEST(LevelsOfDetail, AreWithinTheirErrors) {
  for (const Solid& solid : Solids()) {
    const std::vector<CoarseMesh> levels = MakeLevelsOfDetail(solid.mesh);
    ASSERT_GE(levels.size(), 3U) << solid.name;
    EXPECT_EQ(levels[0].mesh.indices, solid.mesh.indices) << solid.name;
    EXPECT_EQ(levels[0].error, 0.0) << solid.name;
    for (std::size_t i = 1; i < levels.size(); ++i) {
      const CoarseMesh& level = levels[i];
      EXPECT_LT(level.mesh.triangles(), 0.76 * levels[i - 1].mesh.triangles()) << solid.name;
      EXPECT_GE(level.error, levels[i - 1].error) << solid.name;
      EXPECT_LT(Deviation(solid.mesh, level.mesh), level.error) << solid.name << i;
      EXPECT_TRUE(IsClosed(level.mesh)) << solid.name << i;
      ASSERT_EQ(level.mesh.vertices.size(), level.mesh.normals.size());
      ASSERT_LT(*std::max_element(level.mesh.indices.begin(), level.mesh.indices.end()),
                level.mesh.vertices.size());
      for (const Vector3f& normal : level.mesh.normals) ASSERT_NEAR(normal.norm(), 1.0F, 1e-5F);
    }
  }
}

TEST(LevelsOfDetail, AreOneForAMeshThatIsCoarseAlready) {
  EXPECT_EQ(MakeLevelsOfDetail(BoxMesh({0.1, 0.2, 0.3})).size(), 1U);
  EXPECT_EQ(MakeLevelsOfDetail(TriangleMesh{}).size(), 1U);
}

TEST(LevelsOfDetail, AreChosenByTheirErrors) {
  const std::vector<double> errors{0.0, 1e-4, 3e-4, 8e-4};
  EXPECT_EQ(ChooseLevelOfDetail(errors, -1.0), 0);
  EXPECT_EQ(ChooseLevelOfDetail(errors, 5e-5), 0);
  EXPECT_EQ(ChooseLevelOfDetail(errors, 1e-4), 1);
  EXPECT_EQ(ChooseLevelOfDetail(errors, 7e-4), 2);
  EXPECT_EQ(ChooseLevelOfDetail(errors, 1.0), 3);
  EXPECT_EQ(ChooseLevelOfDetail({0.0}, 1.0), 0);
}

// A ball of 100 000 triangles is as bright everywhere, and as large, as a ball is.
TEST(LevelsOfDetail, ChangeTheImageHardlyAtAll) {
  constexpr double kRadius = 0.2;
  Body ball{kWorldFrame, CapsuleMesh({0, 0, 0}, {0, 0, 0}, kRadius, 450)};
  ASSERT_GT(ball.mesh.triangles(), 100000);
  ball.colour = {0.9F, 0.9F, 0.9F};
  Scene scene;
  scene.bodies.push_back(ball);
  scene.floor.visible = false;
  const CameraModel camera = test::Camera();
  Renderer renderer = test::MakeRenderer(camera, scene);
  VisibleTriangles visible(scene, camera, 0.03);
  std::vector<LitVertex> vertices(visible.vertex_count());
  std::vector<std::uint32_t> indices;
  const RayBounds all = BoundRays(camera, {0, 0, camera.width, camera.height});
  GreyImage image;
  std::size_t last = ball.mesh.indices.size();
  for (const double distance : {0.5, 1.5, 5.0}) {
    const Isometry3d X_WC = test::LookAt(distance * Vector3d(0.6, 0.48, 0.64), Vector3d::Zero());
    visible.Place(X_WC.inverse(), {}, {all}, vertices.data());
    const std::size_t shown = visible.Select(all, &indices);
    EXPECT_LT(shown, last / 2) << distance;  // Half of any level faces the camera.
    last = shown;
    renderer.RenderGrey(X_WC, {}, &image);
    int wrong = 0;
    int inside = 0;
    for (int v = 0; v < image.height; ++v) {
      for (int u = 0; u < image.width; ++u) {
        const Vector3d ray =
            (X_WC.linear() * ToNormalised(camera, Eigen::Vector2d(u, v)).homogeneous())
                .normalized();
        const double along = -ray.dot(X_WC.translation());
        const double off2 = (X_WC.translation() + along * ray).squaredNorm();
        if (off2 > kRadius * kRadius) {
          // 1.5 px outside there is the background.
          const double margin = kRadius + 1.5 * distance / camera.fx;
          if (off2 > margin * margin) {
            ASSERT_EQ(*image.at(u, v), 120) << u << " " << v;
          }
          continue;
        }
        const double depth = along - std::sqrt(kRadius * kRadius - off2);
        const Vector3d normal = (X_WC.translation() + depth * ray) / kRadius;
        if (-normal.dot(ray) < 0.3) continue;  // Grazing: a pixel is a wide piece of the surface.
        ++inside;
        const double expected = 255.0 * Brightness(scene.light, ball.colour, normal);
        if (std::abs(*image.at(u, v) - expected) > 3.0) ++wrong;
      }
    }
    EXPECT_GT(inside, 1000);
    EXPECT_LT(wrong, 0.01 * inside) << distance;
  }
}

}  // namespace
}  // namespace vantage::sim
