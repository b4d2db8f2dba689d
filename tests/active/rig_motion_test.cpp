#include "vantage/active/rig_motion.h"

#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "allocation_guard.h"
#include "cells.h"
#include "eigen_matchers.h"
#include "finite_difference.h"

namespace vantage {
namespace {

RigPath RandomPath(const CameraRig& rig, bool straight, std::mt19937* random) {
  const RigVector start = test::RandomRig(rig, random);
  const RigVector end = test::RandomRig(rig, random);
  return straight ? RigPath::Straight(start, end)
                  : RigPath::Parabola(start, test::RandomRig(rig, random), end);
}

// Every bound, exactly, over the coordinates after each of even steps.
void ExpectWithinBounds(const CameraRig& rig, const std::vector<RigVector>& record, double dt) {
  const double room = 1.0 + 1e-9;
  for (std::size_t i = 0; i < record.size(); ++i) {
    const RigVector& q_c = record[i];
    for (int a = 0; a < rig.size(); ++a) {
      ASSERT_GE(q_c(a), rig.axes[a].lower - 1e-12);
      ASSERT_LE(q_c(a), rig.axes[a].upper + 1e-12);
    }
    if (i == 0) continue;
    const RigVector step = q_c - record[i - 1];
    for (int a = 0; a < rig.size(); ++a) {
      ASSERT_LE(std::abs(step(a)), rig.axes[a].max_speed * dt * room) << "step " << i;
    }
    const double moved =
        (RigPose(rig, q_c).translation() - RigPose(rig, record[i - 1]).translation()).norm();
    ASSERT_LE(moved, rig.max_linear_speed * dt * room) << "step " << i;
    if (i == 1) continue;
    const RigVector change = step - (record[i - 1] - record[i - 2]);
    for (int a = 0; a < rig.size(); ++a) {
      // Positions are rounded at 1e-16, their second differences at 4e-16 / dt².
      ASSERT_LE(std::abs(change(a)), rig.axes[a].max_acceleration * dt * dt * room + 1e-14)
          << "step " << i << " axis " << a;
    }
  }
}

TEST(RigPath, SlopeAndBendMatchCentralDifference) {
  std::mt19937 random(41);
  const CameraRig rig = test::Sphere({0, 0, 0});
  const RigPath path = RandomPath(rig, false, &random);
  const auto slope = test::CentralDifference(
      [&](const Eigen::VectorXd& ds) -> Eigen::VectorXd { return path.At(0.3 + ds(0)); }, 4, 1);
  EXPECT_TRUE(test::Near(path.Slope(0.3), slope, 1e-9));
  const auto bend = test::CentralDifference(
      [&](const Eigen::VectorXd& ds) -> Eigen::VectorXd { return path.Slope(0.3 + ds(0)); }, 4, 1);
  EXPECT_TRUE(test::Near(path.Bend(0.3), bend, 1e-9));
  EXPECT_TRUE(test::Near(path.At(0.0), path.start(), 1e-15));
  EXPECT_TRUE(test::Near(path.At(1.0), path.end(), 1e-15));
}

TEST(RigPath, ParabolaIsExact) {
  std::mt19937 random(47);
  const CameraRig rig = test::Sphere({0, 0, 0});
  const RigVector start = test::RandomRig(rig, &random), control = test::RandomRig(rig, &random),
                  end = test::RandomRig(rig, &random);
  const RigPath path = RigPath::Parabola(start, control, end);
  for (double s = 0.0; s <= 1.0; s += 0.01) {
    const RigVector expected = (1 - s) * (1 - s) * start + 2 * s * (1 - s) * control + s * s * end;
    EXPECT_TRUE(test::Near(path.At(s), expected, 1e-13));
    EXPECT_TRUE(test::Near(path.Bend(s), 2.0 * (start - 2.0 * control + end), 1e-11));
  }
}

TEST(RigPath, StraightHasConstantSlope) {
  std::mt19937 random(48);
  const CameraRig rig = test::Sphere({0, 0, 0});
  const RigPath path = RandomPath(rig, true, &random);
  for (double s = 0.0; s <= 1.0; s += 0.05) {
    EXPECT_TRUE(test::Near(path.Slope(s), path.end() - path.start(), 1e-12));
  }
}

// Any control points: smooth across the spans, bounded as it says, inside the box of its points.
TEST(RigPath, IsSmoothAndBounded) {
  std::mt19937 random(49);
  const CameraRig rig = test::Sphere({0, 0, 0});
  RigPath path = RandomPath(rig, true, &random);
  for (int i = 0; i < RigPath::kPoints; ++i) path.point(i) = test::RandomRig(rig, &random);
  const RigVector bound = path.SlopeBound();
  double length = 0.0;
  for (int i = 0; i < 1000; ++i) {
    const double s = i / 1000.0, h = 1e-3;
    const RigVector q_c = path.At(s);
    EXPECT_TRUE(test::Near(q_c, ClampToLimits(rig, q_c), 1e-12));
    EXPECT_LE((path.Slope(s).cwiseAbs() - bound).maxCoeff(), 1e-12);
    const RigVector slope = (path.At(s + h) - q_c) / h;
    EXPECT_TRUE(test::Near(0.5 * (path.Slope(s) + path.Slope(s + h)), slope, 0.05));
    const RigVector bend = (path.Slope(s + h) - path.Slope(s)) / h;
    EXPECT_TRUE(test::Near(0.5 * (path.Bend(s) + path.Bend(s + h)), bend, 1.0));
    length += (path.At(s + h) - q_c).norm();
  }
  EXPECT_GE(path.Length(), length);
}

TEST(RigPath, StartingAtMovesTheStartAlone) {
  std::mt19937 random(50);
  const CameraRig rig = test::Sphere({0, 0, 0});
  const RigPath path = RandomPath(rig, false, &random);
  const RigVector start = path.start() + 0.01 * RigVector::Ones(4);
  const RigPath moved = path.StartingAt(start);
  EXPECT_TRUE(test::Near(moved.start(), start, 0.0));
  EXPECT_TRUE(test::Near(moved.end(), path.end(), 1e-15));
  for (double s = 0.0; s <= 1.0; s += 0.1) {
    EXPECT_TRUE(test::Near(moved.At(s), path.At(s), 0.0101));
  }
}

class RigMotionSteps : public ::testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(Rates, RigMotionSteps, ::testing::Values(0.002, 0.01, 1.0 / 60.0, 0.05));

TEST_P(RigMotionSteps, KeepEveryBoundAndArrive) {
  const double dt = GetParam();
  const CameraRig rig = test::Sphere({0, 0, 0});
  std::mt19937 random(42);
  for (int trial = 0; trial < 60; ++trial) {
    RigMotion motion(rig, RandomPath(rig, trial % 2 == 0, &random));
    const double expected = motion.duration();
    std::vector<RigVector> record{motion.q_c(), motion.q_c()};
    int steps = 0;
    while (!motion.Done() && ++steps < 100000) {
      motion.Step(dt, false);
      record.push_back(motion.q_c());
    }
    record.push_back(motion.q_c());
    ASSERT_TRUE(motion.Done());
    EXPECT_TRUE(test::Near(motion.q_c(), motion.path().end(), 1e-5));
    ExpectWithinBounds(rig, record, dt);
    // Not needlessly slow, and about as long as it said.
    EXPECT_LT(steps * dt, 1.15 * expected + 6.0 * dt);
    EXPECT_GT(steps * dt, 0.9 * expected);
  }
}

TEST_P(RigMotionSteps, KeepEveryBoundWhileBrakingAndGoingOn) {
  const double dt = GetParam();
  const CameraRig rig = test::Sphere({0, 0, 0});
  std::mt19937 random(43);
  for (int trial = 0; trial < 60; ++trial) {
    RigMotion motion(rig, RandomPath(rig, trial % 2 == 0, &random));
    std::vector<RigVector> record{motion.q_c(), motion.q_c()};
    bool brake = false;
    int steps = 0;
    while (!motion.Done() && ++steps < 100000) {
      if (std::uniform_int_distribution<int>(0, 15)(random) == 0) brake = !brake && steps < 2000;
      motion.Step(dt, brake);
      record.push_back(motion.q_c());
    }
    ASSERT_TRUE(motion.Done());
    ExpectWithinBounds(rig, record, dt);
  }
}

TEST(RigMotion, BrakesToRestWhereItSaid) {
  const CameraRig rig = test::Sphere({0, 0, 0});
  std::mt19937 random(44);
  RigMotion motion(rig, RandomPath(rig, false, &random));
  while (motion.s() < 0.4) motion.Step(0.01, false);
  ASSERT_FALSE(motion.AtRest());
  const RigVector expected = motion.StopCoordinates();
  const double s = motion.s();
  while (!motion.AtRest()) motion.Step(0.01, true);
  EXPECT_TRUE(test::Near(motion.q_c(), expected, 1e-9));
  EXPECT_GT(motion.s(), s);
  EXPECT_LT(motion.s(), 1.0);
}

TEST(RigMotion, VelocityIsThatOfTheCoordinates) {
  const CameraRig rig = test::Sphere({0, 0, 0});
  std::mt19937 random(45);
  RigMotion motion(rig, RandomPath(rig, false, &random));
  while (motion.s() < 0.3) motion.Step(0.01, false);
  RigMotion ahead = motion;
  ahead.Step(1e-6, false);
  EXPECT_TRUE(test::Near(motion.qdot_c(), (ahead.q_c() - motion.q_c()) / 1e-6, 1e-5));
}

TEST(RigMotion, LinearSpeedBoundIsReached) {
  CameraRig rig = test::Sphere({0, 0, 0});
  for (RigAxis& axis : rig.axes) axis.max_speed = 10.0;
  RigMotion motion(rig, RigPath::Straight(Eigen::Vector4d(2.0, 1.2, 0.0, 0.0),
                                          Eigen::Vector4d(2.0, 1.2, 2.0, 0.0)));
  double fastest = 0.0;
  while (!motion.Done()) {
    motion.Step(0.01, false);
    fastest =
        std::max(fastest, (RigJacobian(rig, motion.q_c()) * motion.qdot_c()).head<3>().norm());
  }
  EXPECT_LE(fastest, rig.max_linear_speed);
  EXPECT_GT(fastest, 0.95 * rig.max_linear_speed);
}

TEST(RigMotion, OfNoLengthIsDone) {
  const CameraRig rig = test::Sphere({0, 0, 0});
  const RigVector q_c = Eigen::Vector4d(1.0, 0.5, 0.2, 0.1);
  RigMotion motion(rig, RigPath::Straight(q_c, q_c));
  EXPECT_TRUE(motion.Done());
  motion.Step(0.1, false);
  EXPECT_TRUE(test::Near(motion.q_c(), q_c, 1e-15));
  EXPECT_TRUE(RigMotion(q_c).Done());
}

TEST(RigMotion, StepDoesNotAllocate) {
  if (!test::AllocationGuard::kSupported) GTEST_SKIP();
  const CameraRig rig = test::Sphere({0, 0, 0});
  std::mt19937 random(46);
  RigMotion motion(rig, RandomPath(rig, false, &random));
  const test::AllocationGuard guard;
  for (int i = 0; i < 20; ++i) motion.Step(0.01, i % 3 == 0);
  EXPECT_EQ(guard.count(), 0u);
}

}  // namespace
}  // namespace vantage
