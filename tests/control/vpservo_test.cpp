// The undamped, unlimited law against ViSP's own controller on the same task: vpServo, eye-to-hand.

#include <random>

#include <gtest/gtest.h>
#include <visp3/core/vpVelocityTwistMatrix.h>
#include <visp3/visual_features/vpFeaturePoint.h>
#include <visp3/vs/vpServo.h>

#include "vantage/control/servo_law.h"
#include "vantage/features/feature_set.h"
#include "vantage/robot/kinematics.h"

namespace vantage {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

double Uniform(double lower, double upper, std::mt19937* random) {
  return std::uniform_real_distribution<double>(lower, upper)(*random);
}

Vector3d RandomVector(double size, std::mt19937* random) {
  return {Uniform(-size, size, random), Uniform(-size, size, random), Uniform(-size, size, random)};
}

ArmModel RandomArm(int joints, std::mt19937* random) {
  std::vector<DhRow> rows(static_cast<std::size_t>(joints));
  for (DhRow& row : rows) {
    row = {JointKind::kRevolute,       0.0,
           Uniform(-0.3, 0.3, random), Uniform(-0.4, 0.4, random),
           Uniform(-3.0, 3.0, random), Uniform(-3.0, 3.0, random)};
  }
  return ArmModel("random", DhConvention::kStandard, rows,
                  std::vector<JointLimits>(static_cast<std::size_t>(joints)),
                  Advance(Isometry3d::Identity(), Twist::Constant(Uniform(-1.0, 1.0, random))),
                  Isometry3d::Identity());
}

// A camera some metre from `target`, looking at it from anywhere.
Isometry3d RandomCamera(const Vector3d& target, std::mt19937* random) {
  Isometry3d X_WC = Isometry3d::Identity();
  const Vector3d z = RandomVector(1.0, random).normalized();
  const Vector3d x = z.cross(RandomVector(1.0, random)).normalized();
  X_WC.linear() << x, z.cross(x), z;
  X_WC.translation() = target - Uniform(0.8, 2.0, random) * z;
  return X_WC;
}

// Features in normalised units, as vpFeaturePoint has them.
CameraModel UnitCamera() {
  return InUnits(CameraModel(), ImageUnits::kNormalised);
}

struct Configuration {
  Configuration(int points, int joints, std::mt19937* random)
      : set(FeatureSet::AllPoints(points)), arm(RandomArm(joints, random)) {
    JointVector q(joints);
    for (int i = 0; i < joints; ++i) q(i) = Uniform(-3.0, 3.0, random);
    kinematics = ComputeKinematics(arm, q);
    const Isometry3d& X_WE = kinematics.X_WE;
    X_WC = RandomCamera(X_WE.translation(), random);
    for (int i = 0; i < points; ++i) {
      const Vector3d p = RandomVector(0.15, random);
      current.push_back(ViewOf(X_WC.inverse() * X_WE * p, true));
      wanted.push_back(ViewOf(X_WC.inverse() * (X_WE * p + RandomVector(0.1, random)), false));
    }
  }
  FeatureSet set;
  ArmModel arm;
  Kinematics kinematics;
  Isometry3d X_WC;
  PointViews current, wanted;
};

JointVector OurVelocity(const Configuration& c, InteractionSource source, double gain) {
  FeatureRows rows, goal_rows;
  c.set.Evaluate(UnitCamera(), c.current, &rows, source);
  c.set.EvaluateValues(UnitCamera(), c.wanted, &goal_rows);
  const FeatureJacobian J_v = ImageJacobian(rows.L_body, c.X_WC, c.kinematics.X_WE.translation());
  const TaskJacobian J_c = J_v * c.kinematics.J_WE_W;
  ServoLawOptions options;
  options.gain_at_zero = options.gain_at_infinity = gain;
  options.damping = 0.0;
  options.max_error_rate = 1e9;
  const int n = c.arm.size();
  const ServoLawResult law = ServoLaw(
      options, {FeatureError(c.set, rows, goal_rows), FeatureVector::Zero(rows.size())}, J_c,
      Decompose(J_c), {JointVector::Constant(n, -1e9), JointVector::Constant(n, 1e9)});
  EXPECT_TRUE(law.finite);
  return law.qdot;
}

JointVector VispVelocity(const Configuration& c, double gain) {
  vpServo servo;
  servo.setServo(vpServo::EYETOHAND_L_cVf_fJe);
  servo.setInteractionMatrixType(vpServo::CURRENT, vpServo::PSEUDO_INVERSE);
  servo.setLambda(gain);
  std::vector<vpFeaturePoint> current(c.current.size()), wanted(c.wanted.size());
  for (std::size_t i = 0; i < current.size(); ++i) {
    const ImagePoint& s = c.current[i].image;
    const ImagePoint& g = c.wanted[i].image;
    current[i].buildFrom(s.n.x(), s.n.y(), s.depth);
    wanted[i].buildFrom(g.n.x(), g.n.y(), g.depth);
    servo.addFeature(current[i], wanted[i]);
  }
  // ViSP's f: world axes at the end effector's origin, where the arm's Jacobian is taken.
  Isometry3d X_CF = c.X_WC.inverse();
  X_CF.translation() = c.X_WC.inverse() * c.kinematics.X_WE.translation();
  vpHomogeneousMatrix cMf;
  for (unsigned i = 0; i < 3; ++i) {
    for (unsigned j = 0; j < 4; ++j) cMf[i][j] = X_CF.matrix()(i, j);
  }
  const auto n = static_cast<unsigned>(c.arm.size());
  vpMatrix fJe(6, n);
  for (unsigned i = 0; i < 6; ++i) {
    for (unsigned j = 0; j < n; ++j) fJe[i][j] = c.kinematics.J_WE_W(i, j);
  }
  servo.set_cVf(vpVelocityTwistMatrix(cMf));
  servo.set_fJe(fJe);
  const vpColVector qdot = servo.computeControlLaw();
  servo.kill();
  return Eigen::Map<const Eigen::VectorXd>(qdot.data, n);
}

class VpServo : public ::testing::TestWithParam<InteractionSource> {};

// Tall, square and wide, arms of 2 to 7 joints. ViSP's pseudo-inverse cuts at 1e-6 of the largest
// singular value: configurations near that are another task, and left out.
TEST_P(VpServo, GivesTheSameJointVelocities) {
  std::mt19937 random(11);
  int compared = 0;
  for (const auto& [points, joints] :
       {std::pair{1, 2}, {1, 6}, {2, 4}, {3, 6}, {4, 6}, {4, 7}, {8, 6}, {16, 7}}) {
    for (int i = 0; i < 40; ++i) {
      const Configuration c(points, joints, &random);
      const double gain = Uniform(0.1, 5.0, &random);
      const JointVector ours = OurVelocity(c, GetParam(), gain);
      const JointVector visp = VispVelocity(c, gain);
      FeatureRows rows;
      c.set.Evaluate(UnitCamera(), c.current, &rows, InteractionSource::kClosedForm);
      const FeatureJacobian J_v =
          ImageJacobian(rows.L_body, c.X_WC, c.kinematics.X_WE.translation());
      const TaskJacobian J_c = J_v * c.kinematics.J_WE_W;
      if (MeasureOf(J_c).condition > 1e4) continue;
      ++compared;
      EXPECT_LE((ours - visp).norm(), 1e-9 * (1.0 + visp.norm()))
          << points << " points, " << joints << " joints, configuration " << i;
    }
  }
  EXPECT_GT(compared, 200);
}

INSTANTIATE_TEST_SUITE_P(Both, VpServo,
                         ::testing::Values(InteractionSource::kVisp,
                                           InteractionSource::kClosedForm),
                         [](const auto& test) {
                           return test.param == InteractionSource::kVisp ? "Visp" : "ClosedForm";
                         });

}  // namespace
}  // namespace vantage
