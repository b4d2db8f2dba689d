// The fast eye against geometry worked out here.

#include "sim/kinematic_eye.h"

#include <gtest/gtest.h>

#include "eigen_matchers.h"
#include "vantage/config/loaders.h"

namespace vantage::sim {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// Straight down from `height` above (x, y): image x along Wx, image y along -Wy.
Isometry3d LookDown(double x, double y, double height) {
  Isometry3d X_WC = Isometry3d::Identity();
  X_WC.linear() = Vector3d(1.0, -1.0, -1.0).asDiagonal();
  X_WC.translation() = Vector3d(x, y, height);
  return X_WC;
}

struct Cell {
  ArmModel arm = FindRobot("planar2");
  Marker tool{0, {0.0, 0.0, 0.025}, Vector3d::UnitZ(), 0.014, true};
  Marker goal{10, {0.3, 0.2, 0.025}, Vector3d::UnitZ(), 0.014, false};
  JointVector q = JointVector::Zero(2);

  ImageFeatures See(const Isometry3d& X_WC, double sigma = 0.0) {
    KinematicEye eye(arm, CameraModel(), {tool}, {goal}, sigma, 1);
    ImageFeatures features;
    MarkerPrediction tool_prediction, goal_prediction;
    tool_prediction.id = tool.id;
    goal_prediction.id = goal.id;
    eye.See(Time{}, X_WC, q, Isometry3d::Identity(), {tool_prediction, goal_prediction}, &features);
    return features;
  }
};

TEST(KinematicEye, ProjectsBothMarkers) {
  Cell setup;
  const ImageFeatures features = setup.See(LookDown(0.5, 0.0, 1.025));
  ASSERT_EQ(features.count, 2);
  // The arm's tip is at x = 0.7 m, so 0.2 m from the axis at a depth of 1 m.
  ASSERT_TRUE(features.Find(0)->valid);
  EXPECT_TRUE(test::Near(features.Find(0)->pixel, Vector2d(319.5 + 120.0, 239.5), 1e-9));
  ASSERT_TRUE(features.Find(10)->valid);
  EXPECT_TRUE(test::Near(features.Find(10)->pixel, Vector2d(319.5 - 120.0, 239.5 - 120.0), 1e-9));
}

TEST(KinematicEye, AddsNoise) {
  Cell setup;
  const Isometry3d X_WC = LookDown(0.5, 0.0, 1.025);
  const Vector2d difference = setup.See(X_WC, 0.5).Find(0)->pixel - setup.See(X_WC).Find(0)->pixel;
  EXPECT_GT(difference.norm(), 0.0);
  EXPECT_LT(difference.norm(), 4.0);
}

TEST(KinematicEye, LosesWhatTheDetectorWould) {
  Cell setup;
  const auto sees = [&](const Isometry3d& X_WC) { return setup.See(X_WC).Find(0)->valid; };
  EXPECT_TRUE(sees(LookDown(0.7, 0.0, 2.0)));
  EXPECT_FALSE(sees(LookDown(0.7, 0.0, 6.0)));    // too small
  EXPECT_FALSE(sees(LookDown(0.0, 0.0, 1.025)));  // out of the image
  EXPECT_FALSE(sees(LookDown(0.7, 0.0, -1.0)));   // behind the camera
  setup.tool.normal = -Vector3d::UnitZ();
  EXPECT_FALSE(sees(LookDown(0.7, 0.0, 1.025)));  // faces away
}

TEST(KinematicEye, LosesWhatALinkHides) {
  Cell setup;
  // The goal's marker under the upper arm.
  setup.goal.p = {0.2, 0.0, -0.1};
  EXPECT_FALSE(setup.See(LookDown(0.2, 0.0, 1.0)).Find(10)->valid);
  setup.goal.p = {0.2, 0.15, -0.1};
  EXPECT_TRUE(setup.See(LookDown(0.2, 0.15, 1.0)).Find(10)->valid);
}

}  // namespace
}  // namespace vantage::sim
