#include "vantage/plan/arm_motion.h"

#include <numeric>

#include <gtest/gtest.h>

#include "cell.h"
#include "config_error.h"

namespace vantage::test {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

JointVector Joints3(double a, double b, double c) {
  JointVector q(3);
  q << a, b, c;
  return q;
}

double Sum(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

TEST(MoveThroughJoints, PassesItsWaypointsAndWeighsTheWholeTime) {
  const ViewModel view = PumaView(3);
  const std::vector<JointVector> waypoints{Joints3(0, 0, 0), Joints3(1, 0, 0), Joints3(1, 0.5, 0)};
  // Travel 1 and 0.5: with four samples the corner is the third.
  const ArmMotion motion = MoveThroughJoints(view, waypoints, 6.0, 4);
  ASSERT_EQ(motion.size(), 4);
  EXPECT_TRUE(motion.samples[0].q.isApprox(waypoints[0]));
  EXPECT_TRUE(motion.samples[1].q.isApprox(Joints3(0.5, 0, 0), 1e-12));
  EXPECT_TRUE(motion.samples[2].q.isApprox(waypoints[1], 1e-12));
  EXPECT_EQ(motion.samples[3].q, waypoints[2]);
  EXPECT_DOUBLE_EQ(Sum(motion.weight), 6.0);
  EXPECT_DOUBLE_EQ(motion.weight[0], 1.0);
  EXPECT_DOUBLE_EQ(motion.time.back(), 6.0);
}

TEST(MoveThroughJoints, OfOneWaypointStandsStill) {
  const ArmMotion motion = MoveThroughJoints(PumaView(3), {Joints3(0.1, 0.2, 0.3)}, 2.0, 50);
  ASSERT_EQ(motion.size(), 1);
  EXPECT_DOUBLE_EQ(motion.weight[0], 2.0);
}

TEST(MoveThroughJoints, RefusesWhatIsOutOfLimits) {
  EXPECT_EQ(ConfigErrorOf([] {
              (void)MoveThroughJoints(PumaView(3), {Joints3(0, 0, 9)}, 1.0, 8);
            }).find("motion.path[0]"),
            0);
  EXPECT_EQ(ConfigErrorOf([] {
              (void)MoveThroughJoints(PumaView(6), {Joints3(0, 0, 0)}, 1.0, 8);
            }).find("motion.path[0]"),
            0);
  EXPECT_EQ(ConfigErrorOf([] {
              (void)MoveThroughJoints(PumaView(3), {Joints3(0, 0, 0)}, 0.0, 8);
            }).find("motion.duration"),
            0);
}

TEST(MoveThroughPoses, KeepsToTheStraightLine) {
  const ViewModel view = PumaView(6);
  const JointVector q = PumaMotion(view).samples[10].q;
  const Isometry3d first = EndEffectorPose(view.arm, q);
  Isometry3d last = first;
  last.translation() += Vector3d(0.05, -0.1, 0.02);
  last.linear() = first.linear() * Eigen::AngleAxisd(0.3, Vector3d::UnitY()).toRotationMatrix();
  const ArmMotion motion = MoveThroughPoses(view, {first, last}, PathFrame::kPose, q, 1.0, 11);
  for (int i = 0; i < 11; ++i) {
    const Isometry3d X_WE = motion.samples[i].kinematics.X_WE;
    const Vector3d p = first.translation() + 0.1 * i * (last.translation() - first.translation());
    EXPECT_LT((X_WE.translation() - p).norm(), 1e-7) << i;
    const Eigen::AngleAxisd turn(first.linear().transpose() * X_WE.linear());
    EXPECT_NEAR(turn.angle(), 0.03 * i, 1e-6) << i;
  }
}

TEST(MoveThroughPoses, SaysWhereTheArmDoesNotReach) {
  const ViewModel view = PumaView(3);
  const JointVector q = PumaMotion(view).samples[0].q;
  const Isometry3d first = EndEffectorPose(view.arm, q);
  Isometry3d last = first;
  last.translation() += Vector3d(5.0, 0.0, 0.0);
  EXPECT_EQ(ConfigErrorOf([&] {
              (void)MoveThroughPoses(view, {first, last}, PathFrame::kPosition, q, 1.0, 11);
            }).find("motion.path"),
            0);
}

}  // namespace
}  // namespace vantage::test
