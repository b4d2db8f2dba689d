#include "vantage/math/segment.h"

#include <gtest/gtest.h>

namespace vantage {
namespace {

using Eigen::Vector3d;

TEST(SquaredDistanceToSegment, IsToTheSideOrTheNearerEnd) {
  const Vector3d a(1, 2, 3);
  const Vector3d along(0, 0, 2);
  EXPECT_DOUBLE_EQ(SquaredDistanceToSegment(Vector3d(4, 2, 4), a, along), 9.0);
  EXPECT_DOUBLE_EQ(SquaredDistanceToSegment(Vector3d(1, 2, 1), a, along), 4.0);
  EXPECT_DOUBLE_EQ(SquaredDistanceToSegment(Vector3d(1, 5, 9), a, along), 25.0);
}

TEST(SquaredDistanceToSegment, OfNoLengthIsToItsPoint) {
  EXPECT_DOUBLE_EQ(SquaredDistanceToSegment(Vector3d(4, 6, 3), Vector3d(1, 2, 3), Vector3d::Zero()),
                   25.0);
}

}  // namespace
}  // namespace vantage
