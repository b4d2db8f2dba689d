#include "vantage/servo/layout_fit.h"

#include <cmath>
#include <random>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

namespace vantage {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Layout = std::array<LayoutPoint, kMaxPoints>;

// Four points of a plate that is turned away from the camera by half a radian.
std::array<Vector3d, 4> Plate() {
  const Eigen::AngleAxisd turn(0.5, Vector3d(0.6, -0.8, 0.0));
  return {turn * Vector3d(0, 0, 0), turn * Vector3d(0.12, 0, 0), turn * Vector3d(0.12, 0.1, 0),
          turn * Vector3d(0, 0.1, 0)};
}

Layout Seen(const std::array<Vector3d, 4>& true_points, const std::array<Vector3d, 4>& known,
            const Vector3d& p_CL, double magnification = 1.0) {
  Layout layout;
  for (std::size_t i = 0; i < 4; ++i) {
    const Vector3d p = p_CL + true_points[i];
    layout[i] = {known[i], magnification * Vector2d(p.x() / p.z(), p.y() / p.z())};
  }
  return layout;
}

const Vector3d kPlace(0.15, -0.1, 0.9);

TEST(LayoutFit, ExactWithoutErrors) {
  for (const int count : {2, 3, 4}) {
    const LayoutFit fit = FitLayout(Seen(Plate(), Plate(), kPlace), count, {});
    ASSERT_TRUE(fit.solved) << count;
    EXPECT_LT((fit.p_CL - kPlace).norm(), 1e-9) << count;
    EXPECT_GT(fit.depth_sigma, 0.0);
  }
}

// A focal length that is off by 2 %: the depth is off by as much, so that a point beside the layout is
// still expected where it is seen.
TEST(LayoutFit, KeepsTheSizeInTheImageThroughAFocalError) {
  const double magnification = 1.02;
  const LayoutFit fit = FitLayout(Seen(Plate(), Plate(), kPlace, magnification), 4, {});
  ASSERT_TRUE(fit.solved);
  EXPECT_NEAR(fit.p_CL.z(), kPlace.z() / magnification, 0.01 * kPlace.z());
  const Vector3d beside(0.05, 0.05, 0.0);
  const Vector3d p = fit.p_CL + beside;
  const Vector3d truth = kPlace + beside;
  const Vector2d error = Vector2d(p.x() / p.z(), p.y() / p.z()) -
                         magnification * Vector2d(truth.x() / truth.z(), truth.y() / truth.z());
  EXPECT_LT(error.norm(), 3e-4);  // 0.2 px of 600; taken from the depth alone it would be 0.7
}

// Errors drawn as they are said to be: the depth is as good as it claims.
TEST(LayoutFit, ClaimsTheSigmaItHas) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal(0.0, 1.0);
  LayoutErrors errors;
  constexpr int kTrials = 2000;
  for (const int count : {2, 4}) {
    double sum = 0.0;
    for (int trial = 0; trial < kTrials; ++trial) {
      const Vector3d axis = errors.turn * Vector3d(normal(random), normal(random), normal(random));
      const Eigen::AngleAxisd turn(axis.norm(), axis.normalized());
      std::array<Vector3d, 4> moved = Plate();
      for (Vector3d& p : moved) {
        p = turn * p + errors.point * Vector3d(normal(random), normal(random), 0.0);
      }
      Layout layout = Seen(moved, Plate(), kPlace);
      for (LayoutPoint& point : layout)
        point.n += errors.n * Vector2d(normal(random), normal(random));
      const LayoutFit fit = FitLayout(layout, count, errors);
      ASSERT_TRUE(fit.solved);
      const double z = (fit.p_CL.z() - kPlace.z()) / fit.depth_sigma;
      sum += z * z;
    }
    // Of 2000 the mean square is within 0.13 of 1 in 9999 of 10000 runs; first order costs a little more.
    EXPECT_NEAR(sum / kTrials, 1.0, 0.25) << count;
  }
}

TEST(LayoutFit, SaysWhenTheImageTellsNothing) {
  const Layout layout = Seen(Plate(), Plate(), kPlace);
  EXPECT_FALSE(FitLayout(layout, 0, {}).solved);
  EXPECT_FALSE(FitLayout(layout, 1, {}).solved);
  // Two points one behind the other show no size.
  Layout in_line;
  in_line[0] = {Vector3d(0, 0, 0), Vector2d(0, 0)};
  in_line[1] = {Vector3d(0, 0, 0.1), Vector2d(0, 0)};
  const LayoutFit fit = FitLayout(in_line, 2, {});
  EXPECT_TRUE(!fit.solved || fit.depth_sigma > 10.0);
  // An image upside down is that of a layout behind the camera.
  Layout behind = layout;
  for (LayoutPoint& point : behind) point.n = -point.n;
  EXPECT_FALSE(FitLayout(behind, 4, {}).solved);
  Layout not_finite = layout;
  not_finite[1].n.x() = std::nan("");
  EXPECT_FALSE(FitLayout(not_finite, 4, {}).solved);
}

}  // namespace
}  // namespace vantage
