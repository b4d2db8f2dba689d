#include "vantage/features/feature_set.h"

#include <algorithm>
#include <limits>
#include <random>
#include <string>

#include <gtest/gtest.h>

#include "allocation_guard.h"
#include "eigen_matchers.h"
#include "feature_examples.h"
#include "finite_difference.h"
#include "vantage/features/point_feature.h"
#include "vantage/math/angles.h"
#include "vantage/math/error.h"
#include "vantage/math/spatial.h"

namespace vantage {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using test::MovedInWorldAxes;
using test::RandomStep;
using test::SkewedCamera;

// One feature of each kind, two of the polygons, over five points.
FeatureSet EveryKind() {
  return FeatureSet({{FeatureKind::kPointX, {0}},
                     {FeatureKind::kPointY, {1}},
                     {FeatureKind::kDistance, {0, 2}},
                     {FeatureKind::kAngle, {1, 3}},
                     {FeatureKind::kEdgeAngle, {0, 1, 3, 4}},
                     {FeatureKind::kEdgeAngle, {0, 1, 1, 2}},
                     {FeatureKind::kArea, {0, 1, 2}},
                     {FeatureKind::kArea, {4, 3, 2, 1, 0}},
                     {FeatureKind::kCentroidX, {0, 1, 2, 3}},
                     {FeatureKind::kCentroidY, {2, 3, 4}}},
                    5);
}

// Points before the camera: some on the end effector E, some in the world.
struct Scene {
  Isometry3d X_WC, X_WE;
  std::vector<Vector3d> p;  // in E or in W
  std::vector<bool> on_body;
};

Scene RandomScene(std::mt19937* random, bool all_on_body) {
  std::uniform_real_distribution<double> side(-0.4, 0.4);
  std::uniform_real_distribution<double> depth(0.8, 2.0);
  Scene scene;
  scene.X_WC = Advance(Isometry3d::Identity(), RandomStep(random, 1.0));
  scene.X_WE = Advance(Isometry3d::Identity(), RandomStep(random, 1.0));
  for (int i = 0; i < 5; ++i) {
    const double z = depth(*random);
    const Vector3d p_CP(z * side(*random), z * side(*random), z);
    const bool on_body = all_on_body || i % 2 == 0;
    const Vector3d p_WP = scene.X_WC * p_CP;
    scene.p.push_back(on_body ? Vector3d(scene.X_WE.inverse() * p_WP) : p_WP);
    scene.on_body.push_back(on_body);
  }
  return scene;
}

PointViews View(const Scene& scene) {
  PointViews views;
  for (std::size_t i = 0; i < scene.p.size(); ++i) {
    const Vector3d p_WP = scene.on_body[i] ? Vector3d(scene.X_WE * scene.p[i]) : scene.p[i];
    const auto image = Project(scene.X_WC.inverse() * p_WP);
    views.push_back({image.value_or(ImagePoint{}), image.has_value(), scene.on_body[i]});
  }
  return views;
}

FeatureRows Evaluate(const FeatureSet& set, const PointViews& views,
                     const CameraModel& camera = SkewedCamera()) {
  FeatureRows rows;
  set.Evaluate(camera, views, &rows);
  return rows;
}

Eigen::VectorXd Difference(const FeatureSet& set, const Scene& moved, const Scene& scene) {
  return FeatureError(set, Evaluate(set, View(moved)), Evaluate(set, View(scene)));
}

// Row by row: the kinds' scales differ by orders of magnitude.
void ExpectRowsNear(const Eigen::MatrixXd& J, const Eigen::MatrixXd& numeric) {
  ASSERT_EQ(J.rows(), numeric.rows());
  for (Eigen::Index i = 0; i < J.rows(); ++i) {
    const double scale = std::max(1.0, J.row(i).cwiseAbs().maxCoeff());
    EXPECT_TRUE(test::Near(J.row(i), numeric.row(i), 2e-7 * scale)) << "row " << i;
  }
}

TEST(FeatureSet, InteractionMatchesCentralDifference) {
  const FeatureSet set = EveryKind();
  std::mt19937 random(11);
  for (int trial = 0; trial < 20; ++trial) {
    const Scene scene = RandomScene(&random, false);
    const auto numeric = test::CentralDifference(
        [&](const Eigen::VectorXd& step) {
          Scene moved = scene;
          moved.X_WC = Advance(scene.X_WC, Twist(step));
          return Difference(set, moved, scene);
        },
        10, 6);
    ExpectRowsNear(Evaluate(set, View(scene)).L, numeric);
  }
}

TEST(FeatureSet, ImageJacobianMatchesCentralDifference) {
  const FeatureSet set = EveryKind();
  std::mt19937 random(12);
  for (int trial = 0; trial < 20; ++trial) {
    const Scene scene = RandomScene(&random, trial % 2 == 0);
    const auto numeric = test::CentralDifference(
        [&](const Eigen::VectorXd& step) {
          Scene moved = scene;
          moved.X_WE = MovedInWorldAxes(scene.X_WE, Twist(step));
          return Difference(set, moved, scene);
        },
        10, 6);
    const FeatureRows rows = Evaluate(set, View(scene));
    ExpectRowsNear(ImageJacobian(rows.L_body, scene.X_WC, scene.X_WE.translation()), numeric);
  }
}

TEST(FeatureSet, EyeInHandJacobianMatchesCentralDifference) {
  const FeatureSet set = EveryKind();
  std::mt19937 random(13);
  for (int trial = 0; trial < 20; ++trial) {
    const Scene scene = RandomScene(&random, false);
    const Isometry3d X_EC = scene.X_WE.inverse() * scene.X_WC;
    const auto numeric = test::CentralDifference(
        [&](const Eigen::VectorXd& step) {
          Scene moved = scene;
          moved.X_WE = MovedInWorldAxes(scene.X_WE, Twist(step));
          moved.X_WC = moved.X_WE * X_EC;
          return Difference(set, moved, scene);
        },
        10, 6);
    const FeatureRows rows = Evaluate(set, View(scene));
    ExpectRowsNear(ImageJacobianEyeInHand(rows, scene.X_WC, scene.X_WE.translation()), numeric);
  }
}

TEST(FeatureSet, ValuesOfAKnownTriangle) {
  CameraModel camera;
  camera.fx = camera.fy = 100.0;
  camera.u0 = camera.v0 = 50.0;
  // Pixels (50, 50), (80, 50), (50, 90).
  const PointViews views{{{Vector2d(0.0, 0.0), 1.0}, true, true},
                         {{Vector2d(0.3, 0.0), 2.0}, true, true},
                         {{Vector2d(0.0, 0.4), 3.0}, true, true}};
  const FeatureSet set({{FeatureKind::kPointX, {1}},
                        {FeatureKind::kPointY, {2}},
                        {FeatureKind::kDistance, {1, 2}},
                        {FeatureKind::kAngle, {0, 2}},
                        {FeatureKind::kEdgeAngle, {0, 1, 0, 2}},
                        {FeatureKind::kEdgeAngle, {0, 2, 0, 1}},
                        {FeatureKind::kArea, {0, 1, 2}},
                        {FeatureKind::kArea, {0, 2, 1}},
                        {FeatureKind::kCentroidX, {0, 1, 2}},
                        {FeatureKind::kCentroidY, {0, 1, 2}}},
                       3);
  Eigen::VectorXd expected(10);
  expected << 80, 90, 50, kPi / 2, kPi / 2, -kPi / 2, 600, -600, 60, 50 + 40.0 / 3;
  EXPECT_TRUE(test::Near(Evaluate(set, views, camera).s, expected, 1e-12));
}

TEST(FeatureSet, PointRowsAreThePointsInteractionInPixels) {
  const CameraModel camera = SkewedCamera();
  std::mt19937 random(14);
  const PointViews views = View(RandomScene(&random, true));
  const FeatureRows rows = Evaluate(FeatureSet::AllPoints(5), views, camera);
  ASSERT_EQ(rows.size(), 10);
  for (int i = 0; i < 5; ++i) {
    const Eigen::Matrix<double, 2, 6> L =
        CalibrationJacobian(camera) * PointInteraction(views[i].image);
    EXPECT_TRUE(test::Near(rows.L.middleRows<2>(2 * i), L, 1e-11));
    EXPECT_TRUE(test::Near(rows.s.segment<2>(2 * i), ToPixel(camera, views[i].image.n), 1e-11));
  }
}

// What is published is undistorted: the lens must not enter a second time.
TEST(FeatureSet, IgnoresLensDistortion) {
  std::mt19937 random(15);
  const PointViews views = View(RandomScene(&random, true));
  CameraModel bent = SkewedCamera();
  bent.distortion.k1 = -0.3;
  EXPECT_TRUE(
      test::Near(Evaluate(EveryKind(), views, bent).s, Evaluate(EveryKind(), views).s, 0.0));
}

TEST(FeatureSet, LeavesOutRowsOfUnseenPoints) {
  std::mt19937 random(16);
  PointViews views = View(RandomScene(&random, true));
  const FeatureRows all = Evaluate(EveryKind(), views);
  views[4].visible = false;
  const FeatureRows rows = Evaluate(EveryKind(), views);
  const std::vector<int> kept{0, 1, 2, 3, 5, 6, 8};
  ASSERT_EQ(rows.size(), static_cast<int>(kept.size()));
  for (int i = 0; i < rows.size(); ++i) {
    EXPECT_EQ(rows.feature[i], kept[i]);
    EXPECT_EQ(rows.s(i), all.s(kept[i]));
    EXPECT_TRUE(test::Near(rows.L.row(i), all.L.row(kept[i]), 0.0));
    EXPECT_TRUE(test::Near(rows.L_body.row(i), all.L_body.row(kept[i]), 0.0));
  }
}

TEST(FeatureSet, NoPointSeenGivesNoRows) {
  const FeatureRows rows = Evaluate(FeatureSet::AllPoints(2), PointViews(2));
  EXPECT_EQ(rows.size(), 0);
  EXPECT_EQ(rows.L.rows(), 0);
  EXPECT_EQ(ImageJacobian(rows.L_body, Isometry3d::Identity(), Vector3d::Zero()).rows(), 0);
}

class BadPoint : public ::testing::TestWithParam<ImagePoint> {};

// ViSP throws or warns at depths <= 0 and takes a NaN without a word; neither reaches it.
TEST_P(BadPoint, IsLeftOutThoughCalledVisible) {
  PointViews views(2);
  views[0] = {{Vector2d(0.1, 0.2), 1.0}, true, true};
  views[1] = {GetParam(), true, true};
  const FeatureRows rows = Evaluate(FeatureSet::AllPoints(2), views);
  ASSERT_EQ(rows.size(), 2);
  EXPECT_EQ(rows.feature[1], 1);
  EXPECT_TRUE(rows.L.allFinite());
}

INSTANTIATE_TEST_SUITE_P(
    Points, BadPoint,
    ::testing::Values(ImagePoint{Vector2d(0.1, 0.1), -1.0}, ImagePoint{Vector2d(0.1, 0.1), 0.0},
                      ImagePoint{Vector2d(0.1, 0.1), 0.5 * kMinDepth},
                      ImagePoint{Vector2d(0.1, 0.1), std::numeric_limits<double>::quiet_NaN()},
                      ImagePoint{Vector2d(0.1, 0.1), std::numeric_limits<double>::infinity()},
                      ImagePoint{Vector2d(std::numeric_limits<double>::quiet_NaN(), 0.1), 1.0}));

TEST(FeatureSet, LeavesOutRowsWithoutDerivative) {
  PointViews views(3);
  views[0] = {{Vector2d(0.1, 0.2), 1.0}, true, true};
  views[1] = {{Vector2d(0.1, 0.2), 2.0}, true, true};  // on the ray of point 0
  views[2] = {{Vector2d(0.3, 0.2), 1.0}, true, true};
  const FeatureSet set({{FeatureKind::kDistance, {0, 1}},
                        {FeatureKind::kAngle, {1, 0}},
                        {FeatureKind::kEdgeAngle, {0, 2, 0, 1}},
                        {FeatureKind::kEdgeAngle, {0, 1, 0, 2}},
                        {FeatureKind::kDistance, {1, 2}},
                        {FeatureKind::kArea, {0, 1, 2}}},
                       3);
  const FeatureRows rows = Evaluate(set, views);
  ASSERT_EQ(rows.size(), 2);
  EXPECT_EQ(rows.feature[0], 4);
  EXPECT_EQ(rows.feature[1], 5);
  EXPECT_TRUE(rows.L.allFinite());
}

TEST(FeatureError, WrapsAnglesOnly) {
  const FeatureSet set({{FeatureKind::kAngle, {0, 1}}, {FeatureKind::kPointX, {0}}}, 2);
  FeatureRows current;
  FeatureRows goal;
  current.s.resize(2);
  goal.s.resize(2);
  current.feature = goal.feature = {0, 1};
  current.s << 3.0, 100.0;
  goal.s << -3.0, 10.0;
  EXPECT_TRUE(test::Near(FeatureError(set, current, goal), Vector2d(6.0 - 2 * kPi, 90.0), 1e-14));
  current.s << -kPi / 2, 0.0;
  goal.s << kPi / 2, 0.0;
  EXPECT_EQ(FeatureError(set, current, goal)(0), kPi);  // of ±π, the one in (-π, π]
}

struct BadSet {
  std::vector<Feature> features;
  int num_points;
  std::string key;
};

class Refusal : public ::testing::TestWithParam<BadSet> {};

TEST_P(Refusal, NamesTheKey) {
  try {
    const FeatureSet set(GetParam().features, GetParam().num_points);
    FAIL() << "accepted";
  } catch (const ConfigError& error) {
    EXPECT_EQ(error.key(), GetParam().key) << error.what();
  }
}

INSTANTIATE_TEST_SUITE_P(
    FeatureSet, Refusal,
    ::testing::Values(
        BadSet{{}, 2, "features"},
        BadSet{std::vector<Feature>(kMaxRows + 1, {FeatureKind::kPointX, {0}}), 2, "features"},
        BadSet{{{FeatureKind::kPointX, {0}}}, 0, "points"},
        BadSet{{{FeatureKind::kPointX, {0}}}, kMaxPoints + 1, "points"},
        BadSet{{{FeatureKind::kPointX, {0}}, {FeatureKind::kPointY, {2}}}, 2, "features[1]"},
        BadSet{{{FeatureKind::kPointX, {-1}}}, 2, "features[0]"},
        BadSet{{{FeatureKind::kPointX, {}}}, 2, "features[0]"},
        BadSet{{{FeatureKind::kPointX, {0, 1}}}, 2, "features[0]"},
        BadSet{{{FeatureKind::kDistance, {0}}}, 2, "features[0]"},
        BadSet{{{FeatureKind::kDistance, {1, 1}}}, 2, "features[0]"},
        BadSet{{{FeatureKind::kAngle, {1, 1}}}, 2, "features[0]"},
        BadSet{{{FeatureKind::kEdgeAngle, {0, 1, 1}}}, 2, "features[0]"},
        BadSet{{{FeatureKind::kEdgeAngle, {0, 1, 1, 1}}}, 2, "features[0]"},
        BadSet{{{FeatureKind::kArea, {0, 1}}}, 2, "features[0]"},
        BadSet{{{FeatureKind::kCentroidX, {}}}, 2, "features[0]"}));

TEST(FeatureSet, AllocatesInViSPAlone) {
  if (!test::AllocationGuard::kSupported) GTEST_SKIP();
  std::mt19937 random(17);
  const FeatureSet set = EveryKind();
  PointViews views = View(RandomScene(&random, true));
  FeatureRows rows;
  set.Evaluate(SkewedCamera(), views, &rows);  // ViSP's feature of this thread is made
  {
    const test::AllocationGuard guard;
    set.Evaluate(SkewedCamera(), views, &rows);
    EXPECT_EQ(guard.count(), 10 * 5);
  }
  views[4].visible = false;
  {
    const test::AllocationGuard guard;
    set.Evaluate(SkewedCamera(), views, &rows);
    EXPECT_EQ(guard.count(), 10 * 4);
  }
  const FeatureRows goal = rows;
  const test::AllocationGuard guard;
  set.Evaluate(SkewedCamera(), views, &rows, InteractionSource::kClosedForm);
  set.EvaluateValues(SkewedCamera(), views, &rows);
  rows = goal;
  const FeatureJacobian J_v = ImageJacobian(rows.L_body, Isometry3d::Identity(), Vector3d::Zero());
  const FeatureVector error = FeatureError(set, rows, goal);
  EXPECT_EQ(guard.count(), 0);
  EXPECT_EQ(J_v.rows(), error.rows());
}

}  // namespace
}  // namespace vantage
