#include "vantage/active/rig_on_arm.h"

#include <random>

#include <gtest/gtest.h>

#include "cells.h"
#include "eigen_matchers.h"
#include "vantage/math/angles.h"
#include "vantage/math/error.h"
#include "vantage/math/spatial.h"

namespace vantage {
namespace {

// A Stanford-like arm: joint 3 slides.
ArmModel WithSlide() {
  const auto row = [](JointKind kind, double theta, double d, double a, double alpha) {
    DhRow r;
    r.kind = kind;
    r.theta = theta;
    r.d = d;
    r.a = a;
    r.alpha = alpha;
    return r;
  };
  constexpr auto kTurns = JointKind::kRevolute;
  return ArmModel("slide", DhConvention::kStandard,
                  {row(kTurns, 0, 0.4, 0, -kPi / 2.0), row(kTurns, 0, 0.15, 0, kPi / 2.0),
                   row(JointKind::kPrismatic, 0.3, 0, 0, 0), row(kTurns, 0, 0, 0, -kPi / 2.0),
                   row(kTurns, 0, 0, 0.05, kPi / 2.0), row(kTurns, 0, 0.1, 0, 0)},
                  test::WideLimits(6), test::Translation(1.0, -0.5, 0.2),
                  test::Translation(0.0, 0.02, 0.1));
}

Eigen::Isometry3d OnFlange() {
  Eigen::Isometry3d X_EC = test::Translation(0.03, -0.02, 0.05);
  X_EC.linear() = Eigen::AngleAxisd(0.4, Eigen::Vector3d(1, 2, -1).normalized()).toRotationMatrix();
  return X_EC;
}

TEST(RigOnArm, HasThePosesOfTheArm) {
  std::mt19937 random(71);
  for (const ArmModel& arm : {test::Puma560().model.arm, test::Puma3Arm(), WithSlide()}) {
    const CameraRig rig = RigOnArm(arm, OnFlange(), 0.5);
    EXPECT_EQ(rig.size(), arm.size());
    for (int trial = 0; trial < 20; ++trial) {
      const RigVector q_c = test::RandomRig(rig, &random);
      const Kinematics kinematics = ComputeKinematics(arm, q_c);
      const Eigen::Isometry3d X_WC = kinematics.X_WE * OnFlange();
      EXPECT_TRUE(test::Near(RigPose(rig, q_c).matrix(), X_WC.matrix(), 1e-12)) << arm.name();
      // V_WC_C from the arm's own Jacobian: E and C are on one body.
      Matrix6d R_EW = Matrix6d::Zero();
      R_EW.topLeftCorner<3, 3>() = R_EW.bottomRightCorner<3, 3>() =
          kinematics.X_WE.linear().transpose();
      const auto reference = (AdjointMap(OnFlange().inverse()) * R_EW * kinematics.J_WE_W).eval();
      EXPECT_TRUE(test::Near(RigJacobian(rig, q_c), reference, 1e-11)) << arm.name();
    }
  }
}

TEST(RigOnArm, TakesTheArmsBounds) {
  ArmModel arm = test::Puma3Arm().WithLimits({{-1, 1, 0.5, 2}, {-2, 0.5, 0.6, 3}, {0, 2, 0.7, 4}});
  const CameraRig rig = RigOnArm(arm, OnFlange(), 0.3);
  EXPECT_EQ(rig.axes[1].lower, -2.0);
  EXPECT_EQ(rig.axes[1].upper, 0.5);
  EXPECT_EQ(rig.axes[1].max_speed, 0.6);
  EXPECT_EQ(rig.axes[1].max_acceleration, 3.0);
  EXPECT_EQ(rig.axes[2].name, arm.joint_names()[2]);
  EXPECT_EQ(rig.max_linear_speed, 0.3);
  EXPECT_THROW((void)RigOnArm(arm, OnFlange(), 0.0), ConfigError);
}

}  // namespace
}  // namespace vantage
