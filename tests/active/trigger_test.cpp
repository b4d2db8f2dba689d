#include "vantage/active/trigger.h"

#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "vantage/math/error.h"

namespace vantage {
namespace {

Measure Of(std::initializer_list<double> sigma) {
  Measure measure;
  measure.sigma.resize(static_cast<Eigen::Index>(sigma.size()));
  measure.w = 1.0;
  int i = 0;
  for (const double value : sigma) {
    measure.sigma(i++) = value;
    measure.w *= value;
    measure.log_w += std::log(value);
  }
  measure.sigma_min = measure.sigma(i - 1);
  return measure;
}

TriggerState Feed(const TriggerOptions& options, TriggerState state,
                  std::initializer_list<double> values, int* fired = nullptr) {
  for (const double value : values) {
    state = UpdateTrigger(options, state, value);
    if (fired != nullptr && state.fired) ++*fired;
  }
  return state;
}

TEST(TriggerValue, IsTheMeasureNamed) {
  const Measure measure = Of({400.0, 50.0});
  EXPECT_NEAR(TriggerValue(TriggerMeasure::kGeometricMean, measure), std::sqrt(20000.0), 1e-9);
  EXPECT_EQ(TriggerValue(TriggerMeasure::kCompositeW, measure), 20000.0);
  EXPECT_EQ(TriggerValue(TriggerMeasure::kSigmaMin, measure), 50.0);
  EXPECT_EQ(TriggerValue(TriggerMeasure::kInverseCondition, measure), 0.125);
}

TEST(TriggerValue, OfNothingIsZero) {
  for (const auto measure : {TriggerMeasure::kGeometricMean, TriggerMeasure::kCompositeW,
                             TriggerMeasure::kSigmaMin, TriggerMeasure::kInverseCondition}) {
    EXPECT_EQ(TriggerValue(measure, Measure{}), 0.0);
  }
}

TEST(Trigger, FiresAfterDebounceOnce) {
  const TriggerOptions options;
  int fired = 0;
  TriggerState state = Feed(options, {}, {100.0, 100.0}, &fired);
  EXPECT_FALSE(state.triggered);
  EXPECT_EQ(fired, 0);
  state = Feed(options, state, {100.0}, &fired);
  EXPECT_TRUE(state.triggered);
  EXPECT_TRUE(state.fired);
  state = Feed(options, state, {100.0, 90.0, 100.0}, &fired);
  EXPECT_TRUE(state.triggered);
  EXPECT_EQ(fired, 1);
}

TEST(Trigger, OneGoodValueStartsTheCountAnew) {
  EXPECT_FALSE(Feed({}, {}, {100.0, 100.0, 121.0, 100.0, 100.0}).triggered);
}

TEST(Trigger, ThresholdItselfIsGoodEnough) {
  EXPECT_FALSE(Feed({}, {}, {120.0, 120.0, 120.0, 120.0}).triggered);
}

TEST(Trigger, ReArmsOnlyAboveHysteresis) {
  const TriggerOptions options;  // 120, re-armed above 144
  TriggerState state = Feed(options, {}, {100.0, 100.0, 100.0});
  state = Feed(options, state, {130.0, 144.0});
  EXPECT_TRUE(state.triggered);
  state = Feed(options, state, {144.1});
  EXPECT_FALSE(state.triggered);
}

TEST(Trigger, NotANumberCountsAsBelow) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(Feed({}, {}, {nan, nan, nan}).triggered);
  EXPECT_TRUE(Feed({}, Feed({}, {}, {nan, nan, nan}), {nan}).triggered);
}

// Noise round the threshold, smaller than the hysteresis: one firing, however long it lasts.
TEST(Trigger, DoesNotChatter) {
  std::mt19937 random(31);
  std::normal_distribution<double> noise(0.0, 5.0);
  int fired = 0;
  TriggerState state;
  for (int i = 0; i < 5000; ++i) {
    state = UpdateTrigger({}, state, 120.0 + std::min(20.0, noise(random)));
    fired += state.fired ? 1 : 0;
  }
  EXPECT_EQ(fired, 1);
}

TEST(ValidateTrigger, RefusesEachCause) {
  EXPECT_NO_THROW(Validate(TriggerOptions{}));
  TriggerOptions bad;
  bad.threshold = 0.0;
  EXPECT_THROW(Validate(bad), ConfigError);
  bad = {};
  bad.hysteresis = 0.99;
  EXPECT_THROW(Validate(bad), ConfigError);
  bad = {};
  bad.debounce = 0;
  EXPECT_THROW(Validate(bad), ConfigError);
}

}  // namespace
}  // namespace vantage
