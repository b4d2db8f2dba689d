#include "vantage/runtime/histogram.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace vantage {
namespace {

TEST(DurationHistogram, IsZeroWhenEmpty) {
  const DurationHistogram histogram;
  EXPECT_EQ(histogram.count(), 0);
  EXPECT_EQ(histogram.Percentile(0.5), Duration::zero());
}

TEST(DurationHistogram, BucketsJoinWithoutGap) {
  const DurationHistogram histogram;
  for (int i = 1; i < DurationHistogram::kBuckets; ++i) {
    ASSERT_EQ(histogram.bucket(i).lower, histogram.bucket(i - 1).upper) << "bucket " << i;
    ASSERT_LT(histogram.bucket(i).lower, histogram.bucket(i).upper) << "bucket " << i;
  }
  EXPECT_GT(histogram.bucket(DurationHistogram::kBuckets - 1).upper, std::chrono::seconds(10));
}

TEST(DurationHistogram, CountsWhereTheDurationLies) {
  for (int i = 0; i < DurationHistogram::kBuckets; ++i) {
    DurationHistogram histogram;
    histogram.Add(histogram.bucket(i).lower);
    histogram.Add(histogram.bucket(i).upper - Duration(1));
    ASSERT_EQ(histogram.bucket(i).count, 2) << "bucket " << i;
  }
}

TEST(DurationHistogram, TakesAnyDuration) {
  DurationHistogram histogram;
  histogram.Add(Duration(-5));
  histogram.Add(Duration::max());
  EXPECT_EQ(histogram.bucket(0).count, 1);
  EXPECT_EQ(histogram.bucket(DurationHistogram::kBuckets - 1).count, 1);
  EXPECT_EQ(histogram.count(), 2);
}

TEST(DurationHistogram, PercentilesAgreeWithSorting) {
  std::mt19937 random(11);
  std::lognormal_distribution<double> duration(9.0, 1.5);
  DurationHistogram histogram;
  std::vector<std::int64_t> sorted;
  for (int i = 0; i < 20'000; ++i) {
    sorted.push_back(std::llround(duration(random)));
    histogram.Add(Duration(sorted.back()));
  }
  std::sort(sorted.begin(), sorted.end());
  for (const double fraction : {0.01, 0.5, 0.9, 0.99, 0.999, 1.0}) {
    const auto rank = static_cast<std::size_t>(std::ceil(fraction * 20'000.0)) - 1;
    const auto exact = static_cast<double>(sorted[rank]);
    const auto given = static_cast<double>(histogram.Percentile(fraction).count());
    EXPECT_GE(given, exact) << fraction;
    EXPECT_LE(given, exact * (1.0 + 1.0 / 16.0) + 1.0) << fraction;
  }
  EXPECT_EQ(histogram.Percentile(1.0), histogram.max());
}

}  // namespace
}  // namespace vantage
