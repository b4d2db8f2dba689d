#include "vantage/vision/image.h"

#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace vantage {
namespace {

TEST(PixelWindows, ClipKeepsWhatLiesInside) {
  const PixelWindow clipped = Clip({-5, 90, 20, 30}, 100, 100);
  EXPECT_EQ(clipped.u, 0);
  EXPECT_EQ(clipped.v, 90);
  EXPECT_EQ(clipped.width, 15);
  EXPECT_EQ(clipped.height, 10);
  EXPECT_TRUE(Clip({100, 0, 10, 10}, 100, 100).empty());
  EXPECT_TRUE(Clip({-10, 0, 10, 10}, 100, 100).empty());
}

TEST(PixelWindows, HullOfAnEmptyOneIsTheOther) {
  EXPECT_EQ(Hull({}, {3, 4, 5, 6}).area(), 30);
  EXPECT_EQ(Hull({0, 0, 1, 1}, {9, 9, 1, 1}).area(), 100);
}

TEST(PixelWindows, MergingLosesNoPixelAndNamesNoneTwice) {
  std::mt19937 random(9);
  std::uniform_int_distribution<int> place(-20, 110);
  std::uniform_int_distribution<int> size(0, 30);
  for (int i = 0; i < 200; ++i) {
    std::vector<PixelWindow> windows;
    for (int k = 0; k < 8; ++k) {
      windows.push_back({place(random), place(random), size(random), size(random)});
    }
    const std::vector<PixelWindow> apart = MergeOverlapping(windows, 100, 90);
    for (int v = 0; v < 90; ++v) {
      for (int u = 0; u < 100; ++u) {
        int asked = 0;
        int held = 0;
        for (const PixelWindow& window : windows) asked += window.contains(u, v) ? 1 : 0;
        for (const PixelWindow& window : apart) held += window.contains(u, v) ? 1 : 0;
        ASSERT_LE(held, 1);
        if (asked > 0) {
          ASSERT_EQ(held, 1);
        }
      }
    }
  }
}

}  // namespace
}  // namespace vantage
