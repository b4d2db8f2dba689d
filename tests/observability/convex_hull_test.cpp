#include "convex_hull.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

namespace vantage {
namespace {

using Eigen::Vector3d;

class Points {
 public:
  explicit Points(unsigned seed) : random_(seed) {}
  Vector3d Next() { return {uniform_(random_), uniform_(random_), uniform_(random_)}; }

 private:
  std::mt19937 random_;
  std::uniform_real_distribution<double> uniform_{-1.0, 1.0};
};

// In every direction the hull reaches as far as the points do.
void ExpectSameReach(const std::vector<Vector3d>& points, const std::vector<int>& hull) {
  Points directions(99);
  for (int i = 0; i < 2000; ++i) {
    const Vector3d n = directions.Next().normalized();
    double all = -1e9, kept = -1e9;
    for (const Vector3d& p : points) all = std::max(all, n.dot(p));
    for (const int k : hull) kept = std::max(kept, n.dot(points[k]));
    ASSERT_NEAR(kept, all, 1e-9) << n.transpose();
  }
}

TEST(ConvexHull, KeepsTheReachOfACloud) {
  Points next(1);
  for (const int count : {5, 8, 30, 400}) {
    std::vector<Vector3d> points(count);
    for (Vector3d& p : points) p = next.Next();
    const std::vector<int> hull = ConvexHullVertices(points);
    ExpectSameReach(points, hull);
    EXPECT_TRUE(std::is_sorted(hull.begin(), hull.end()));
    if (count == 400) {
      EXPECT_LT(hull.size(), 150u);
    }
  }
}

TEST(ConvexHull, KeepsEveryPointOfASphere) {
  Points next(2);
  std::vector<Vector3d> points(300);
  for (Vector3d& p : points) p = next.Next().normalized();
  EXPECT_EQ(ConvexHullVertices(points).size(), points.size());
}

TEST(ConvexHull, LeavesOutWhatIsInside) {
  std::vector<Vector3d> points;
  for (int i = 0; i < 8; ++i) points.emplace_back(i & 1, (i >> 1) & 1, (i >> 2) & 1);
  Points next(3);
  for (int i = 0; i < 50; ++i) points.push_back(Vector3d::Constant(0.5) + 0.49 * next.Next());
  const std::vector<int> hull = ConvexHullVertices(points);
  EXPECT_EQ(hull, (std::vector<int>{0, 1, 2, 3, 4, 5, 6, 7}));
}

TEST(ConvexHull, ServesCurvesOfAMotion) {
  std::vector<Vector3d> points;
  for (int i = 0; i < 128; ++i) {
    const double t = 3.0 * i / 127.0;
    points.emplace_back(std::cos(t) * (1.0 + std::cos(2.0 * t)), std::sin(t), std::sin(2.0 * t));
    points.push_back(points.back() + Vector3d(0.02, 0.05 * std::sin(t), 0.05 * std::cos(t)));
  }
  ExpectSameReach(points, ConvexHullVertices(points));
}

TEST(ConvexHull, ServesFlatStraightAndSinglePoints) {
  Points next(4);
  const Vector3d u = next.Next().normalized();
  const Vector3d v = u.unitOrthogonal();
  std::vector<Vector3d> flat, straight;
  for (int i = 0; i < 100; ++i) {
    const Vector3d a = next.Next();
    flat.push_back(a.x() * u + a.y() * v + Vector3d(1, 2, 3));
    straight.push_back(a.x() * u + Vector3d(1, 2, 3));
  }
  const std::vector<int> of_flat = ConvexHullVertices(flat);
  ExpectSameReach(flat, of_flat);
  EXPECT_LT(of_flat.size(), 50u);
  const std::vector<int> of_straight = ConvexHullVertices(straight);
  ExpectSameReach(straight, of_straight);
  EXPECT_EQ(of_straight.size(), 2u);
  EXPECT_EQ(ConvexHullVertices({Vector3d(1, 2, 3), Vector3d(1, 2, 3)}).size(), 1u);
  EXPECT_TRUE(ConvexHullVertices({}).empty());
}

// A grid has many points in every face's plane.
TEST(ConvexHull, ServesAGrid) {
  std::vector<Vector3d> points;
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < 6; ++j) {
      for (int k = 0; k < 6; ++k) points.emplace_back(0.1 * i, 0.3 * j, 0.7 * k);
    }
  }
  const std::vector<int> hull = ConvexHullVertices(points);
  ExpectSameReach(points, hull);
  EXPECT_EQ(hull.size(), 8u);
}

}  // namespace
}  // namespace vantage
