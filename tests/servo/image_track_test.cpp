#include "vantage/servo/image_track.h"

#include <gtest/gtest.h>

#include "eigen_matchers.h"

namespace vantage {
namespace {

using Eigen::Vector2d;

constexpr double kImageTime = 0.02;  // [s]

Time At(int image) {
  return Time(FromSeconds(1.0 + image * kImageTime));
}

TEST(ImageTrack, FindsTheRateOfWhatMovesSteadily) {
  const Vector2d rate(0.5, -0.2);
  ImageTrack track;
  for (int i = 0; i < 60; ++i) track.Update(At(i), i * kImageTime * rate, Vector2d::Zero());
  EXPECT_TRUE(test::Near(track.rate(), rate, 1e-5));
  EXPECT_TRUE(test::Near(track.place(), 59 * kImageTime * rate, 1e-6));
  EXPECT_EQ(track.last(), At(59));
}

TEST(ImageTrack, LeavesOutWhatTheCameraMovedIt) {
  const Vector2d step(0.004, 0.001);
  ImageTrack track;
  for (int i = 0; i < 60; ++i) track.Update(At(i), i * step, step);
  EXPECT_TRUE(test::Near(track.rate(), Vector2d::Zero(), 1e-12));
}

TEST(ImageTrack, StartsAnewAfterAGap) {
  ImageTrack track;
  for (int i = 0; i < 60; ++i) track.Update(At(i), Vector2d(0.01 * i, 0.0), Vector2d::Zero());
  ASSERT_GT(track.rate().x(), 0.1);
  const Vector2d elsewhere(-0.3, 0.2);
  track.Update(At(59 + 16), elsewhere, Vector2d::Zero());  // 0.32 s later
  EXPECT_EQ(track.place(), elsewhere);
  EXPECT_EQ(track.rate(), Vector2d(0.0, 0.0));
}

}  // namespace
}  // namespace vantage
