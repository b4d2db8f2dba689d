#include "vantage/features/point_feature.h"

#include <random>

#include <gtest/gtest.h>
#include <visp3/visual_features/vpFeaturePoint.h>

#include "eigen_matchers.h"
#include "finite_difference.h"
#include "vantage/math/spatial.h"

namespace vantage {
namespace {

using Eigen::Vector3d;

// Points over the whole image of a wide lens, from the nearest depth on.
Vector3d RandomPoint(std::mt19937* random) {
  std::uniform_real_distribution<double> side(-1.0, 1.0);
  std::uniform_real_distribution<double> log_depth(-3.0, 4.0);
  const double depth = std::exp(log_depth(*random));
  return depth * Vector3d(side(*random), side(*random), 1.0);
}

TEST(PointInteraction, EqualsViSP) {
  std::mt19937 random(7);
  for (int i = 0; i < 1000; ++i) {
    const ImagePoint point = *Project(RandomPoint(&random));
    vpFeaturePoint reference;
    reference.buildFrom(point.n.x(), point.n.y(), point.depth);
    const vpMatrix L = reference.interaction();
    const Eigen::Map<const Eigen::Matrix<double, 2, 6, Eigen::RowMajor>> L_visp(L.data);
    const double scale = std::max(1.0, L_visp.cwiseAbs().maxCoeff());
    EXPECT_TRUE(test::Near(PointInteraction(point), L_visp, 1e-15 * scale));
  }
}

TEST(PointInteraction, MatchesCentralDifference) {
  std::mt19937 random(8);
  for (int i = 0; i < 50; ++i) {
    const Vector3d p_CP = RandomPoint(&random);
    const auto numeric = test::CentralDifference(
        [&](const Eigen::VectorXd& step) {
          const auto X_CD = Advance(Eigen::Isometry3d::Identity(), Twist(step));
          return Eigen::Vector2d(Project(X_CD.inverse() * p_CP)->n);
        },
        2, 6, 1e-6);
    const Eigen::Matrix<double, 2, 6> L = PointInteraction(*Project(p_CP));
    EXPECT_TRUE(test::Near(L, numeric, 1e-8 * L.cwiseAbs().maxCoeff()));
  }
}

// Turning the camera moves every point of a ray alike: the last three columns ignore the depth.
TEST(PointInteraction, RotationPartIsFreeOfDepth) {
  const Eigen::Vector2d n(0.3, -0.7);
  EXPECT_TRUE(test::Near(PointInteraction({n, 0.3}).rightCols<3>(),
                         PointInteraction({n, 30.0}).rightCols<3>(), 0.0));
}

}  // namespace
}  // namespace vantage
