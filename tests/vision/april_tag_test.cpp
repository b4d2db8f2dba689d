#include "vantage/vision/april_tag.h"

#include <gtest/gtest.h>

#include "eigen_matchers.h"
#include "vantage/math/angles.h"

namespace vantage {
namespace {

using Eigen::Vector3d;

TEST(TagMarkers, AreTheCornersAgainstTheClock) {
  Tag tag;
  tag.id = 3;
  tag.size = 0.1;
  tag.X_FT.linear() = Eigen::AngleAxisd(kPi / 2.0, Vector3d::UnitZ()).toRotationMatrix();
  tag.X_FT.translation() << 0.0, 0.0, 0.02;
  const std::vector<Marker> markers = TagMarkers(tag);
  ASSERT_EQ(markers.size(), 4U);
  EXPECT_EQ(markers[0].id, 12);
  EXPECT_EQ(markers[3].id, 15);
  EXPECT_TRUE(test::Near(markers[0].p, Vector3d(0.05, -0.05, 0.02), 1e-12));
  EXPECT_TRUE(test::Near(markers[1].p, Vector3d(0.05, 0.05, 0.02), 1e-12));
  EXPECT_TRUE(test::Near(markers[2].normal, Vector3d::UnitZ(), 1e-12));
}

}  // namespace
}  // namespace vantage
