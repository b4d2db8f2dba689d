// The built-in arms: against the oracle's tables, and as bodies.

#include <algorithm>
#include <random>

#include <gtest/gtest.h>

#include "eigen_matchers.h"
#include "oracle_arm.h"
#include "vantage/config/loaders.h"
#include "vantage/math/angles.h"
#include "vantage/robot/kinematics.h"

namespace vantage {
namespace {

using Eigen::Vector3d;

struct Published {
  const char* file;
  const char* oracle;
};

class PublishedArm : public ::testing::TestWithParam<Published> {};

// Pose of the last DH frame and its Jacobian, whatever tool the file mounts.
TEST_P(PublishedArm, AgreesWithTheOracle) {
  const ArmModel arm = FindRobot(GetParam().file);
  const nlohmann::json oracles = test::ReadOracles();
  int cases = 0;
  for (const auto& test_case : oracles.at("cases")) {
    const auto& robot = test_case.at("robot");
    if (robot.at("name") != GetParam().oracle) continue;
    SCOPED_TRACE(test_case.at("id").get<std::string>());
    ++cases;
    const ArmModel same_tool = arm.WithTool(test::OraclePose(robot.at("tool")))
                                   .WithBase(test::OraclePose(robot.at("base")));
    const Kinematics kinematics =
        ComputeKinematics(same_tool, test::OracleJoints(test_case.at("q")));
    const Eigen::MatrixXd X_WE = test::OracleMatrix(test_case.at("expected").at("T_ee"));
    const Eigen::MatrixXd J = test::OracleMatrix(test_case.at("expected").at("J_r"));
    EXPECT_TRUE(test::Near(kinematics.X_WE.matrix(), X_WE, 1e-12));
    EXPECT_TRUE(test::Near(kinematics.J_WE_W, J, 1e-11 * J.cwiseAbs().maxCoeff()));
  }
  EXPECT_GT(cases, 0);
}

INSTANTIATE_TEST_SUITE_P(Files, PublishedArm,
                         ::testing::Values(Published{"puma560", "puma560"},
                                           Published{"stanford", "stanford"},
                                           Published{"ur5", "ur5"}, Published{"panda", "panda"}),
                         [](const auto& test) { return test.param.file; });

// The oracle's small arms are the paper's; the files have other lengths in the same form.
TEST(PlanarArm, FollowsThePaper) {
  const ArmModel arm = FindRobot("planar2");
  const double q1 = 0.4;
  const double q2 = 0.9;
  const Vector3d tip = EndEffectorPose(arm, Eigen::Vector2d(q1, q2)).translation();
  EXPECT_TRUE(test::Near(tip,
                         Vector3d(0.4 * std::cos(q1) + 0.3 * std::cos(q1 + q2),
                                  0.4 * std::sin(q1) + 0.3 * std::sin(q1 + q2), 0.0),
                         1e-15));
}

TEST(PumaType3, FollowsThePaper) {
  const ArmModel arm = FindRobot("puma3");
  const double q1 = 0.4;
  const double q2 = 0.9;
  const double q3 = -0.7;
  const double reach = 0.4318 * (std::cos(q2) + std::cos(q2 + q3));
  const Vector3d tip = EndEffectorPose(arm, Vector3d(q1, q2, q3)).translation();
  EXPECT_TRUE(test::Near(tip,
                         Vector3d(reach * std::cos(q1), reach * std::sin(q1),
                                  0.67 + 0.4318 * (std::sin(q2) + std::sin(q2 + q3))),
                         1e-15));
}

TEST(Puma560, HasThePublishedRangesInItsOwnFrames) {
  const ArmModel arm = FindRobot("puma560");
  EXPECT_NEAR(arm.limits()[1].lower, -45 * kDegree, 1e-12);
  EXPECT_NEAR(arm.limits()[2].upper, 45 * kDegree, 1e-12);
  EXPECT_NEAR(arm.limits()[5].upper, 266 * kDegree, 1e-12);
  EXPECT_EQ(arm.joint_names()[3], "wrist_roll");
}

TEST(Panda, StaysWithinTheMakersLimits) {
  const ArmModel arm = FindRobot("panda");
  const std::array<double, 7> lower{-2.8973, -1.7628, -2.8973, -3.0718, -2.8973, -0.0175, -2.8973};
  const std::array<double, 7> upper{2.8973, 1.7628, 2.8973, -0.0698, 2.8973, 3.7525, 2.8973};
  const std::array<double, 7> speed{2.175, 2.175, 2.175, 2.175, 2.61, 2.61, 2.61};
  const std::array<double, 7> acceleration{15, 7.5, 10, 12.5, 15, 20, 20};
  for (int i = 0; i < 7; ++i) {
    const JointLimits& limit = arm.limits()[i];
    EXPECT_GE(limit.lower, lower[i]);
    EXPECT_LE(limit.upper, upper[i]);
    EXPECT_LE(limit.velocity, speed[i]);
    EXPECT_LE(limit.acceleration, acceleration[i]);
    // Rounded, not guessed.
    EXPECT_LE(limit.lower - lower[i], 5e-4);
    EXPECT_LE(upper[i] - limit.upper, 5e-4);
    EXPECT_GT(limit.velocity, 0.999 * speed[i]);
    EXPECT_GT(limit.acceleration, 0.998 * acceleration[i]);
  }
}

class BuiltInArm : public ::testing::TestWithParam<std::string> {};

TEST_P(BuiltInArm, IsNamedAsItsFile) {
  EXPECT_EQ(FindRobot(GetParam()).name(), GetParam());
}

double Distance(const PlacedCapsule& a, const PlacedCapsule& b) {
  // Bisection on the radius at which a's axis touches a capsule round b's.
  double low = 0.0;
  double high = 10.0;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    PlacedCapsule grown = b;
    grown.radius = middle;
    (SegmentHitsCapsule(a.p_WA, a.p_WB, grown) ? high : low) = middle;
  }
  return low - a.radius - b.radius;
}

// Each body from the base to the last joint hangs together with the one before it in every
// configuration: no capsule was written in a wrong frame.
TEST_P(BuiltInArm, HangsTogether) {
  const ArmModel arm = FindRobot(GetParam());
  ASSERT_FALSE(arm.capsules().empty());
  std::mt19937 random(4);
  std::vector<PlacedCapsule> capsules;
  for (int trial = 0; trial < 50; ++trial) {
    JointVector q(arm.size());
    for (int i = 0; i < arm.size(); ++i) {
      q(i) = std::uniform_real_distribution<double>(arm.limits()[i].lower,
                                                    arm.limits()[i].upper)(random);
    }
    PlaceCapsules(arm, q, &capsules);
    EXPECT_EQ(capsules.front().link, -1);
    for (std::size_t i = 1; i < capsules.size(); ++i) {
      double nearest = 1.0;
      for (std::size_t j = 0; j < i; ++j) {
        nearest = std::min(nearest, Distance(capsules[i], capsules[j]));
      }
      EXPECT_LT(nearest, 0.0) << "capsule " << i << " at " << q.transpose();
    }
    // The last body carries the end effector.
    const Vector3d p_WE = EndEffectorPose(arm, q).translation();
    const PlacedCapsule at_tool{p_WE, p_WE, 0.001, 0};
    EXPECT_LT(Distance(at_tool, capsules.back()), 0.05);
  }
}

INSTANTIATE_TEST_SUITE_P(All, BuiltInArm, ::testing::ValuesIn(BuiltInConfigs(ConfigKind::kRobot)),
                         [](const auto& test) { return test.param; });

}  // namespace
}  // namespace vantage
