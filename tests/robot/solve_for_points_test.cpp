#include <random>

#include <gtest/gtest.h>

#include "eigen_matchers.h"
#include "oracle_arm.h"
#include "vantage/robot/kinematics.h"

namespace vantage {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

const std::vector<Vector3d> kTriangle_E{{0.05, 0.0, 0.0}, {-0.03, 0.05, 0.02}, {0.0, -0.06, 0.01}};

std::vector<Vector3d> PointsAt(const ArmModel& arm, const JointVector& q,
                               const std::vector<Vector3d>& p_EP) {
  const Isometry3d X_WE = EndEffectorPose(arm, q);
  std::vector<Vector3d> p_WP;
  for (const Vector3d& p : p_EP) p_WP.push_back(X_WE * p);
  return p_WP;
}

ArmModel OracleArmNamed(const std::string& name) {
  const nlohmann::json oracles = test::ReadOracles();
  for (const auto& test_case : oracles.at("cases")) {
    if (test_case.at("robot").at("name") == name) return test::OracleArm(test_case.at("robot"));
  }
  throw std::runtime_error("no such arm: " + name);
}

class SolveForPointsOf : public ::testing::TestWithParam<const char*> {};

// Every goal that the arm can reach is reached, from starts up to 1 rad away in each joint.
TEST_P(SolveForPointsOf, ReachesWhatTheArmCanReach) {
  const ArmModel wide = OracleArmNamed(GetParam());
  const ArmModel arm =
      wide.WithLimits(std::vector<JointLimits>(wide.size(), {-2.8, 2.8, 1.0, 1.0}));
  std::mt19937 random(8);
  std::uniform_real_distribution<double> value(-1.7, 1.7);
  std::uniform_real_distribution<double> step(-1.0, 1.0);
  for (int trial = 0; trial < 100; ++trial) {
    JointVector q_goal(arm.size());
    JointVector q_start(arm.size());
    for (int i = 0; i < arm.size(); ++i) {
      q_goal(i) = value(random);
      q_start(i) = q_goal(i) + step(random);
    }
    const auto p_WP = PointsAt(arm, q_goal, kTriangle_E);
    const PointGoalSolution solution = SolveForPoints(arm, kTriangle_E, p_WP, q_start);
    EXPECT_TRUE(solution.converged) << "trial " << trial << " rms " << solution.rms_error;
    EXPECT_TRUE(WithinLimits(arm, solution.q));
    const auto reached = PointsAt(arm, solution.q, kTriangle_E);
    double squares = 0.0;
    for (std::size_t i = 0; i < reached.size(); ++i)
      squares += (reached[i] - p_WP[i]).squaredNorm();
    EXPECT_NEAR(solution.rms_error, std::sqrt(squares / 3.0), 1e-12);
    EXPECT_LT(std::sqrt(squares / 3.0), 1e-6);
  }
}

INSTANTIATE_TEST_SUITE_P(Arms, SolveForPointsOf,
                         ::testing::Values("planar2_standard", "puma_simple_h", "puma560", "ur5",
                                           "panda", "stanford"),
                         [](const auto& test) { return test.param; });

TEST(SolveForPoints, FindsTheNearestBranch) {
  const ArmModel arm = OracleArmNamed("puma560");
  std::mt19937 random(9);
  std::uniform_real_distribution<double> step(-0.15, 0.15);
  const JointVector q_goal = (JointVector(6) << 0.3, 0.7, -1.9, 0.4, 0.9, -0.5).finished();
  for (int trial = 0; trial < 50; ++trial) {
    JointVector q_start = q_goal;
    for (int i = 0; i < 6; ++i) q_start(i) += step(random);
    const PointGoalSolution solution =
        SolveForPoints(arm, kTriangle_E, PointsAt(arm, q_goal, kTriangle_E), q_start);
    EXPECT_TRUE(test::Near(solution.q, q_goal, 1e-4)) << trial;
  }
}

// Stretched out, no joint's motion brings the end nearer to first order: a saddle of the distance.
TEST(SolveForPoints, LeavesASingularStart) {
  const ArmModel arm = OracleArmNamed("planar2_standard");
  const PointGoalSolution solution =
      SolveForPoints(arm, {Vector3d::Zero()}, {Vector3d(9.0, 0, 0)}, Eigen::Vector2d::Zero());
  EXPECT_TRUE(solution.converged);
  EXPECT_LT(solution.rms_error, 1e-6);
}

// Only the elbow-down branch lies within the limits; the start is on the side of the other.
TEST(SolveForPoints, FindsTheBranchThatTheLimitsAllow) {
  const ArmModel arm =
      OracleArmNamed("planar2_standard").WithLimits({{-3, 3, 1, 1}, {-0.2, 3, 1, 1}});
  const auto p_WP = PointsAt(arm, Eigen::Vector2d(0.5, 1.2), {Vector3d::Zero()});
  const PointGoalSolution solution =
      SolveForPoints(arm, {Vector3d::Zero()}, p_WP, Eigen::Vector2d(1.5, -0.2));
  EXPECT_TRUE(solution.converged);
  EXPECT_TRUE(test::Near(solution.q, Eigen::Vector2d(0.5, 1.2), 1e-5));
}

// Out of reach by 2.5 m: the end stops at the nearest point, stretched towards it.
TEST(SolveForPoints, SaysWhatIsOutOfReach) {
  const ArmModel arm = OracleArmNamed("planar2_standard");
  const Vector3d goal = 20.0 * Vector3d(std::cos(0.4), std::sin(0.4), 0.0);
  const PointGoalSolution solution =
      SolveForPoints(arm, {Vector3d::Zero()}, {goal}, Eigen::Vector2d(0.0, 0.5));
  EXPECT_FALSE(solution.converged);
  EXPECT_NEAR(solution.rms_error, 2.5, 1e-6);
  EXPECT_NEAR(solution.q(0), 0.4, 1e-4);
}

TEST(SolveForPoints, StopsAtALimitThatIsInTheWay) {
  const ArmModel arm =
      OracleArmNamed("planar2_standard").WithLimits({{-0.3, 0.3, 1, 1}, {-0.1, 0.1, 1, 1}});
  const auto p_WP = PointsAt(arm, Eigen::Vector2d(1.0, 0.0), {Vector3d::Zero()});
  const PointGoalSolution solution =
      SolveForPoints(arm, {Vector3d::Zero()}, p_WP, Eigen::Vector2d::Zero());
  EXPECT_FALSE(solution.converged);
  EXPECT_TRUE(WithinLimits(arm, solution.q));
  EXPECT_TRUE(test::Near(solution.q, Eigen::Vector2d(0.3, 0.1), 1e-9));
}

TEST(SolveForPoints, GivesTheSameAnswerTwice) {
  const ArmModel arm = OracleArmNamed("panda");
  const JointVector q_goal = JointVector::Constant(7, 0.6);
  const auto p_WP = PointsAt(arm, q_goal, kTriangle_E);
  const JointVector q_start = JointVector::Zero(7);
  EXPECT_EQ(SolveForPoints(arm, kTriangle_E, p_WP, q_start).q,
            SolveForPoints(arm, kTriangle_E, p_WP, q_start).q);
}

}  // namespace
}  // namespace vantage
