#include "vantage/robot/kinematics.h"

#include <random>
#include <thread>

#include <gtest/gtest.h>

#include "allocation_guard.h"
#include "eigen_matchers.h"
#include "finite_difference.h"
#include "oracle_arm.h"

namespace vantage {
namespace {

using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Vector3d;

double Largest(const Eigen::MatrixXd& matrix) {
  return matrix.cwiseAbs().maxCoeff();
}

TEST(Oracle, PosesAgree) {
  const nlohmann::json oracles = test::ReadOracles();
  ASSERT_FALSE(oracles.at("cases").empty());
  for (const auto& test_case : oracles.at("cases")) {
    SCOPED_TRACE(test_case.at("id").get<std::string>());
    const ArmModel arm = test::OracleArm(test_case.at("robot"));
    const JointVector q = test::OracleJoints(test_case.at("q"));
    const Eigen::MatrixXd expected = test::OracleMatrix(test_case.at("expected").at("T_ee"));
    const double tolerance = 1e-12 * std::max(1.0, Largest(expected));
    EXPECT_TRUE(test::Near(ComputeKinematics(arm, q).X_WE.matrix(), expected, tolerance));
    EXPECT_TRUE(test::Near(EndEffectorPose(arm, q).matrix(), expected, tolerance));
  }
}

TEST(Oracle, JacobiansAgree) {
  const nlohmann::json oracles = test::ReadOracles();
  ASSERT_FALSE(oracles.at("cases").empty());
  for (const auto& test_case : oracles.at("cases")) {
    SCOPED_TRACE(test_case.at("id").get<std::string>());
    const ArmModel arm = test::OracleArm(test_case.at("robot"));
    const JointVector q = test::OracleJoints(test_case.at("q"));
    const Eigen::MatrixXd expected = test::OracleMatrix(test_case.at("expected").at("J_r"));
    EXPECT_TRUE(test::Near(ComputeKinematics(arm, q).J_WE_W, expected, 1e-11 * Largest(expected)));
  }
}

Isometry3d RandomPose(std::mt19937* random) {
  std::normal_distribution<double> normal;
  const auto vector = [&] { return Vector3d(normal(*random), normal(*random), normal(*random)); };
  Isometry3d X = Isometry3d::Identity();
  X.linear() = AngleAxisd(normal(*random), vector().normalized()).toRotationMatrix();
  X.translation() = vector();
  return X;
}

// Seven joints of both kinds with nothing aligned, offset base and tool.
ArmModel RandomDhArm(DhConvention convention, std::mt19937* random) {
  std::uniform_real_distribution<double> value(-1.0, 1.0);
  std::vector<DhRow> rows(7);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    rows[i].kind = i % 3 == 1 ? JointKind::kPrismatic : JointKind::kRevolute;
    rows[i].theta = value(*random);
    rows[i].d = value(*random);
    rows[i].a = value(*random);
    rows[i].alpha = 3.0 * value(*random);
    rows[i].offset = value(*random);
  }
  return ArmModel("random", convention, rows, std::vector<JointLimits>(7), RandomPose(random),
                  RandomPose(random));
}

ArmModel RandomGeneralArm(std::mt19937* random) {
  std::vector<JointTransform> joints(7);
  for (std::size_t i = 0; i < joints.size(); ++i) {
    joints[i].kind = i % 3 == 2 ? JointKind::kPrismatic : JointKind::kRevolute;
    joints[i].X_before = RandomPose(random);
    joints[i].X_after = RandomPose(random);
  }
  return ArmModel("general", joints, std::vector<JointLimits>(7), RandomPose(random),
                  RandomPose(random));
}

JointVector RandomJoints(int n, std::mt19937* random) {
  std::uniform_real_distribution<double> value(-3.0, 3.0);
  JointVector q(n);
  for (int i = 0; i < n; ++i) q(i) = value(*random);
  return q;
}

// The definition, matrix by matrix.
Isometry3d DhTransform(DhConvention convention, const DhRow& row, double q) {
  const double theta = row.kind == JointKind::kRevolute ? q + row.offset : row.theta;
  const double d = row.kind == JointKind::kRevolute ? row.d : q + row.offset;
  Isometry3d X = Isometry3d::Identity();
  if (convention == DhConvention::kStandard) {
    X.rotate(AngleAxisd(theta, Vector3d::UnitZ()));
    X.translate(Vector3d(0, 0, d));
    X.translate(Vector3d(row.a, 0, 0));
    X.rotate(AngleAxisd(row.alpha, Vector3d::UnitX()));
  } else {
    X.rotate(AngleAxisd(row.alpha, Vector3d::UnitX()));
    X.translate(Vector3d(row.a, 0, 0));
    X.rotate(AngleAxisd(theta, Vector3d::UnitZ()));
    X.translate(Vector3d(0, 0, d));
  }
  return X;
}

class DhConventions : public ::testing::TestWithParam<DhConvention> {};

TEST_P(DhConventions, LinkPosesFollowTheDefinition) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> value(-1.0, 1.0);
  std::vector<DhRow> rows(5);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const JointKind kind = i % 2 == 1 ? JointKind::kPrismatic : JointKind::kRevolute;
    rows[i] = {kind, value(random), value(random), value(random), value(random), value(random)};
  }
  const Isometry3d base = RandomPose(&random);
  const Isometry3d tool = RandomPose(&random);
  const ArmModel arm("arm", GetParam(), rows, std::vector<JointLimits>(5), base, tool);
  const JointVector q = RandomJoints(5, &random);
  const LinkPoses poses = ComputeLinkPoses(arm, q);
  Isometry3d expected = base;
  for (int i = 0; i < 5; ++i) {
    expected = expected * DhTransform(GetParam(), rows[i], q(i));
    EXPECT_TRUE(test::Near(poses[i].matrix(), expected.matrix(), 1e-13)) << "link " << i;
  }
  EXPECT_TRUE(test::Near(EndEffectorPose(arm, q).matrix(), (expected * tool).matrix(), 1e-13));
  EXPECT_EQ(poses[5].matrix(), Isometry3d::Identity().matrix());
}

INSTANTIATE_TEST_SUITE_P(Both, DhConventions,
                         ::testing::Values(DhConvention::kStandard, DhConvention::kModified),
                         [](const auto& test) {
                           return test.param == DhConvention::kStandard ? "Standard" : "Modified";
                         });

// A `before` that differs from the identity by less than KDL's tolerance of equality still counts.
TEST(ComputeKinematics, KeepsSmallOffsets) {
  std::vector<JointTransform> joints(1);
  joints[0].X_before.translation().x() = 1e-8;
  const ArmModel arm("arm", joints, std::vector<JointLimits>(1), Isometry3d::Identity(),
                     Isometry3d::Identity());
  EXPECT_EQ(EndEffectorPose(arm, JointVector::Zero(1)).translation().x(), 1e-8);
}

struct RandomArm {
  const char* name;
  ArmModel (*make)(std::mt19937*);
};

class Jacobian : public ::testing::TestWithParam<RandomArm> {};

TEST_P(Jacobian, MatchesCentralDifference) {
  std::mt19937 random(5);
  for (int trial = 0; trial < 20; ++trial) {
    const ArmModel arm = GetParam().make(&random);
    const JointVector q = RandomJoints(arm.size(), &random);
    const Kinematics at_q = ComputeKinematics(arm, q);
    // Velocity of E's origin and rotation vector, both in world axes.
    const auto motion = [&](const Eigen::VectorXd& step) -> Eigen::VectorXd {
      const Isometry3d X_WE = EndEffectorPose(arm, q + step);
      const AngleAxisd turn(Eigen::Matrix3d(X_WE.linear() * at_q.X_WE.linear().transpose()));
      Twist twist;
      twist << X_WE.translation() - at_q.X_WE.translation(), turn.angle() * turn.axis();
      return twist;
    };
    const Eigen::MatrixXd J = test::CentralDifference(motion, 6, arm.size());
    EXPECT_TRUE(test::Near(at_q.J_WE_W, J, 1e-8 * std::max(1.0, Largest(J))));
  }
}

INSTANTIATE_TEST_SUITE_P(Arms, Jacobian,
                         ::testing::Values(RandomArm{"Standard",
                                                     [](std::mt19937* random) {
                                                       return RandomDhArm(DhConvention::kStandard,
                                                                          random);
                                                     }},
                                           RandomArm{"Modified",
                                                     [](std::mt19937* random) {
                                                       return RandomDhArm(DhConvention::kModified,
                                                                          random);
                                                     }},
                                           RandomArm{"General", RandomGeneralArm}),
                         [](const auto& test) { return test.param.name; });

TEST(ComputeKinematics, BaseMovesEverythingAndToolOnlyTheEnd) {
  std::mt19937 random(3);
  const ArmModel arm = RandomDhArm(DhConvention::kStandard, &random);
  const JointVector q = RandomJoints(7, &random);
  const Isometry3d X = RandomPose(&random);
  const Isometry3d moved = EndEffectorPose(arm.WithBase(X), q);
  EXPECT_TRUE(test::Near(moved.matrix(),
                         (X * arm.X_WBase().inverse() * EndEffectorPose(arm, q)).matrix(), 1e-12));
  const ArmModel with_tool = arm.WithTool(X);
  EXPECT_TRUE(test::Near(EndEffectorPose(with_tool, q).matrix(),
                         (ComputeLinkPoses(arm, q)[6] * X).matrix(), 1e-12));
}

TEST(ComputeKinematics, DoesNotAllocate) {
  if (!test::AllocationGuard::kSupported) GTEST_SKIP();
  std::mt19937 random(2);
  const ArmModel arm = RandomDhArm(DhConvention::kModified, &random);
  const JointVector q = RandomJoints(7, &random);
  const test::AllocationGuard guard;
  const Kinematics kinematics = ComputeKinematics(arm, q);
  const Isometry3d X_WE = EndEffectorPose(arm, q);
  const LinkPoses poses = ComputeLinkPoses(arm, q);
  EXPECT_EQ(guard.count(), 0u);
  EXPECT_TRUE(test::Near(kinematics.X_WE.matrix(), X_WE.matrix(), 1e-13));
  EXPECT_TRUE(IsPose(poses[6]));
}

TEST(AllocationGuard, SeesAnAllocation) {
  if (!test::AllocationGuard::kSupported) GTEST_SKIP();
  const test::AllocationGuard guard;
  const Eigen::VectorXd heap = Eigen::VectorXd::Zero(10);
  EXPECT_EQ(guard.count(), 1u);
  EXPECT_EQ(heap.size(), 10);
}

// One model serves the control thread and the planner at once.
TEST(ComputeKinematics, IsSafeFromTwoThreads) {
  std::mt19937 random(17);
  const ArmModel arm = RandomDhArm(DhConvention::kStandard, &random);
  const JointVector q_a = RandomJoints(7, &random);
  const JointVector q_b = RandomJoints(7, &random);
  const Eigen::Matrix4d expected_a = EndEffectorPose(arm, q_a).matrix();
  const Eigen::Matrix4d expected_b = EndEffectorPose(arm, q_b).matrix();
  int wrong_a = 0;
  int wrong_b = 0;
  const auto run = [&arm](const JointVector& q, const Eigen::Matrix4d& expected, int* wrong) {
    for (int i = 0; i < 20000; ++i) {
      if (ComputeKinematics(arm, q).X_WE.matrix() != expected) ++*wrong;
    }
  };
  std::thread other([&] { run(q_b, expected_b, &wrong_b); });
  run(q_a, expected_a, &wrong_a);
  other.join();
  EXPECT_EQ(wrong_a, 0);
  EXPECT_EQ(wrong_b, 0);
}

}  // namespace
}  // namespace vantage
