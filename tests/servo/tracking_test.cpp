// What the model's prediction, the feed-forward and the self-motion are worth: each with and without.

#include <gtest/gtest.h>

#include "servo_cell.h"
#include "vantage/math/angles.h"

namespace vantage {
namespace {

using namespace test;  // NOLINT: the cell
using Eigen::Vector3d;

const JointVector kStart = Joints({-0.3, 0.5, -0.9});
const JointVector kGoal = Joints({0.3, 0.8, -1.3});

// A brisk servo, so that delays matter.
CellOptions Brisk(int latency_images, bool compensated) {
  CellOptions options;
  options.servo.law.gain_at_zero = options.servo.law.gain_at_infinity = 15.0;
  options.latency_images = latency_images;
  options.servo.latency_compensation = compensated;
  return options;
}

struct Settling {
  double time{0.0};       ///< After which the true error stays below a pixel [s].
  double overshoot{0.0};  ///< Largest error after it was below a pixel for the first time [px].
};

Settling Settle(const CellOptions& options) {
  ServoCell cell(PumaView(), kStart, kGoal, options);
  Settling settling;
  bool arrived = false;
  while (cell.time() < 6.0) {
    (void)cell.Tick();
    const double error = cell.TrueError();
    if (error < 1.0) arrived = true;
    if (arrived) settling.overshoot = std::max(settling.overshoot, error);
    if (error >= 1.0) settling.time = cell.time();
  }
  EXPECT_EQ(cell.arm().violations().total(), 0);
  return settling;
}

// One to three images of delay cost next to nothing with the model's help; without it the loop rings, and with
// three images of delay it never settles.
TEST(LatencyCompensation, KeepsTheLoopStable) {
  const Settling without_delay = Settle(Brisk(0, true));
  for (const int images : {1, 2, 3}) {
    const Settling with = Settle(Brisk(images, true));
    const Settling without = Settle(Brisk(images, false));
    RecordProperty("settling_ms_with_" + std::to_string(images), static_cast<int>(1e3 * with.time));
    RecordProperty("settling_ms_without_" + std::to_string(images),
                   static_cast<int>(1e3 * without.time));
    std::printf(
        "%d images of delay: settled after %.2f s with, %.2f s without; then up to %.1f and %.1f "
        "px\n",
        images, with.time, without.time, with.overshoot, without.overshoot);
    EXPECT_LT(with.time, 1.1 * without_delay.time) << images;
    EXPECT_LT(with.overshoot, without_delay.overshoot + 0.5) << images;
    EXPECT_GT(without.time, 1.5 * with.time) << images;
    if (images == 3) {
      EXPECT_GT(without.time, 5.9);
    }
  }
}

// Largest error once the servo has caught up with a goal that swings to and fro.
double TrackingError(double max_speed) {
  CellOptions options;
  options.goal_seen = true;
  options.goal_max_speed = max_speed;
  options.latency_images = 2;
  ServoCell cell(PumaView(), kStart, kGoal, options);
  double worst = 0.0;
  while (cell.time() < 8.0) {
    cell.goal_shift = 0.08 * std::sin(1.0 * cell.time()) * Vector3d(0.6, 0.8, 0.0);
    (void)cell.Tick();
    if (cell.time() > 4.0) worst = std::max(worst, cell.TrueError());
  }
  EXPECT_EQ(cell.arm().violations().total(), 0);
  return worst;
}

TEST(MovingGoal, IsFollowedWithoutLag) {
  const double with = TrackingError(0.15);
  const double without = TrackingError(0.0);
  std::printf(
      "goal at 0.08 m/s: up to %.2f px off with its image velocity fed forward, %.2f px without\n",
      with, without);
  EXPECT_LT(with, 1.5);
  EXPECT_GT(without, 4.0 * with);
}

// Five joints and three features: the arm arrives, and then climbs w_c by motions that the features do not
// see, and keeps away from its limits.
TEST(SelfMotion, ClimbsTheMeasureWhileTheFeaturesStand) {
  const JointVector start = Joints({-0.3, 0.5, -0.9, 0.3, 0.2});
  const JointVector goal = Joints({0.3, 0.8, -1.3, 0.3, 0.2});
  double log_w[2];
  for (const bool ascent : {false, true}) {
    CellOptions options;
    if (!ascent) options.servo.law.ascent_gain = 0.0;
    const ViewModel view = PumaView(5);
    ServoCell cell(view, start, goal, options);
    double worst = 0.0;
    int tick = 0;
    while (cell.time() < 10.0) {
      const ServoOutput& output = cell.Tick();
      if (++tick % 10 == 0) {
        ActiveOutput active;
        active.log_w_gradient = LogCompositeGradient(view, cell.arm().q(), cell.X_WC);
        cell.servo().Accept(active);
      }
      if (cell.time() > 4.0) worst = std::max(worst, output.status.error_px);
      log_w[ascent ? 1 : 0] = output.observability.composite.log_w;
    }
    EXPECT_EQ(cell.arm().violations().total(), 0);
    EXPECT_LT(worst, 1.0);
  }
  std::printf("log w_c %.3f without ascent, %.3f with\n", log_w[0], log_w[1]);
  EXPECT_GT(log_w[1], log_w[0] + 0.1);
}

// The gradient by the model is that of the measure.
TEST(LogCompositeGradient, PointsUpTheMeasure) {
  const ViewModel view = PumaView(5);
  const JointVector q = Joints({0.1, 0.6, -1.0, 0.3, 0.2});
  const Eigen::Isometry3d X_WC = LookFrom({1.2, -1.5, 1.0});
  const JointVector gradient = LogCompositeGradient(view, q, X_WC);
  const auto log_w = [&](const JointVector& at) {
    return MeasureOf(CompositeJacobian(view, SampleArm(view, at), X_WC)).log_w;
  };
  const double step = 1e-3 / gradient.norm();
  const double gain = log_w(q + step * gradient) - log_w(q);
  EXPECT_NEAR(gain, step * gradient.squaredNorm(), 0.02 * step * gradient.squaredNorm());
}

TEST(LogCompositeGradient, MatchesCentralDifferences) {
  const ViewModel view = PumaView(5);
  const JointVector q = Joints({0.1, 0.6, -1.0, 0.3, 0.2});
  const Eigen::Isometry3d X_WC = LookFrom({1.2, -1.5, 1.0});
  const JointVector gradient = LogCompositeGradient(view, q, X_WC);
  constexpr double kStep = 1e-5;
  for (int i = 0; i < q.size(); ++i) {
    const JointVector step = kStep * JointVector::Unit(q.size(), i);
    const auto log_w = [&](const JointVector& at) {
      return MeasureOf(CompositeJacobian(view, SampleArm(view, at), X_WC)).log_w;
    };
    const double expected = (log_w(q + step) - log_w(q - step)) / (2.0 * kStep);
    EXPECT_NEAR(gradient(i), expected, 1e-7 * (1.0 + std::abs(expected)));
  }
  // No direction is up where no marker is seen.
  Eigen::Isometry3d away = X_WC;
  away.linear() *= Eigen::AngleAxisd(kPi, Eigen::Vector3d::UnitX()).matrix();
  EXPECT_FALSE(LogCompositeGradient(view, q, away).allFinite());
}

// From rest the speed comes up without a step, and the sooner the shorter the start.
TEST(SmoothStart, TakesItsTime) {
  double after[2];
  for (const double start_time : {0.0, 1.0}) {
    CellOptions options;
    options.servo.law.start_time = start_time;
    ServoCell cell(PumaView(), kStart, kGoal, options);
    while (cell.time() < 0.07) (void)cell.Tick();
    after[start_time > 0.0 ? 1 : 0] = cell.Tick().command.qdot.norm();
  }
  EXPECT_LT(after[1], 0.6 * after[0]);
  EXPECT_GT(after[1], 0.0);
}

}  // namespace
}  // namespace vantage
