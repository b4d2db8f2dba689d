#include "vantage/math/spatial.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "eigen_matchers.h"
#include "vantage/math/angles.h"

namespace vantage {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

Twist RandomStep(std::mt19937* random, double angle_scale) {
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  Twist step;
  for (int i = 0; i < 6; ++i) step(i) = uniform(*random) * (i < 3 ? 1.0 : angle_scale);
  return step;
}

TEST(Spatial, SkewIsTheCrossProduct) {
  const Vector3d a(1, -2, 3);
  const Vector3d b(0.4, 5, -6);
  EXPECT_TRUE(test::Near(Skew(a) * b, a.cross(b), 0.0));
}

// Identity, tiny (the series' branch), and general steps come back.
TEST(Spatial, DisplacementUndoesAdvance) {
  std::mt19937 random(3);
  for (const double scale : {0.0, 1e-12, 1e-6, 1e-3, 1.0, 1.7}) {
    for (int i = 0; i < 50; ++i) {
      const Isometry3d X_WA = Advance(Isometry3d::Identity(), RandomStep(&random, 1.0));
      const Twist step = RandomStep(&random, scale);
      EXPECT_TRUE(test::Near(Displacement(X_WA, Advance(X_WA, step)), step, 1e-11)) << scale;
    }
  }
}

TEST(Spatial, AdvanceHasTheTwistAsItsDerivative) {
  std::mt19937 random(4);
  const Isometry3d X_WA = Advance(Isometry3d::Identity(), RandomStep(&random, 1.0));
  const Twist V = RandomStep(&random, 1.0);
  const double h = 1e-6;
  const Isometry3d ahead = Advance(X_WA, h * V);
  const Isometry3d behind = Advance(X_WA, -h * V);
  const Vector3d v_W = (ahead.translation() - behind.translation()) / (2 * h);
  EXPECT_TRUE(test::Near(v_W, X_WA.linear() * V.head<3>(), 1e-9));
  const Eigen::Matrix3d R_dot = (ahead.linear() - behind.linear()) / (2 * h);
  EXPECT_TRUE(test::Near(X_WA.linear().transpose() * R_dot, Skew(V.tail<3>()), 1e-9));
}

// Two frames on one body: moving the body by one frame's step moves the other by the mapped step.
TEST(Spatial, AdjointMapsTwistsOfOneBody) {
  std::mt19937 random(5);
  const Isometry3d X_WA = Advance(Isometry3d::Identity(), RandomStep(&random, 1.0));
  const Isometry3d X_AB = Advance(Isometry3d::Identity(), RandomStep(&random, 1.0));
  const Twist V_WB_B = RandomStep(&random, 1.0);
  const Isometry3d moved_by_B = Advance(X_WA * X_AB, V_WB_B);
  const Isometry3d moved_by_A = Advance(X_WA, AdjointMap(X_AB) * V_WB_B) * X_AB;
  EXPECT_TRUE(test::Near(moved_by_A.matrix(), moved_by_B.matrix(), 1e-13));
}

// Equal shares of the way are equal steps, and the ends are the poses themselves.
TEST(Spatial, PoseBetweenGoesThereAtAConstantTwist) {
  std::mt19937 random(7);
  for (int i = 0; i < 20; ++i) {
    const Isometry3d X_WA = Advance(Isometry3d::Identity(), RandomStep(&random, 1.0));
    const Isometry3d X_WB = Advance(X_WA, RandomStep(&random, 1.0));
    EXPECT_TRUE(test::Near(PoseBetween(X_WA, X_WB, 0.0).matrix(), X_WA.matrix(), 0.0));
    EXPECT_TRUE(test::Near(PoseBetween(X_WA, X_WB, 1.0).matrix(), X_WB.matrix(), 1e-13));
    const Twist quarter = Displacement(X_WA, PoseBetween(X_WA, X_WB, 0.25));
    const Twist rest = Displacement(PoseBetween(X_WA, X_WB, 0.5), PoseBetween(X_WA, X_WB, 0.75));
    EXPECT_TRUE(test::Near(rest, quarter, 1e-12));
    EXPECT_TRUE(test::Near(4.0 * quarter, Displacement(X_WA, X_WB), 1e-12));
  }
}

TEST(Spatial, AngleBetweenIsThatOfTheTurn) {
  std::mt19937 random(6);
  for (const double angle : {0.0, 1e-6, 0.3, 1.5, 3.0}) {
    const Isometry3d X_WA = Advance(Isometry3d::Identity(), RandomStep(&random, 1.0));
    Twist step = RandomStep(&random, 1.0);
    step.tail<3>() *= angle / step.tail<3>().norm();
    const Isometry3d X_WB = Advance(X_WA, step);
    EXPECT_NEAR(AngleBetween(X_WA.linear(), X_WB.linear()), angle, 1e-14) << angle;
    EXPECT_NEAR(AngleBetween(X_WB.linear(), X_WA.linear()), angle, 1e-14) << angle;
  }
}

// Of two turns in a row about one axis, what is left of a whole turn counts: never more than π.
TEST(Spatial, AngleBetweenGoesTheShortWay) {
  const auto turned = [](double angle) {
    return Eigen::AngleAxisd(angle, Vector3d(1, 2, 2) / 3.0).toRotationMatrix();
  };
  EXPECT_NEAR(AngleBetween(turned(-2.0), turned(2.0)), 2.0 * kPi - 4.0, 1e-14);
}

TEST(Spatial, IsPoseRefusesNaNAndShear) {
  Isometry3d X = Isometry3d::Identity();
  EXPECT_TRUE(IsPose(X));
  X.translation().x() = std::nan("");
  EXPECT_FALSE(IsPose(X));
  X = Isometry3d::Identity();
  X.linear()(0, 1) = 0.1;
  EXPECT_FALSE(IsPose(X));
  X = Isometry3d::Identity();
  X.linear()(2, 2) = -1.0;  // a mirror
  EXPECT_FALSE(IsPose(X));
}

}  // namespace
}  // namespace vantage
