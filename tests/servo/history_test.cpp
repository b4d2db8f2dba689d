#include "vantage/servo/history.h"

#include <gtest/gtest.h>

namespace vantage {
namespace {

Time At(double seconds) {
  return Time(FromSeconds(seconds));
}
double Mix(double a, double b, double fraction) {
  return a + fraction * (b - a);
}

TEST(History, InterpolatesBetweenNeighbours) {
  History<double, 8> history;
  ASSERT_TRUE(history.Push(At(1.0), 10.0));
  ASSERT_TRUE(history.Push(At(2.0), 20.0));
  ASSERT_TRUE(history.Push(At(4.0), 0.0));
  EXPECT_DOUBLE_EQ(*history.At(At(1.25), Mix), 12.5);
  EXPECT_DOUBLE_EQ(*history.At(At(3.0), Mix), 10.0);
  EXPECT_DOUBLE_EQ(*history.At(At(2.0), Mix), 20.0);
}

TEST(History, HoldsItsEndsOutsideTheRange) {
  History<double, 8> history;
  EXPECT_FALSE(history.At(At(1.0), Mix).has_value());
  history.Push(At(1.0), 10.0);
  history.Push(At(2.0), 20.0);
  EXPECT_DOUBLE_EQ(*history.At(At(0.0), Mix), 10.0);
  EXPECT_DOUBLE_EQ(*history.At(At(9.0), Mix), 20.0);
}

TEST(History, ForgetsTheOldest) {
  History<double, 4> history;
  for (int i = 0; i < 10; ++i) history.Push(At(i), i);
  EXPECT_EQ(history.size(), 4);
  EXPECT_DOUBLE_EQ(*history.At(At(0.0), Mix), 6.0);
  EXPECT_DOUBLE_EQ(*history.At(At(7.5), Mix), 7.5);
}

TEST(History, RefusesStampsThatDoNotIncrease) {
  History<double, 4> history;
  ASSERT_TRUE(history.Push(At(1.0), 10.0));
  EXPECT_FALSE(history.Push(At(1.0), 11.0));
  EXPECT_FALSE(history.Push(At(0.5), 12.0));
  EXPECT_DOUBLE_EQ(history.newest(), 10.0);
}

}  // namespace
}  // namespace vantage
