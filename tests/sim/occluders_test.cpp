#include "sim/render/occluders.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "sim/render/arm_scene.h"
#include "sim/render/gl_context.h"
#include "sim/render/renderer.h"
#include "sim/render/visible_triangles.h"
#include "toy_scene.h"
#include "vantage/config/scenario.h"
#include "vantage/robot/kinematics.h"

namespace vantage::sim {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

// How far points of the occluder reach past the planes of the mesh's faces [m]; < 0: not.
double ReachPastFaces(const SweptEllipsoid& solid, const TriangleMesh& mesh) {
  const Eigen::Matrix3d from_unit = solid.to_unit.inverse();
  double reach = -1e9;
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    const auto corner = [&](std::size_t k) -> Vector3d {
      return mesh.vertices[mesh.indices[i + k]].cast<double>();
    };
    const Vector3d n = (corner(1) - corner(0)).cross(corner(2) - corner(0));
    if (n.norm() < 1e-12) continue;
    const Vector3d normal = n.normalized();
    reach =
        std::max(reach, normal.dot(solid.centre - corner(0)) + std::abs(normal.dot(solid.half)) +
                            (from_unit.transpose() * normal).norm());
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
    const std::vector<SweptEllipsoid> occluders = FindOccluders(solid.mesh).solids;
    ASSERT_EQ(occluders.size(), 1U) << solid.name;
    const double margin = kOccluderMargin * occluders[0].semi_axes.minCoeff();
    EXPECT_LE(ReachPastFaces(occluders[0], solid.mesh), -margin) << solid.name;
  }
}

// A disc that a camera looks onto hides what is behind nearly all of it.
TEST(Occluders, FillAPlate) {
  const auto occluders = FindOccluders(CylinderMesh({0, 0, 0}, {0, 0, 0.01}, 0.1, 0.001)).solids;
  ASSERT_EQ(occluders.size(), 1U);
  EXPECT_GT(occluders[0].semi_axes.maxCoeff(), 0.09);
}

// And a capsule hides what is behind nearly all of it, to its ends.
TEST(Occluders, FillABar) {
  const auto occluders = FindOccluders(CapsuleMesh({0, 0, 0}, {0, 0, 0.4}, 0.05, 60)).solids;
  ASSERT_EQ(occluders.size(), 1U);
  EXPECT_GT(occluders[0].semi_axes.minCoeff(), 0.048);
  EXPECT_GT(occluders[0].half.norm(), 0.19);
  EXPECT_LT((occluders[0].centre - Vector3d(0, 0, 0.2)).norm(), 1e-6);
}

TEST(Occluders, ShrinkByADistance) {
  const SweptEllipsoid whole = FindOccluders(CapsuleMesh({0, 0, 0}, {0, 0, 0.4}, 0.05)).solids[0];
  const auto shrunk = Shrink(whole, 0.002);
  ASSERT_TRUE(shrunk);
  EXPECT_NEAR(shrunk->semi_axes.minCoeff(), whole.semi_axes.minCoeff() - 0.002, 1e-9);
  EXPECT_LT(shrunk->half.norm(), whole.half.norm());
  EXPECT_TRUE(
      (shrunk->to_unit * shrunk->semi_axes.minCoeff() - whole.to_unit * whole.semi_axes.minCoeff())
          .isZero(1e-9));
  EXPECT_FALSE(Shrink(whole, 0.03));
}

TEST(Occluders, AreWithinTheBoundsOfTheirRays) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (const Solid& solid : Solids()) {
    const SweptEllipsoid still = FindOccluders(solid.mesh).solids[0];
    for (int i = 0; i < 20; ++i) {
      Isometry3d X = Isometry3d::Identity();
      X.linear() = Eigen::AngleAxisd(3.0 * uniform(random), Vector3d::UnitY()).toRotationMatrix() *
                   Eigen::AngleAxisd(3.0 * uniform(random), Vector3d::UnitX()).toRotationMatrix();
      X.translation() = Vector3d(uniform(random), uniform(random), 2.0) - X.linear() * still.centre;
      const SweptEllipsoid moved = Move(X, still);
      const std::optional<RayBounds> bounds = BoundRays(moved);
      ASSERT_TRUE(bounds);
      RayBounds reached;
      const Eigen::Matrix3d from_unit = moved.to_unit.inverse();
      for (int k = 0; k < 4000; ++k) {
        const Vector3d unit =
            Vector3d(uniform(random), uniform(random), uniform(random)).normalized();
        const Vector3d p = moved.centre + (k % 2 == 0 ? 1.0 : -1.0) * moved.half + from_unit * unit;
        const double x = p.x() / p.z();
        const double y = p.y() / p.z();
        reached = Union(reached, {x, x, y, y});
      }
      const double size = std::sqrt(Area(*bounds));
      for (const double room : {bounds->x1 - reached.x1, reached.x0 - bounds->x0,
                                bounds->y1 - reached.y1, reached.y0 - bounds->y0}) {
        EXPECT_GE(room, -1e-12) << solid.name;
        EXPECT_LT(room, 0.03 * size) << solid.name;
      }
    }
  }
  SweptEllipsoid behind;
  behind.centre = {0, 0, 0.5};  // Of radius 1.
  EXPECT_FALSE(BoundRays(behind));
}

TEST(Occluders, AreOneForEachPart) {
  TriangleMesh mesh = BoxMesh({0.1, 0.1, 0.1});
  Append(&mesh, BoxMesh({0.1, 0.1, 0.1}), Isometry3d(Eigen::Translation3d(0.5, 0.0, 0.0)));
  EXPECT_EQ(FindOccluders(mesh).solids.size(), 2U);
}

TEST(Occluders, AreNoneInAnOpenMesh) {
  TriangleMesh mesh = BoxMesh({0.1, 0.1, 0.1});
  mesh.indices.resize(mesh.indices.size() - 3);
  EXPECT_TRUE(FindOccluders(mesh).solids.empty());
}

TriangleMesh DentedBall(float to) {
  TriangleMesh mesh = CapsuleMesh({0, 0, 0}, {0, 0, 0}, 0.1);
  const Eigen::Vector3f dented = mesh.vertices[mesh.indices[mesh.indices.size() / 2]];
  for (Eigen::Vector3f& p : mesh.vertices) {
    if (p == dented) p *= to;
  }
  return mesh;
}

TEST(Occluders, LieWithinAMeshThatIsBentInwards) {
  const TriangleMesh mesh = DentedBall(0.9F);
  const Occluders occluders = FindOccluders(mesh);
  ASSERT_EQ(occluders.solids.size(), 1U);
  const double size = occluders.solids[0].semi_axes.minCoeff();
  EXPECT_LE(ReachPastFaces(occluders.solids[0], mesh), -kOccluderMargin * size);
  EXPECT_GT(size, 0.02);
}

// Dented to beyond the middle, from which not all faces can be seen.
TEST(Occluders, AreNoneInAMeshBentInwardsTooFar) {
  EXPECT_TRUE(FindOccluders(DentedBall(-0.1F)).solids.empty());
}

// Faces are looked at from within, where a mesh is turned inside out.
TEST(Occluders, AreNoneInAMeshInsideOut) {
  TriangleMesh mesh = BoxMesh({0.1, 0.1, 0.1});
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3)
    std::swap(mesh.indices[i], mesh.indices[i + 1]);
  EXPECT_TRUE(FindOccluders(mesh).solids.empty());
}

TEST(Occluders, AreNoneInASheet) {
  TriangleMesh mesh;
  AppendQuad(&mesh, {Vector3d(0, 0, 0), {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, Vector3d::UnitZ());
  AppendQuad(&mesh, {Vector3d(0, 0, 0), {0, 1, 0}, {1, 1, 0}, {1, 0, 0}}, -Vector3d::UnitZ());
  EXPECT_TRUE(FindOccluders(mesh).solids.empty());
}

// Images, and triangles to draw, with and without what occluders hide.
class OccludersIn {
 public:
  OccludersIn(Scene scene, const CameraModel& camera)
      : camera_(camera), with_(MakeGlContext(), camera, scene), fewer_(scene, camera, 0.03) {
    scene.shortcuts.hidden = false;
    without_.emplace(MakeGlContext(), camera, scene);
    all_.emplace(scene, camera, 0.03);
    vertices_.resize(all_->vertex_count());
  }

  [[nodiscard]] bool ChangeNoPixel(const Isometry3d& X_WC, const SceneState& state) {
    with_.RenderGrey(X_WC, state, &a_);
    without_->RenderGrey(X_WC, state, &b_);
    const RayBounds image = BoundRays(camera_, {0, 0, camera_.width, camera_.height});
    for (VisibleTriangles* triangles : {&*all_, &fewer_}) {
      triangles->Place(X_WC.inverse(), state, {image}, vertices_.data());
    }
    const std::size_t faces = all_->Select(image, &indices_) / 3;
    faces_ += faces;
    left_out_ += faces - fewer_.Select(image, &indices_) / 3;
    return a_.pixels == b_.pixels;
  }

  [[nodiscard]] std::size_t left_out() const { return left_out_; }
  [[nodiscard]] double share_left_out() const {
    return static_cast<double>(left_out_) / static_cast<double>(faces_);
  }

 private:
  CameraModel camera_;
  Renderer with_;
  VisibleTriangles fewer_;
  std::optional<Renderer> without_;
  std::optional<VisibleTriangles> all_;
  GreyImage a_, b_;
  std::vector<LitVertex> vertices_;
  std::vector<std::uint32_t> indices_;
  std::size_t faces_{0}, left_out_{0};
};

TEST(Occluders, ChangeNoPixel) {
  const std::vector<Marker> tool = test::ToolMarkers(0.03, 0.06, Vector3d::UnitX(), true);
  const Scene scene = test::ToyScene(tool, {});
  std::size_t occluders = 0;
  for (const Body& body : scene.bodies) occluders += FindOccluders(body.mesh).solids.size();
  for (const Marker& marker : tool)
    occluders += FindOccluders(PlainMarkerPlate(marker)).solids.size();
  ASSERT_GT(occluders, tool.size() + 3);
  OccludersIn in(scene, test::Camera());
  std::mt19937 random(11);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (int i = 0; i < 200; ++i) {
    // From near enough to be within a body, now and then, to far.
    const double distance = 0.1 + 3.0 * std::pow(std::abs(uniform(random)), 2.0);
    const Vector3d aim(0.3, 0.1 * uniform(random), 0.35);
    const Vector3d way(uniform(random), uniform(random), 0.2 + std::abs(uniform(random)));
    const Isometry3d X_WC = test::LookAt(aim + distance * way.normalized(), aim);
    const SceneState state = test::ToyState(uniform(random), uniform(random), uniform(random));
    ASSERT_TRUE(in.ChangeNoPixel(X_WC, state)) << "view " << i;
  }
  EXPECT_GT(in.left_out(), 200U * 100U);
  EXPECT_GT(in.share_left_out(), 0.2);
}

class OccludersOf : public ::testing::TestWithParam<const char*> {};

// Arms with meshes, which have thin rings, covers and gaps between them.
TEST_P(OccludersOf, ChangeNoPixel) {
  const Scenario scenario = LoadScenario(GetParam());
  const ArmModel& arm = scenario.task.view.arm;
  OccludersIn in(MakeArmScene(arm, scenario.task.view.markers, {}), scenario.task.view.camera);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (int i = 0; i < 200; ++i) {
    JointVector q = scenario.sim.q_start;
    for (double& angle : q) angle += 0.8 * uniform(random);
    const SceneState state(ComputeLinkPoses(arm, q), EndEffectorPose(arm, q));
    const double distance = 0.2 + 3.0 * std::pow(std::abs(uniform(random)), 1.5);
    const Vector3d off(uniform(random), uniform(random), uniform(random));
    const Vector3d way(uniform(random), uniform(random), uniform(random));
    const Vector3d aim = state.X_WE.translation() + 0.2 * off;
    const Isometry3d X_WC = test::LookAt(aim + distance * way.normalized(), aim);
    ASSERT_TRUE(in.ChangeNoPixel(X_WC, state)) << "view " << i;
  }
  EXPECT_GT(in.share_left_out(), 0.08);
}

INSTANTIATE_TEST_SUITE_P(Arms, OccludersOf,
                         ::testing::Values("puma560-bad-view", "ur5-bad-view", "panda-bad-view"),
                         [](const auto& test) {
                           std::string name = test.param;
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

}  // namespace
}  // namespace vantage::sim
