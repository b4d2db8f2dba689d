#include "sim/render/arm_scene.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "toy_scene.h"
#include "vantage/robot/kinematics.h"

namespace vantage::sim {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr double kHalfPi = 1.57079632679489661923;

// An elbow arm: capsules along the links, axes vertical, then horizontal twice.
ArmModel ElbowArm() {
  std::vector<DhRow> rows(3);
  rows[0].d = 0.4;
  rows[0].alpha = kHalfPi;
  rows[1].a = 0.4;
  rows[2].a = 0.3;
  Isometry3d X_WBase = Isometry3d::Identity();
  X_WBase.translation() << 0.2, -0.1, 0.05;
  const std::vector<Capsule> capsules{{-1, {0, 0, 0}, {0, 0, 0.25}, 0.07},
                                      {0, {0, -0.15, 0}, {0, 0, 0}, 0.07},
                                      {1, {-0.4, 0, 0}, {0, 0, 0}, 0.06},
                                      {2, {-0.3, 0, 0}, {0, 0, 0}, 0.05}};
  return ArmModel("elbow", DhConvention::kStandard, rows, std::vector<JointLimits>(3), X_WBase,
                  Isometry3d::Identity(), capsules);
}

// Every capsule of the arm, placed by the kinematics, is covered by pixels of bodies.
TEST(ArmScene, BodiesAreWhereTheCapsulesAre) {
  const ArmModel arm = ElbowArm();
  Scene scene = MakeArmScene(arm, {}, {});
  Renderer renderer = test::MakeRenderer(test::Camera(), scene);
  JointVector q(3);
  q << 0.4, 0.9, -1.1;
  const SceneState state(ComputeLinkPoses(arm, q), EndEffectorPose(arm, q));
  const Isometry3d X_WC = test::LookAt({0.3, -2.2, 0.8}, {0.3, 0.0, 0.5});
  IdImage ids;
  renderer.RenderIds(X_WC, state, &ids);
  std::vector<PlacedCapsule> placed;
  PlaceCapsules(arm, q, &placed);
  for (const PlacedCapsule& capsule : placed) {
    for (const double t : {0.0, 0.5, 1.0}) {
      const Vector3d p_C = X_WC.inverse() * (capsule.p_WA + t * (capsule.p_WB - capsule.p_WA));
      const Eigen::Vector2d pixel = ToPixel(renderer.camera(), p_C.head<2>() / p_C.z());
      const auto id = *ids.at(static_cast<int>(pixel.x()), static_cast<int>(pixel.y()));
      EXPECT_TRUE(id >= kIdBody && id < kIdDisc) << "link " << capsule.link << " id " << id;
    }
  }
}

// Drums stand on the joints' axes: in the world, joint 1's axis passes the centre of one of link 1's.
TEST(ArmScene, EachRevoluteJointHasADrumOnItsAxis) {
  const ArmModel arm = ElbowArm();
  const std::vector<Body> bodies = MakeArmBodies(arm);
  const int capsules = static_cast<int>(arm.capsules().size());
  ASSERT_EQ(static_cast<int>(bodies.size()), capsules + arm.size());
  const LinkPoses X_WL = ComputeLinkPoses(arm, JointVector::Zero(3));
  const Vector3d elbow(0.2 + 0.4, -0.1, 0.45);  // Joint 2's axis runs along W's -y through here.
  const Body& drum = bodies[capsules + 2];
  EXPECT_EQ(drum.frame, 2);
  const BoundingSphere bound = Bound(drum.mesh);
  EXPECT_LT((X_WL[2] * bound.centre - elbow).norm(), 1e-6);
  double along = 0.0;
  double across = 0.0;
  for (const Eigen::Vector3f& vertex : drum.mesh.vertices) {
    const Vector3d p = X_WL[2] * vertex.cast<double>() - elbow;
    along = std::max(along, std::abs(p.y()));
    across = std::max(across, std::hypot(p.x(), p.z()));
  }
  EXPECT_GT(along, across);
}

TEST(ArmScene, MarkersAreOnTheToolAndInTheWorld) {
  const ArmModel arm = ElbowArm();
  Marker tool;
  tool.id = 1;
  tool.p = Vector3d(0.0, 0.0, 0.12);
  Marker goal;
  goal.id = 2;
  goal.p = Vector3d(0.5, 0.3, 0.2);
  const Scene scene = MakeArmScene(arm, {tool}, {goal});
  ASSERT_EQ(scene.markers.size(), 2U);
  EXPECT_EQ(scene.markers[0].frame, kToolFrame);
  EXPECT_EQ(scene.markers[1].frame, kGoalFrame);
  ASSERT_EQ(scene.capsules.size(), arm.capsules().size());
  EXPECT_TRUE(scene.capsules[0].p_LB.isApprox(Vector3d(0.2, -0.1, 0.3)));
}

// Signed, of the cone from `origin` over all triangles; of a closed surface the same for every origin [m^3].
double Volume(const TriangleMesh& mesh, const Vector3d& origin = Vector3d::Zero()) {
  double sum = 0.0;
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    const auto at = [&](std::size_t k) -> Vector3d {
      return mesh.vertices[mesh.indices[i + k]].cast<double>() - origin;
    };
    sum += at(0).dot(at(1).cross(at(2))) / 6.0;
  }
  return sum;
}

TEST(Mesh, PrimitivesAreClosedAndFaceOutwards) {
  for (const TriangleMesh& mesh :
       {CapsuleMesh({0.1, 0.2, 0.3}, {0.4, 0.1, 0.9}, 0.1), CapsuleMesh({0, 0, 0}, {0, 0, 0}, 0.2),
        CylinderMesh({0, 0, 0}, {0.3, 0, 0.1}, 0.1, 0.02),
        CylinderMesh({0, 0, 0}, {0, 0, -1}, 0.1, 0.0), BoxMesh({0.1, 0.2, 0.3})}) {
    EXPECT_GT(Volume(mesh), 0.0);
    EXPECT_NEAR(Volume(mesh), Volume(mesh, {3.0, -2.0, 5.0}), 1e-5);
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
      const auto vertex = [&](std::size_t k) { return mesh.vertices[mesh.indices[i + k]]; };
      const Eigen::Vector3f normal =
          (vertex(1) - vertex(0)).cross(vertex(2) - vertex(0)).normalized();
      EXPECT_GT(normal.dot(mesh.normals[mesh.indices[i]]), 0.5F);
    }
  }
}

TEST(Mesh, CapsuleHasItsVolume) {
  const TriangleMesh mesh = CapsuleMesh({0, 0, 0}, {0, 0, 0.5}, 0.1, 64);
  const double exact = 2.0 * kHalfPi * (0.01 * 0.5 + 4.0 / 3.0 * 0.001);
  EXPECT_NEAR(Volume(mesh) / exact, 1.0, 0.01);
}

}  // namespace
}  // namespace vantage::sim
