#include "vantage/active/view.h"

#include <functional>
#include <random>
#include <string>

#include <gtest/gtest.h>

#include "allocation_guard.h"
#include "cells.h"
#include "eigen_matchers.h"
#include "finite_difference.h"
#include "vantage/math/error.h"

namespace vantage {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// Every kind of feature over four points.
FeatureSet EveryKind() {
  return FeatureSet({{FeatureKind::kPointX, {0}},
                     {FeatureKind::kPointY, {3}},
                     {FeatureKind::kDistance, {0, 2}},
                     {FeatureKind::kAngle, {1, 2}},
                     {FeatureKind::kEdgeAngle, {0, 1, 2, 3}},
                     {FeatureKind::kArea, {0, 1, 3, 2}},
                     {FeatureKind::kArea, {0, 1, 3}},
                     {FeatureKind::kCentroidX, {0, 1, 2}},
                     {FeatureKind::kCentroidY, {0, 1, 2, 3}}},
                    4);
}

// A camera that looks at the plate's middle from somewhere before it.
Isometry3d Before(const ArmSample& sample, std::mt19937* random) {
  std::uniform_real_distribution<double> part(-1.0, 1.0);
  Vector3d middle = Vector3d::Zero();
  for (const PlacedMarker& marker : sample.markers) middle += marker.p_W / sample.markers.size();
  const Vector3d sideways(part(*random), part(*random), part(*random));
  const Vector3d z = -(sample.markers[0].normal_W + 0.4 * sideways).normalized();
  const Vector3d x = z.cross(Vector3d(part(*random), part(*random), part(*random))).normalized();
  Isometry3d X_WC = Isometry3d::Identity();
  X_WC.linear() << x, z.cross(x), z;
  X_WC.translation() = middle - (1.0 + 0.3 * part(*random)) * z + 0.05 * sideways;
  return X_WC;
}

FeatureRows RowsAt(const ViewModel& model, const JointVector& q, const Isometry3d& X_WC) {
  PointViews points;
  const Isometry3d X_CE = X_WC.inverse() * EndEffectorPose(model.arm, q);
  for (const Marker& marker : model.markers)
    points.push_back({*Project(X_CE * marker.p), true, true});
  FeatureRows rows;
  model.features.Evaluate(model.camera, points, &rows);
  return rows;
}

TEST(CompositeJacobian, MatchesCentralDifferenceOfEveryFeature) {
  test::Cell cell = test::Puma560();
  cell.model.features = EveryKind();
  cell.model.camera.skew = 3.0;
  cell.model.camera.fy = 580.0;
  std::mt19937 random(21);
  for (int trial = 0; trial < 20; ++trial) {
    const JointVector q = test::RandomJoints(cell, &random);
    const ArmSample sample = SampleArm(cell.model, q);
    const Isometry3d X_WC = Before(sample, &random);
    const auto numeric = test::CentralDifference(
        [&](const Eigen::VectorXd& step) -> Eigen::VectorXd {
          return RowsAt(cell.model, q + JointVector(step), X_WC).s;
        },
        9, 6);
    const TaskJacobian J = CompositeJacobian(cell.model, sample, X_WC);
    ASSERT_EQ(J.rows(), 9);
    for (int row = 0; row < 9; ++row) {
      const double scale = std::max(1.0, numeric.row(row).cwiseAbs().maxCoeff());
      EXPECT_TRUE(test::Near(J.row(row), numeric.row(row), 2e-8 * scale)) << "row " << row;
    }
  }
}

TEST(CompositeJacobian, EqualsImageJacobianTimesArmJacobian) {
  test::Cell cell = test::Puma560();
  cell.model.features = EveryKind();
  std::mt19937 random(22);
  for (int trial = 0; trial < 20; ++trial) {
    const JointVector q = test::RandomJoints(cell, &random);
    const ArmSample sample = SampleArm(cell.model, q);
    const Isometry3d X_WC = Before(sample, &random);
    const FeatureRows rows = RowsAt(cell.model, q, X_WC);
    const TaskJacobian reference =
        ImageJacobian(rows.L_body, X_WC, sample.kinematics.X_WE.translation()) *
        sample.kinematics.J_WE_W;
    const TaskJacobian J = CompositeJacobian(cell.model, sample, X_WC);
    EXPECT_TRUE(test::Near(J, reference, 1e-9 * reference.cwiseAbs().maxCoeff()));
  }
}

TEST(CompositeJacobian, LeavesOutRowsOfPointsBehind) {
  const test::Cell cell = test::Puma3Points();
  const ArmSample sample = SampleArm(cell.model, Vector3d(0.0, 0.6, -1.2));
  // Before the first marker, but past the second.
  const Vector3d between = sample.markers[1].p_W - sample.markers[0].p_W;
  Isometry3d X_WC = Isometry3d::Identity();
  const Vector3d z = -between.normalized();
  const Vector3d x = z.unitOrthogonal();
  X_WC.linear() << x, z.cross(x), z;
  X_WC.translation() = sample.markers[0].p_W - 0.5 * between.norm() * z;
  EXPECT_EQ(CompositeJacobian(cell.model, sample, X_WC).rows(), 2);
}

TEST(SampleArm, PlacesMarkersAndTheirVelocities) {
  for (const test::Cell& cell : test::AllCells()) {
    std::mt19937 random(23);
    const JointVector q = test::RandomJoints(cell, &random);
    const ArmSample sample = SampleArm(cell.model, q);
    ASSERT_EQ(sample.markers.size(), cell.model.markers.size());
    EXPECT_EQ(sample.capsules.size(), cell.model.arm.capsules().size());
    for (std::size_t i = 0; i < sample.markers.size(); ++i) {
      const auto numeric = test::CentralDifference(
          [&](const Eigen::VectorXd& step) -> Eigen::VectorXd {
            return EndEffectorPose(cell.model.arm, q + JointVector(step)) * cell.model.markers[i].p;
          },
          3, cell.model.arm.size());
      EXPECT_TRUE(test::Near(sample.J_marker_W[i], numeric, 1e-9)) << cell.name;
      EXPECT_NEAR(sample.markers[i].normal_W.norm(), 1.0, 1e-12);
    }
  }
}

TEST(SampleArm, IntoStorageDoesNotAllocate) {
  if (!test::AllocationGuard::kSupported) GTEST_SKIP();
  const test::Cell cell = test::Puma560();
  std::mt19937 random(24);
  ArmSample sample = SampleArm(cell.model, test::RandomJoints(cell, &random));
  const Isometry3d X_WC = Before(sample, &random);
  const JointVector q = test::RandomJoints(cell, &random);
  const test::AllocationGuard guard;
  SampleArm(cell.model, q, &sample);
  const TaskJacobian J = CompositeJacobian(cell.model, sample, X_WC);
  (void)CheckMarker(cell.model.camera, {}, X_WC, sample.markers[0], sample.capsules);
  EXPECT_EQ(guard.count(), 0u);
  EXPECT_EQ(J.rows(), 8);
}

// The camera at the origin looks along Wz at a marker that faces it from 1 m.
struct FaultCase {
  const char* name;
  ViewFault fault;
  std::function<void(PlacedMarker*, std::vector<PlacedCapsule>*)> spoil;
};

PlacedMarker GoodMarker() {
  return {{0.05, -0.02, 1.0}, {0.0, 0.0, -1.0}, 0.01};
}

class CheckMarkerFinds : public ::testing::TestWithParam<FaultCase> {};

TEST_P(CheckMarkerFinds, OneFault) {
  PlacedMarker marker = GoodMarker();
  std::vector<PlacedCapsule> capsules{{{1.0, 0.0, 0.5}, {1.0, 0.0, 0.8}, 0.1, 0}};
  const CameraModel camera;
  ASSERT_EQ(CheckMarker(camera, {}, Isometry3d::Identity(), marker, capsules), ViewFault::kNone);
  GetParam().spoil(&marker, &capsules);
  EXPECT_EQ(CheckMarker(camera, {}, Isometry3d::Identity(), marker, capsules), GetParam().fault)
      << Name(GetParam().fault);
}

using Capsules = std::vector<PlacedCapsule>;

INSTANTIATE_TEST_SUITE_P(
    Faults, CheckMarkerFinds,
    ::testing::Values(
        FaultCase{"Behind", ViewFault::kBehind,
                  [](PlacedMarker* m, Capsules*) { m->p_W.z() = -1.0; }},
        FaultCase{"TooNear", ViewFault::kTooNear,
                  [](PlacedMarker* m, Capsules*) { m->p_W = Vector3d(0.0, 0.0, 0.29); }},
        FaultCase{"TooFar", ViewFault::kTooFar,
                  [](PlacedMarker* m, Capsules*) { m->p_W = Vector3d(0.0, 0.0, 20.1); }},
        FaultCase{"OutOfImage", ViewFault::kOutOfImage,
                  [](PlacedMarker* m, Capsules*) { m->p_W.x() = 0.51; }},
        FaultCase{"FacesAway", ViewFault::kFacesAway,
                  [](PlacedMarker* m, Capsules*) { m->normal_W = Vector3d(0.0, 0.0, 1.0); }},
        FaultCase{"Oblique", ViewFault::kFacesAway,
                  [](PlacedMarker* m, Capsules*) {
                    m->normal_W = Vector3d(std::sin(1.4), 0.0, -std::cos(1.4));
                  }},
        FaultCase{"TooSmall", ViewFault::kTooSmall,
                  [](PlacedMarker* m, Capsules*) { m->radius = 0.003; }},  // 1.8 px
        FaultCase{"Hidden", ViewFault::kHidden,
                  [](PlacedMarker*, Capsules* c) {
                    c->push_back({{-1.0, 0.0, 0.5}, {1.0, 0.0, 0.5}, 0.05, 0});
                  }},
        FaultCase{"RingHidden", ViewFault::kHidden,
                  [](PlacedMarker*, Capsules* c) {
                    // The ray to the centre passes at 0.06 m, the ring reaches 0.02 m further.
                    c->push_back({{-1.0, 0.05, 0.5}, {1.0, 0.05, 0.5}, 0.05, 0});
                  }},
        FaultCase{
            "OrderIsAsDocumented", ViewFault::kTooNear,
            [](PlacedMarker* m, Capsules* c) {
              *m = {{0.3, 0.0, 0.2}, {0.0, 0.0, 1.0}, 0.01};  // Too near, out of image, turned
              c->push_back({{-1.0, 0.0, 0.1}, {1.0, 0.0, 0.1}, 0.05, 0});  // and hidden.
            }}),
    [](const auto& test) { return std::string(test.param.name); });

// A plate 5 cm before the marker, towards the camera, covers what it overlaps in the image; one behind it, or beside
// it in the same plane, covers nothing.
TEST(IsCovered, ByAPlateThatStandsBefore) {
  const PlacedMarker marker = GoodMarker();
  const Vector3d p_WC = Vector3d::Zero();
  const auto covered = [&](const Vector3d& step) {
    PlacedMarker other = marker;
    other.p_W += step;
    return IsCovered(p_WC, marker, {marker, other});
  };
  EXPECT_FALSE(IsCovered(p_WC, marker, {marker}));  // not by itself
  PlacedMarker tilted = marker;
  tilted.normal_W = Vector3d(0.3, -0.2, -0.9).normalized();
  EXPECT_FALSE(IsCovered(p_WC, tilted, {tilted}));  // nor by its own rounding
  EXPECT_TRUE(covered({0.0, 0.0, -0.05}));
  EXPECT_TRUE(covered({0.035, 0.0, -0.05}));   // the rim of one over the ring of the other
  EXPECT_FALSE(covered({0.055, 0.0, -0.05}));  // clear of it: 2.25 + 2 radii are 4.25 cm
  EXPECT_FALSE(covered({0.0, 0.0, 0.05}));
  EXPECT_FALSE(covered({0.045, 0.0, 0.0}));
}

TEST(CheckMarker, CarrierHidesOnlyFromBehind) {
  const CameraModel camera;
  PlacedMarker marker = GoodMarker();
  // On the skin of its carrier, on the camera's side; inside it; on the far side of it.
  const PlacedCapsule behind{{0.05, -0.5, 1.1}, {0.05, 0.5, 1.1}, 0.1, 2};
  EXPECT_EQ(CheckMarker(camera, {}, Isometry3d::Identity(), marker, {behind}), ViewFault::kNone);
  const PlacedCapsule around{{0.05, -0.5, 1.05}, {0.05, 0.5, 1.05}, 0.1, 2};
  EXPECT_EQ(CheckMarker(camera, {}, Isometry3d::Identity(), marker, {around}), ViewFault::kNone);
  marker.normal_W = Vector3d(0.0, 0.0, 1.0);
  const PlacedCapsule before{{0.05, -0.5, 0.9}, {0.05, 0.5, 0.9}, 0.1, 2};
  EXPECT_EQ(CheckMarker(camera, {}, Isometry3d::Identity(), marker, {before}),
            ViewFault::kFacesAway);
}

TEST(CheckMarker, MarginCountsThroughTheLens) {
  CameraModel camera;
  camera.distortion.k1 = -0.2;
  const PlacedMarker marker{{0.52, 0.0, 1.0}, {0.0, 0.0, -1.0}, 0.01};
  // The ideal lens puts it at u = 631, this one 17 px further in.
  EXPECT_EQ(CheckMarker(CameraModel{}, {}, Isometry3d::Identity(), marker, {}),
            ViewFault::kOutOfImage);
  EXPECT_EQ(CheckMarker(camera, {}, Isometry3d::Identity(), marker, {}), ViewFault::kNone);
}

// Random rays: the check says what marching along them says.
TEST(IsHidden, AgreesWithMarching) {
  std::mt19937 random(25);
  int hidden = 0;
  for (const test::Cell& cell : test::AllCells()) {
    for (int trial = 0; trial < 200; ++trial) {
      ArmSample sample = SampleArm(cell.model, test::RandomJoints(cell, &random));
      const Isometry3d X_WC = RigPose(cell.rig, test::RandomRig(cell.rig, &random));
      // The arm's own links seldom hide its markers: one more body, about halfway to the camera.
      std::uniform_real_distribution<double> part(-0.15, 0.15);
      const Vector3d halfway = 0.5 * (X_WC.translation() + sample.markers[0].p_W);
      const Vector3d body(part(random), part(random), part(random));
      sample.capsules.push_back(
          {halfway + body, halfway + body + 0.2 * Vector3d::UnitZ(), 0.06, 0});
      for (const PlacedMarker& marker : sample.markers) {
        PlacedMarker dot = marker;
        dot.radius = 1e-9;
        const Vector3d ray = X_WC.translation() - marker.p_W;
        if (ray.dot(marker.normal_W) < 0.3 * ray.norm()) continue;
        CameraModel wide;  // so that nothing but capsules hides a marker
        wide.width = wide.height = 1 << 20;
        wide.u0 = wide.v0 = 1 << 19;
        if ((X_WC.inverse() * marker.p_W).z() < 0.1) continue;
        const bool seen = test::SeenByMarching(wide, X_WC, marker, sample.capsules, 0.0);
        // Marching in steps may pass by a capsule's rim: only clear cases count.
        std::vector<PlacedCapsule> thinner = sample.capsules, thicker = sample.capsules;
        for (PlacedCapsule& c : thinner) c.radius -= 2e-3;
        for (PlacedCapsule& c : thicker) c.radius += 2e-3;
        if (IsHidden(X_WC.translation(), dot, thinner)) {
          EXPECT_FALSE(seen) << cell.name;
        }
        if (!IsHidden(X_WC.translation(), dot, thicker)) {
          EXPECT_TRUE(seen) << cell.name;
        }
        hidden += seen ? 0 : 1;
      }
    }
  }
  EXPECT_GT(hidden, 20);
}

TEST(ValidateViewModel, RefusesEachCause) {
  const test::Cell good = test::Puma3Points();
  EXPECT_NO_THROW(Validate(good.model));
  ViewModel bad = good.model;
  bad.markers.pop_back();
  EXPECT_THROW(Validate(bad), ConfigError);
  bad = good.model;
  bad.markers[0].radius = 0.0;
  EXPECT_THROW(Validate(bad), ConfigError);
  bad = good.model;
  bad.markers[0].normal *= 1.1;
  EXPECT_THROW(Validate(bad), ConfigError);
  bad = good.model;
  bad.markers[0].p.x() = std::nan("");
  EXPECT_THROW(Validate(bad), ConfigError);
}

}  // namespace
}  // namespace vantage
