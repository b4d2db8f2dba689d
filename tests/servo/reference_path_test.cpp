#include "vantage/servo/reference_path.h"

#include <gtest/gtest.h>

#include "eigen_matchers.h"

namespace vantage {
namespace {

ArmModel TwoJoints() {
  std::vector<DhRow> rows(2);
  rows[0] = {JointKind::kRevolute, 0.0, 0.0, 0.4, 0.0, 0.0};
  rows[1] = {JointKind::kRevolute, 0.0, 0.0, 0.3, 0.0, 0.0};
  JointLimits fast, slow;
  fast.velocity = 3.0;
  slow.velocity = 0.3;
  return ArmModel("two", DhConvention::kStandard, rows, {fast, slow}, Eigen::Isometry3d::Identity(),
                  Eigen::Isometry3d::Identity());
}

JointVector Joints(double a, double b) {
  JointVector q(2);
  q << a, b;
  return q;
}

TEST(ReferenceAhead, IsTheGoalWithinReach) {
  const JointVector q = Joints(0.1, 0.5), q_goal = Joints(0.3, 0.52);
  const PathReference reference = ReferenceAhead({}, TwoJoints(), q, q_goal, 3.0);
  EXPECT_EQ(reference.share, 1.0);
  EXPECT_TRUE(test::Near(reference.step, q_goal - q, 0.0));
}

TEST(ReferenceAhead, RunsAheadByItsReach) {
  const ArmModel arm = TwoJoints();
  const JointVector q = Joints(0.1, 0.5), q_goal = Joints(1.1, 0.52);
  const PathReference reference = ReferenceAhead({}, arm, q, q_goal, 3.0);
  EXPECT_NEAR(reference.share, 0.25, 1e-12);
  EXPECT_TRUE(test::Near(reference.step, 0.25 * (q_goal - q), 1e-12));
  EXPECT_TRUE(
      test::Near(reference.X_WE.matrix(), EndEffectorPose(arm, q + reference.step).matrix(), 0.0));
}

// A slow joint shortens the step of all, so that the way stays straight.
TEST(ReferenceAhead, AsksNoJointForMoreThanItsSpeed) {
  const JointVector q = Joints(0.0, 0.0), q_goal = Joints(0.2, 0.2);
  const double gain = 3.0;
  const PathReference reference = ReferenceAhead({}, TwoJoints(), q, q_goal, gain);
  EXPECT_NEAR(gain * reference.step(1), 0.7 * 0.3, 1e-12);
  EXPECT_NEAR(reference.step(0), reference.step(1), 1e-12);
}

}  // namespace
}  // namespace vantage
