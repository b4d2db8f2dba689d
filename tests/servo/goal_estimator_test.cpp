#include "vantage/servo/goal_estimator.h"

#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "vantage/camera/pinhole.h"

namespace vantage {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

const Vector3d kTruth(0.1, -0.05, 1.5);

Vector2d See(const CameraModel& camera, const Isometry3d& X_WC) {
  return CalibrationJacobian(camera) * Project(X_WC.inverse() * kTruth)->n +
         Vector2d(camera.u0, camera.v0);
}

// The camera stands still: the image of the estimate is right, the depth stays the prior's.
TEST(GoalPointEstimator, AStandingCameraFixesTheRay) {
  const CameraModel camera;
  const Isometry3d X_WC = Isometry3d::Identity();
  GoalPointEstimator goal(kTruth + Vector3d(0.03, 0.02, 0.05), 0.05);
  for (int i = 0; i < 50; ++i) ASSERT_TRUE(goal.Update(camera, X_WC, See(camera, X_WC), 0.3));
  const Vector2d n = Project(goal.p_WG())->n;
  EXPECT_NEAR((n - Project(kTruth)->n).norm() * camera.fx, 0.0, 0.1);
  EXPECT_GT(std::sqrt(goal.covariance()(2, 2)), 0.02);
}

// A camera that moves sideways by 0.8 m finds the depth too, through noise.
TEST(GoalPointEstimator, AMovingCameraFixesTheDepth) {
  const CameraModel camera;
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0.0, 0.3);
  GoalPointEstimator goal(kTruth + Vector3d(-0.03, 0.02, 0.08), 0.06);
  for (int i = 0; i < 120; ++i) {
    Isometry3d X_WC = Isometry3d::Identity();
    X_WC.translation().x() = -0.4 + 0.8 * i / 119.0;
    ASSERT_TRUE(
        goal.Update(camera, X_WC, See(camera, X_WC) + Vector2d(noise(random), noise(random)), 0.3));
  }
  EXPECT_LT((goal.p_WG() - kTruth).norm(), 1e-3);
  // The filter knows how sure it is.
  const Vector3d off = goal.p_WG() - kTruth;
  EXPECT_LT(off.dot(goal.covariance().inverse() * off), 16.0);
}

TEST(GoalPointEstimator, RefusesWhatCannotBeTheMarker) {
  const CameraModel camera;
  const Isometry3d X_WC = Isometry3d::Identity();
  GoalPointEstimator goal(kTruth, 0.02);
  const Vector3d before = goal.p_WG();
  EXPECT_FALSE(goal.Update(camera, X_WC, See(camera, X_WC) + Vector2d(120, 0), 0.3));
  EXPECT_FALSE(goal.Update(camera, X_WC, {std::numeric_limits<double>::quiet_NaN(), 0}, 0.3));
  Isometry3d beyond = Isometry3d::Identity();
  beyond.translation().z() = 3.0;
  EXPECT_FALSE(goal.Update(camera, beyond, {320, 240}, 0.3));
  EXPECT_EQ(goal.p_WG(), before);
}

// One outlier is refused; when the marker stays elsewhere, it is the prior that was wrong.
TEST(GoalPointEstimator, GivesUpAPriorThatManyImagesContradict) {
  const CameraModel camera;
  GoalPointEstimator goal(kTruth + Vector3d(0.25, 0.0, 0.0), 0.02);
  bool accepted = false;
  for (int i = 0; i < 60; ++i) {
    Isometry3d X_WC = Isometry3d::Identity();
    X_WC.translation().x() = -0.3 + 0.01 * i;
    const bool taken = goal.Update(camera, X_WC, See(camera, X_WC), 0.3);
    if (i < 10) {
      EXPECT_FALSE(taken) << i;
    }
    accepted = accepted || taken;
  }
  EXPECT_TRUE(accepted);
  EXPECT_LT((goal.p_WG() - kTruth).norm(), 0.02);
}

}  // namespace
}  // namespace vantage
