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
  return ServoLaw(options, e, J, Decompose(J), e_rate, bounds);
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
      const VelocityBounds bounds = ComputeVelocityBounds(limits, q, qdot, kPeriod);
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
    const VelocityBounds bounds = ComputeVelocityBounds(limits, q, qdot, kPeriod);
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
