#include "vantage/control/servo_law.h"

#include <limits>
#include <random>

#include <gtest/gtest.h>
#include <visp3/core/vpMatrix.h>

#include "allocation_guard.h"
#include "eigen_matchers.h"

namespace vantage {
namespace {

constexpr double kPeriod = 0.002;

std::vector<JointLimits> Limits(int n, double velocity = 1.5, double acceleration = 6.0) {
  JointLimits limit;
  limit.lower = -2.0;
  limit.upper = 2.0;
  limit.velocity = velocity;
  limit.acceleration = acceleration;
  return std::vector<JointLimits>(static_cast<std::size_t>(n), limit);
}

VelocityBounds Wide(int n) {
  return {JointVector::Constant(n, -1e6), JointVector::Constant(n, 1e6)};
}

// J_c = J_v J_r: of rank 6 at most, as that of every arm.
TaskJacobian RandomJacobian(int k, int n, std::mt19937* random) {
  std::normal_distribution<double> normal(0.0, 1.0);
  FeatureJacobian J_v(k, 6);
  ArmJacobian J_r(6, n);
  for (int i = 0; i < J_v.size(); ++i) J_v.data()[i] = 300.0 * normal(*random);
  for (int i = 0; i < J_r.size(); ++i) J_r.data()[i] = normal(*random);
  return J_v * J_r;
}

FeatureVector RandomError(int k, std::mt19937* random) {
  std::normal_distribution<double> normal(0.0, 40.0);
  FeatureVector e(k);
  for (int i = 0; i < k; ++i) e(i) = normal(*random);
  return e;
}

ServoLawResult Law(const ServoLawOptions& options, const FeatureVector& e, const TaskJacobian& J,
                   const FeatureVector& e_rate, const VelocityBounds& bounds) {
  return ServoLaw(options, ServoDemand{e, e_rate}, J, Decompose(J), bounds);
}

ServoLawOptions Undamped() {
  ServoLawOptions options;
  options.damping = 0.0;
  options.max_error_rate = 1e9;
  return options;
}

// The law without limits is -λ J⁺ e: ViSP's pseudo-inverse as the oracle, tall, square and wide.
TEST(ServoLaw, UnlimitedIsThePseudoInverse) {
  std::mt19937 random(1);
  for (const auto& [k, n] : {std::pair{8, 6}, {6, 6}, {2, 2}, {3, 6}, {8, 7}, {4, 7}}) {
    for (int i = 0; i < 50; ++i) {
      const TaskJacobian J = RandomJacobian(k, n, &random);
      const FeatureVector e = RandomError(k, &random);
      const ServoLawOptions options = Undamped();
      const ServoLawResult result = Law(options, e, J, FeatureVector::Zero(k), Wide(n));
      ASSERT_TRUE(result.finite);
      vpMatrix J_visp(k, n);
      for (int r = 0; r < k; ++r) {
        for (int c = 0; c < n; ++c) J_visp[r][c] = J(r, c);
      }
      const vpMatrix inverse = J_visp.pseudoInverse(1e-12);
      for (int c = 0; c < n; ++c) {
        double expected = 0.0;
        for (int r = 0; r < k; ++r) expected -= result.lambda * inverse[c][r] * e(r);
        EXPECT_NEAR(result.qdot(c), expected, 1e-9 * (1.0 + result.qdot.norm()));
      }
    }
  }
}

TEST(ServoLaw, CancelsTheErrorRateTheJointsDoNotCause) {
  std::mt19937 random(2);
  const TaskJacobian J = RandomJacobian(6, 6, &random);
  const FeatureVector rate = RandomError(6, &random);
  const ServoLawResult result = Law(Undamped(), FeatureVector::Zero(6), J, rate, Wide(6));
  EXPECT_TRUE(test::Near(J * result.qdot, -rate, 1e-8));
}

TEST(ServoLaw, BoundsHoldExactlyAndTheRestDoesItsBest) {
  std::mt19937 random(3);
  int bound = 0;
  for (int i = 0; i < 200; ++i) {
    const TaskJacobian J = RandomJacobian(8, 6, &random);
    const FeatureVector e = RandomError(8, &random);
    const VelocityBounds bounds{JointVector::Constant(6, -0.05), JointVector::Constant(6, 0.05)};
    const ServoLawResult result = Law(Undamped(), e, J, FeatureVector::Zero(8), bounds);
    ASSERT_TRUE(result.finite);
    EXPECT_LE(result.qdot.maxCoeff(), 0.05);
    EXPECT_GE(result.qdot.minCoeff(), -0.05);
    bound += result.bounds_active > 0 ? 1 : 0;
    // No worse than the plain solution clipped afterwards.
    const ServoLawResult free = Law(Undamped(), e, J, FeatureVector::Zero(8), Wide(6));
    const JointVector clipped = free.qdot.cwiseMax(bounds.lower).cwiseMin(bounds.upper);
    const FeatureVector target = -free.lambda * e;
    EXPECT_LE((J * result.qdot - target).norm(), (J * clipped - target).norm() * (1 + 1e-9));
  }
  EXPECT_GT(bound, 100);
}

TEST(ServoLaw, DampingStaysFiniteAtASingularity) {
  TaskJacobian J(2, 2);
  J << 300.0, 300.0, 1e-9, -1e-9;
  const FeatureVector e = FeatureVector::Constant(2, 50.0);
  const ServoLawResult damped = Law(ServoLawOptions(), e, J, FeatureVector::Zero(2), Wide(2));
  ASSERT_TRUE(damped.finite);
  EXPECT_NEAR(damped.damping, ServoLawOptions().damping, 1e-6);
  EXPECT_LT(damped.qdot.norm(), 1.0);
}

TEST(ServoLaw, RefusesNaNOneByOne) {
  const TaskJacobian J = TaskJacobian::Identity(2, 2);
  const FeatureVector good = FeatureVector::Ones(2);
  FeatureVector bad = good;
  bad(1) = std::numeric_limits<double>::quiet_NaN();
  TaskJacobian bad_J = J;
  bad_J(0, 1) = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(Law({}, good, J, good, Wide(2)).finite);
  EXPECT_FALSE(Law({}, bad, J, good, Wide(2)).finite);
  EXPECT_FALSE(Law({}, good, bad_J, good, Wide(2)).finite);
  EXPECT_FALSE(Law({}, good, J, bad, Wide(2)).finite);
  EXPECT_TRUE(Law({}, bad, J, good, Wide(2)).qdot.isZero(0.0));
}

TEST(ServoLaw, DoesNotAllocate) {
  if (!test::AllocationGuard::kSupported) GTEST_SKIP();
  std::mt19937 random(4);
  const TaskJacobian J = RandomJacobian(8, 6, &random);
  const FeatureVector e = RandomError(8, &random);
  const FeatureVector rate = FeatureVector::Zero(8);
  const VelocityBounds bounds{JointVector::Constant(6, -0.05), JointVector::Constant(6, 0.05)};
  const test::AllocationGuard guard;
  const ServoLawResult result = Law({}, e, J, rate, bounds);
  EXPECT_EQ(guard.count(), 0u);
  EXPECT_TRUE(result.finite);
}

// Well seen directions keep their exact inverse however badly another is seen.
TEST(ServoLaw, DampsOnlyWhatIsSeenBadly) {
  TaskJacobian J(3, 3);
  J << 300.0, 0.0, 0.0, 0.0, 100.0, 0.0, 0.0, 0.0, 1.0;
  const FeatureVector e = FeatureVector::Constant(3, 30.0);
  ServoLawOptions options;
  options.max_error_rate = 1e9;
  const ServoLawResult result = Law(options, e, J, FeatureVector::Zero(3), Wide(3));
  EXPECT_NEAR(result.qdot(0), -result.lambda * 30.0 / 300.0, 1e-12);
  EXPECT_NEAR(result.qdot(1), -result.lambda * 30.0 / 100.0, 1e-12);
  const double ratio = 1.0 / options.damping_onset;
  const double mu2 = options.damping * options.damping * (1.0 - ratio * ratio);
  EXPECT_NEAR(result.qdot(2), -result.lambda * 30.0 / (1.0 + mu2), 1e-9);
  EXPECT_NEAR(result.damping, std::sqrt(mu2), 1e-12);
}

// While no bound is active the image error goes straight to zero: its direction is kept.
TEST(ServoLaw, KeepsTheDirectionInTheImageWhereNoLimitBinds) {
  std::mt19937 random(12);
  for (int i = 0; i < 100; ++i) {
    const TaskJacobian J = RandomJacobian(6, 6, &random);
    const FeatureVector e = RandomError(6, &random);
    const ServoLawResult result = Law(Undamped(), e, J, FeatureVector::Zero(6), Wide(6));
    EXPECT_TRUE(test::Near(J * result.qdot, -result.lambda * e, 1e-6 * e.norm()));
  }
}

// What the features leave free follows the self-motion, and the features do not notice.
TEST(ServoLaw, SelfMotionStaysWhereTheFeaturesDoNotSeeIt) {
  std::mt19937 random(13);
  std::normal_distribution<double> normal(0.0, 0.1);
  for (const auto& [k, n] : {std::pair{8, 7}, {3, 6}, {2, 7}}) {
    for (int i = 0; i < 50; ++i) {
      const TaskJacobian J = RandomJacobian(k, n, &random);
      ServoDemand demand{RandomError(k, &random), FeatureVector::Zero(k)};
      const SingularSystem system = Decompose(J);
      const ServoLawResult still = ServoLaw(Undamped(), demand, J, system, Wide(n));
      demand.self_motion = JointVector(n);
      for (int j = 0; j < n; ++j) demand.self_motion(j) = normal(random);
      const ServoLawResult moved = ServoLaw(Undamped(), demand, J, system, Wide(n));
      const JointVector difference = moved.qdot - still.qdot;
      EXPECT_TRUE(test::Near(J * difference, FeatureVector::Zero(k), 1e-7));
      // It is the projection of what was wanted.
      EXPECT_NEAR(difference.dot(demand.self_motion), difference.squaredNorm(), 1e-9);
      EXPECT_GT(difference.norm(), 0.0);
      // With bounds of no effect the solver for the box agrees, to its trace of damping.
      VelocityBounds bounds = Wide(n);
      bounds.upper(0) = moved.qdot(0) + 1e-9;
      bounds.lower(0) = moved.qdot(0) + 0.5e-9;
      const ServoLawResult bounded = ServoLaw(Undamped(), demand, J, system, bounds);
      EXPECT_TRUE(test::Near(bounded.qdot, moved.qdot, 1e-3 * (1.0 + moved.qdot.norm())));
    }
  }
}

TEST(ServoLaw, EffortScalesTheGainAlone) {
  std::mt19937 random(14);
  const TaskJacobian J = RandomJacobian(6, 6, &random);
  const FeatureVector e = RandomError(6, &random);
  const FeatureVector rate = RandomError(6, &random);
  const auto at = [&](double effort) {
    return ServoLaw(Undamped(), {e, rate, effort}, J, Decompose(J), Wide(6)).qdot;
  };
  EXPECT_TRUE(test::Near(J * at(0.0), -rate, 1e-7));
  EXPECT_TRUE(test::Near(at(0.5), JointVector(0.5 * (at(0.0) + at(1.0))), 1e-9));
}

TEST(LimitAvoidance, LeavesTheMiddleAloneAndPushesFromBothEnds) {
  const auto limits = Limits(5);
  JointVector q(5);
  q << -2.0, -1.3, 0.0, 1.7, 2.0;
  const JointVector velocity = LimitAvoidance(limits, q, 0.2);
  EXPECT_NEAR(velocity(0), 0.2 * 1.5, 1e-12);
  EXPECT_EQ(velocity(1), 0.0);
  EXPECT_EQ(velocity(2), 0.0);
  EXPECT_NEAR(velocity(3), -0.2 * 1.5 * 0.5, 1e-12);
  EXPECT_NEAR(velocity(4), -0.2 * 1.5, 1e-12);
}

TEST(CompositeAscent, GoesUpTheGradientWithinItsShare) {
  const auto limits = Limits(2);
  ServoLawOptions options;
  options.ascent_gain = 0.1;
  JointVector gradient(2);
  gradient << 1.0, -2.0;
  EXPECT_TRUE(test::Near(CompositeAscent(options, limits, gradient), 0.1 * gradient, 1e-15));
  const JointVector steep = CompositeAscent(options, limits, 100.0 * gradient);
  EXPECT_NEAR(steep(1), -options.self_motion * 1.5, 1e-12);
  EXPECT_NEAR(steep(0), 0.5 * options.self_motion * 1.5, 1e-12);
  gradient(0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(CompositeAscent(options, limits, gradient).isZero(0.0));
  EXPECT_TRUE(CompositeAscent(options, limits, JointVector()).isZero(0.0));
}

// Random demands over long runs of an arm that lags behind its commands: no command and no joint ever
// leaves its limits, though all of them are reached.
TEST(VelocityBounds, HoldForALaggingArmThatIsAskedForAnything) {
  std::mt19937 random(15);
  std::normal_distribution<double> normal(0.0, 3.0);
  std::uniform_real_distribution<double> late(0.2, 1.0);
  const auto limits = Limits(3, 1.5, 6.0);
  constexpr double kLag = 0.03;
  JointVector q = JointVector::Zero(3), told = q, qdot = q, moving = q, wish = q;
  double reached = 0.0, fastest = 0.0;
  for (int i = 0; i < 200000; ++i) {
    if (i % 700 == 0) wish = wish.unaryExpr([&](double) { return normal(random); });
    // A period after a late one is short.
    const double dt = i % 50 == 0 ? late(random) * kPeriod : kPeriod;
    const VelocityBounds bounds =
        ComputeVelocityBounds(limits, q.cwiseMin(told), q.cwiseMax(told), qdot, dt);
    const JointVector next = wish.cwiseMax(bounds.lower).cwiseMin(bounds.upper);
    ASSERT_LE((next - qdot).lpNorm<Eigen::Infinity>(), 6.0 * dt + 1e-12);
    ASSERT_LE(next.lpNorm<Eigen::Infinity>(), 1.5 + 1e-12);
    qdot = next;
    told += dt * qdot;
    // The lag's exact solution over the period.
    const double caught_up = 1.0 - std::exp(-dt / kLag);
    q += dt * qdot + kLag * caught_up * (moving - qdot);
    moving += caught_up * (qdot - moving);
    ASSERT_LE(q.lpNorm<Eigen::Infinity>(), 2.0 + 1e-9);
    reached = std::max(reached, q.lpNorm<Eigen::Infinity>());
    fastest = std::max(fastest, moving.lpNorm<Eigen::Infinity>());
  }
  EXPECT_GT(reached, 1.98);
  EXPECT_GT(fastest, 1.49);
}

// Whatever is asked for within the bounds, period after period, no limit is ever passed.
TEST(VelocityBounds, RandomMotionNeverLeavesTheLimits) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  for (const double acceleration : {0.5, 6.0, 200.0}) {
    const auto limits = Limits(1, 1.5, acceleration);
    JointVector q = JointVector::Zero(1);
    JointVector qdot = JointVector::Zero(1);
    double wish = 1.0;
    double reached = 0.0;
    for (int i = 0; i < 60000; ++i) {
      if (i % 3000 == 0) wish = uniform(random) < 0.5 ? -1.0 : 1.0;
      const VelocityBounds bounds = ComputeVelocityBounds(limits, q, q, qdot, kPeriod);
      ASSERT_LE(bounds.lower(0), bounds.upper(0));
      const double next = wish > 0 ? bounds.upper(0) : bounds.lower(0);
      ASSERT_LE(std::abs(next), 1.5 + 1e-12);
      ASSERT_LE(std::abs(next - qdot(0)), acceleration * kPeriod + 1e-12);
      qdot(0) = next;
      q += kPeriod * qdot;
      ASSERT_LE(std::abs(q(0)), 2.0 + 1e-9);
      reached = std::max(reached, std::abs(q(0)));
    }
    EXPECT_GT(reached, 1.9);  // the limits are used, not merely kept
  }
}

TEST(VelocityBounds, OutsideTheRangeAJointMayOnlyComeBack) {
  const auto limits = Limits(1);
  const JointVector q = JointVector::Constant(1, 2.1);
  JointVector qdot = JointVector::Zero(1);
  for (int i = 0; i < 2000; ++i) {
    const VelocityBounds bounds = ComputeVelocityBounds(limits, q, q, qdot, kPeriod);
    EXPECT_LE(bounds.upper(0), 1e-12);
    qdot = bounds.upper;
  }
  EXPECT_LT(qdot(0), -0.5);
}

TEST(RampToRest, EndsAtZeroWithinTheAccelerationLimit) {
  const auto limits = Limits(2);
  JointVector qdot(2);
  qdot << 1.0, -0.004;
  JointVector next = RampToRest(limits, qdot, kPeriod);
  EXPECT_NEAR(next(0), 1.0 - 0.012, 1e-15);
  EXPECT_EQ(next(1), 0.0);
  for (int i = 0; i < 100; ++i) next = RampToRest(limits, next, kPeriod);
  EXPECT_TRUE(next.isZero(0.0));
}

TEST(AdaptiveGain, FallsFromZeroToInfinity) {
  ServoLawOptions options;
  EXPECT_NEAR(AdaptiveGain(options, 0.0), options.gain_at_zero, 1e-12);
  EXPECT_NEAR(AdaptiveGain(options, 1e9), options.gain_at_infinity, 1e-12);
  const double slope = (AdaptiveGain(options, 1e-4) - options.gain_at_zero) / 1e-4;
  EXPECT_NEAR(slope, -options.gain_slope, 1e-5);
}

}  // namespace
}  // namespace vantage
