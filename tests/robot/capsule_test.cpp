#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "allocation_guard.h"
#include "eigen_matchers.h"
#include "vantage/math/angles.h"
#include "vantage/robot/kinematics.h"

namespace vantage {
namespace {

using Eigen::Vector3d;

// Distance of two segments by a search that knows no formula for it: the distance to a point that
// runs along the first is convex, so golden-section steps close in on its least value.
double DistanceBySearch(const Vector3d& a, const Vector3d& b, const Vector3d& c,
                        const Vector3d& d) {
  const auto to_second = [&](double s) {
    const Vector3d p = a + s * (b - a);
    double low = 0.0;
    double high = 1.0;
    for (int i = 0; i < 200; ++i) {
      const double t1 = low + (high - low) / 3.0;
      const double t2 = high - (high - low) / 3.0;
      ((c + t1 * (d - c) - p).norm() < (c + t2 * (d - c) - p).norm() ? high : low) =
          (c + t1 * (d - c) - p).norm() < (c + t2 * (d - c) - p).norm() ? t2 : t1;
    }
    return (c + low * (d - c) - p).norm();
  };
  double low = 0.0;
  double high = 1.0;
  for (int i = 0; i < 200; ++i) {
    const double s1 = low + (high - low) / 3.0;
    const double s2 = high - (high - low) / 3.0;
    if (to_second(s1) < to_second(s2)) {
      high = s2;
    } else {
      low = s1;
    }
  }
  return to_second(low);
}

TEST(SegmentHitsCapsule, AgreesWithASearchOverRandomPairs) {
  std::mt19937 random(21);
  std::uniform_real_distribution<double> value(-1.0, 1.0);
  const auto point = [&] { return Vector3d(value(random), value(random), value(random)); };
  for (int i = 0; i < 300; ++i) {
    const Vector3d a = point(), b = point(), c = point(), d = point();
    const double distance = DistanceBySearch(a, b, c, d);
    EXPECT_TRUE(SegmentHitsCapsule(a, b, {c, d, distance + 1e-6, 0})) << i;
    if (distance > 2e-6) {
      EXPECT_FALSE(SegmentHitsCapsule(a, b, {c, d, distance - 1e-6, 0})) << i;
    }
  }
}

TEST(SegmentHitsCapsule, AgreesForNearlyParallelSegments) {
  std::mt19937 random(22);
  std::uniform_real_distribution<double> value(-1.0, 1.0);
  const auto point = [&] { return Vector3d(value(random), value(random), value(random)); };
  for (int i = 0; i < 100; ++i) {
    const Vector3d a = point(), b = point();
    const Vector3d c = a + 0.3 * point() + 0.2 * (b - a);
    const Vector3d d = c + 0.8 * (b - a) + 1e-9 * point();
    const double distance = DistanceBySearch(a, b, c, d);
    EXPECT_TRUE(SegmentHitsCapsule(a, b, {c, d, distance + 1e-6, 0})) << i;
    EXPECT_FALSE(SegmentHitsCapsule(a, b, {c, d, distance - 1e-6, 0})) << i;
  }
}

struct Pair {
  const char* name;
  Vector3d a, b, c, d;
  double distance;
};

class SegmentsAt : public ::testing::TestWithParam<Pair> {};

TEST_P(SegmentsAt, HaveTheKnownDistance) {
  const Pair& p = GetParam();
  EXPECT_TRUE(SegmentHitsCapsule(p.a, p.b, {p.c, p.d, p.distance + 1e-9, 0}));
  EXPECT_FALSE(SegmentHitsCapsule(p.a, p.b, {p.c, p.d, p.distance - 1e-9, 0}));
}

INSTANTIATE_TEST_SUITE_P(
    Known, SegmentsAt,
    ::testing::Values(Pair{"Crossing", {-1, 0, 0}, {1, 0, 0}, {0, -1, 0.5}, {0, 1, 0.5}, 0.5},
                      Pair{"EndToSide", {0.2, 0, 0}, {0.2, 0, -3}, {-1, 0, 1}, {1, 0, 1}, 1.0},
                      Pair{"EndToEnd", {1, 0, 0}, {2, 0, 0}, {-1, 0, 0}, {-2, 3, 0}, 2.0},
                      Pair{"Parallel", {0, 0, 0}, {1, 0, 0}, {0.2, 0.3, 0}, {0.8, 0.3, 0}, 0.3},
                      Pair{"InLine", {0, 0, 0}, {1, 0, 0}, {3, 0, 0}, {4, 0, 0}, 2.0},
                      Pair{"Ball", {-1, 0, 0}, {1, 0, 0}, {0, 0.7, 0}, {0, 0.7, 0}, 0.7},
                      Pair{"PointAndBall", {0, 0, 0}, {0, 0, 0}, {3, 4, 0}, {3, 4, 0}, 5.0}),
    [](const auto& test) { return test.param.name; });

TEST(SegmentHitsCapsule, HoldsForASegmentInside) {
  EXPECT_TRUE(SegmentHitsCapsule({0, 0, 0.1}, {0, 0, 0.2}, {{0, 0, 0}, {0, 0, 1}, 0.5, 0}));
}

TEST(SegmentHitsCapsule, NotANumberHitsNothing) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(
      SegmentHitsCapsule({nan, nan, nan}, {nan, nan, nan}, {{0, 0, 0}, {0, 0, 1}, 9.0, 0}));
}

// Base, first and second link each carry one; joint 2 shifts along the first link's z.
ArmModel ArmWithCapsules() {
  std::vector<DhRow> rows(2);
  rows[1].kind = JointKind::kPrismatic;
  Eigen::Isometry3d base = Eigen::Isometry3d::Identity();
  base.translation() = Vector3d(0, 0, 10);
  return ArmModel("arm", DhConvention::kStandard, rows, std::vector<JointLimits>(2), base,
                  Eigen::Isometry3d::Identity(),
                  {{-1, {0, 0, 0}, {0, 0, 1}, 0.1},
                   {0, {0, 0, 0}, {1, 0, 0}, 0.2},
                   {1, {0, 0, 0}, {2, 0, 0}, 0.3}});
}

TEST(PlaceCapsules, CarriesEachWithItsLink) {
  std::vector<PlacedCapsule> placed;
  PlaceCapsules(ArmWithCapsules(), Eigen::Vector2d(kPi / 2, 5.0), &placed);
  ASSERT_EQ(placed.size(), 3u);
  EXPECT_TRUE(test::Near(placed[0].p_WB, Vector3d(0, 0, 11), 1e-15));
  EXPECT_TRUE(test::Near(placed[1].p_WB, Vector3d(0, 1, 10), 1e-15));
  EXPECT_TRUE(test::Near(placed[2].p_WA, Vector3d(0, 0, 15), 1e-15));
  EXPECT_TRUE(test::Near(placed[2].p_WB, Vector3d(0, 2, 15), 1e-15));
  EXPECT_EQ(placed[0].link, -1);
  EXPECT_EQ(placed[2].link, 1);
  EXPECT_EQ(placed[2].radius, 0.3);
}

TEST(PlaceCapsules, DoesNotAllocateOnceItHasRoom) {
  if (!test::AllocationGuard::kSupported) GTEST_SKIP();
  const ArmModel arm = ArmWithCapsules();
  std::vector<PlacedCapsule> placed;
  PlaceCapsules(arm, JointVector::Zero(2), &placed);
  const test::AllocationGuard guard;
  PlaceCapsules(arm, JointVector::Ones(2), &placed);
  const bool hit = SegmentHitsCapsule({0, 0, 10.5}, {5, 5, 5}, placed[0]);
  EXPECT_EQ(guard.count(), 0u);
  EXPECT_TRUE(hit);
}

}  // namespace
}  // namespace vantage
