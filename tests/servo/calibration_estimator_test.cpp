#include "vantage/servo/calibration_estimator.h"

#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "test_arm.h"
#include "vantage/camera/pinhole.h"
#include "vantage/math/spatial.h"
#include "vantage/robot/kinematics.h"

namespace vantage {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kNoise = 0.3;  // [px]

// A cell whose calibration is off as the prior says: what is true, and what is believed of it.
struct Cell {
  explicit Cell(unsigned seed) : random(seed), bias(3) {
    Twist error;
    for (int i = 0; i < 6; ++i)
      error(i) = normal(random) * (i < 3 ? prior.position : prior.rotation);
    X_CTrue = Advance(Isometry3d::Identity(), error);
    focal_factor = 1.0 + prior.focal * normal(random);
    for (int i = 0; i < 3; ++i) bias(i) = prior.joint * normal(random);
  }

  // The pixel of a marker on an arm that is truly at q, by a camera that is truly at X_WC.
  [[nodiscard]] Vector2d See(const Isometry3d& X_WC, const JointVector& q, const Vector3d& p_EP) {
    const CameraModel true_camera = WithFocalFactor(camera, focal_factor);
    const Vector3d p_CM = X_WC.inverse() * (EndEffectorPose(arm, q) * p_EP);
    const Vector2d noise(kNoise * normal(random), kNoise * normal(random));
    return ToPixel(true_camera, Project(p_CM)->n) + noise;
  }

  // Camera and arm in places of their own, and what the image says of one marker.
  bool Look(CalibrationEstimator* estimator) {
    std::uniform_real_distribution<double> share(-1.0, 1.0);
    const double bearing = 1.2 * share(random);
    const Vector3d from =
        Vector3d(0.5, 0.0, 0.5) +
        (1.1 + 0.3 * share(random)) * Vector3d(std::cos(bearing), std::sin(bearing), 0.4);
    const JointVector q =
        test::Joints({0.5 * share(random), 0.4 + 0.4 * share(random), -0.9 + 0.5 * share(random)});
    const Isometry3d X_WC = test::LookFrom(from);
    return estimator->Update(camera, X_WC * X_CTrue.inverse(), arm, q + bias, p_EM,
                             See(X_WC, q, p_EM), kNoise);
  }

  CalibrationPrior prior;
  std::mt19937 random;
  std::normal_distribution<double> normal{0.0, 1.0};
  ArmModel arm{test::PumaArm()};
  CameraModel camera;
  Vector3d p_EM{0.0, 0.0, 0.15};
  Isometry3d X_CTrue{Isometry3d::Identity()};
  double focal_factor{1.0};
  JointVector bias;
};

Twist PoseError(const Cell& cell, const CalibrationEstimator& estimator) {
  return Displacement(estimator.X_CTrue(), cell.X_CTrue);
}

// In a hundred places of arm and camera one marker shows what is wrong with all of the calibration, to a
// tenth of what it was off by.
TEST(CalibrationEstimator, FindsWhatIsWrongAsCameraAndArmMove) {
  double before = 0.0;
  double after = 0.0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Cell cell(seed);
    CalibrationEstimator estimator(cell.prior, 3);
    before += PoseError(cell, estimator).tail<3>().norm();
    for (int i = 0; i < 100; ++i) ASSERT_TRUE(cell.Look(&estimator)) << seed << " " << i;
    after += PoseError(cell, estimator).tail<3>().norm();
    EXPECT_LT(PoseError(cell, estimator).head<3>().norm(), 4e-3) << seed;
    EXPECT_NEAR(estimator.focal_factor(), cell.focal_factor, 2e-3) << seed;
    EXPECT_LT((estimator.joint_bias() - cell.bias).lpNorm<Eigen::Infinity>(), 4e-3) << seed;
  }
  EXPECT_LT(after, 0.1 * before);
}

// The filter knows how sure it is: over cells and coordinates the squared errors are what its variances say.
TEST(CalibrationEstimator, IsAsSureAsItMayBe) {
  for (const int looks : {3, 12, 60}) {
    double sum = 0.0;
    for (unsigned seed = 1; seed <= 50; ++seed) {
      Cell cell(seed);
      CalibrationEstimator estimator(cell.prior, 3);
      for (int i = 0; i < looks; ++i) ASSERT_TRUE(cell.Look(&estimator));
      sum += PoseError(cell, estimator).cwiseQuotient(estimator.pose_sigma()).squaredNorm();
    }
    EXPECT_GT(sum / 300.0, 0.6) << looks;
    EXPECT_LT(sum / 300.0, 1.6) << looks;
  }
}

// A cell at rest shows one place only: the image is explained, the rest stays as the prior has it.
TEST(CalibrationEstimator, OneViewExplainsItsImageAlone) {
  Cell cell(3);
  CalibrationEstimator estimator(cell.prior, 3);
  const Isometry3d X_WC = test::LookFrom({1.6, 0.2, 0.9});
  const JointVector q = test::Joints({0.1, 0.5, -0.8});
  for (int i = 0; i < 200; ++i) {
    ASSERT_TRUE(estimator.Update(cell.camera, X_WC * cell.X_CTrue.inverse(), cell.arm,
                                 q + cell.bias, cell.p_EM, cell.See(X_WC, q, cell.p_EM), kNoise));
  }
  const Isometry3d X_WCFound = X_WC * cell.X_CTrue.inverse() * estimator.X_CTrue();
  const JointVector q_found = q + cell.bias - estimator.joint_bias();
  const Vector2d expected =
      ToPixel(WithFocalFactor(cell.camera, estimator.focal_factor()),
              Project(X_WCFound.inverse() * (EndEffectorPose(cell.arm, q_found) * cell.p_EM))->n);
  const CameraModel true_camera = WithFocalFactor(cell.camera, cell.focal_factor);
  const Vector2d truth =
      ToPixel(true_camera, Project(X_WC.inverse() * (EndEffectorPose(cell.arm, q) * cell.p_EM))->n);
  EXPECT_LT((expected - truth).norm(), 0.15);
  EXPECT_GT(estimator.pose_sigma()(2), 0.9 * cell.prior.position);  // along the optical axis
  EXPECT_LT(PoseError(cell, estimator).norm(), 0.1);
}

TEST(CalibrationEstimator, RefusesWhatCannotBeTheMarker) {
  Cell cell(4);
  CalibrationEstimator estimator(cell.prior, 3);
  const Isometry3d X_WC = test::LookFrom({1.6, 0.2, 0.9});
  const JointVector q = test::Joints({0.1, 0.5, -0.8});
  const auto update = [&](const Vector2d& pixel) {
    return estimator.Update(cell.camera, X_WC, cell.arm, q, cell.p_EM, pixel, kNoise);
  };
  const Vector2d seen = cell.See(X_WC, q, cell.p_EM);
  EXPECT_FALSE(update(seen + Vector2d(200.0, 0.0)));
  EXPECT_FALSE(update({std::numeric_limits<double>::quiet_NaN(), 0.0}));
  EXPECT_EQ(estimator.X_CTrue().matrix(), Isometry3d::Identity().matrix());
  EXPECT_TRUE(update(seen));
}

// Somebody has knocked the camera: measurements that fit nothing any more start it anew.
TEST(CalibrationEstimator, StartsAnewWhenTheCalibrationHasChanged) {
  Cell cell(5);
  CalibrationEstimator estimator(cell.prior, 3);
  for (int i = 0; i < 60; ++i) ASSERT_TRUE(cell.Look(&estimator));
  Twist knock = Twist::Zero();
  knock(4) = 1.5 * cell.prior.rotation;
  knock(5) = -1.5 * cell.prior.rotation;
  cell.X_CTrue = Advance(cell.X_CTrue, knock);
  int refused = 0;
  for (int i = 0; i < 150; ++i) refused += cell.Look(&estimator) ? 0 : 1;
  EXPECT_GT(refused, 20);
  EXPECT_LT(PoseError(cell, estimator).tail<3>().norm(), 0.2 * knock.norm());
}

TEST(CalibrationEstimator, KeepsToItsPrior) {
  Cell cell(6);
  CalibrationPrior off = cell.prior;
  off.estimate = false;
  CalibrationEstimator idle(off, 3);
  EXPECT_FALSE(cell.Look(&idle));
  EXPECT_EQ(idle.X_CTrue().matrix(), Isometry3d::Identity().matrix());

  // What cannot be off is not corrected.
  CalibrationPrior sure = cell.prior;
  sure.joint = 0.0;
  sure.focal = 0.0;
  CalibrationEstimator camera_alone(sure, 3);
  for (int i = 0; i < 5; ++i) cell.Look(&camera_alone);
  EXPECT_EQ(camera_alone.focal_factor(), 1.0);
  EXPECT_TRUE(camera_alone.joint_bias().isZero(0.0));
  EXPECT_FALSE(camera_alone.X_CTrue().matrix().isIdentity(1e-6));
}

}  // namespace
}  // namespace vantage
