#include "vantage/camera/camera_model.h"

#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/calib3d.hpp>

#include "eigen_matchers.h"
#include "finite_difference.h"
#include "vantage/camera/pinhole.h"

namespace vantage {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

CameraModel BentLens() {
  CameraModel camera;
  camera.fx = 610.0;
  camera.fy = 590.0;
  camera.u0 = 330.0;
  camera.v0 = 228.0;
  camera.distortion = {-0.28, 0.09, 8e-4, -5e-4, -0.011};
  return camera;
}

TEST(CameraModel, MatchesOpenCV) {
  const CameraModel camera = BentLens();
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(-0.5, 0.5);
  const cv::Mat K =
      (cv::Mat_<double>(3, 3) << camera.fx, 0, camera.u0, 0, camera.fy, camera.v0, 0, 0, 1);
  const std::vector<double> coefficients{-0.28, 0.09, 8e-4, -5e-4, -0.011};
  for (int i = 0; i < 100; ++i) {
    const Vector2d n(uniform(random), uniform(random));
    std::vector<cv::Point2d> reference;
    cv::projectPoints(std::vector<cv::Point3d>{{n.x(), n.y(), 1.0}}, cv::Vec3d(), cv::Vec3d(), K,
                      coefficients, reference);
    EXPECT_TRUE(test::Near(ToPixel(camera, n), Vector2d(reference[0].x, reference[0].y), 1e-10));
  }
}

TEST(CameraModel, ToNormalisedUndoesToPixel) {
  CameraModel camera = BentLens();
  camera.skew = 2.5;
  for (double x = -0.5; x <= 0.5; x += 0.1) {
    for (double y = -0.38; y <= 0.38; y += 0.095) {
      const Vector2d n(x, y);
      EXPECT_TRUE(test::Near(ToNormalised(camera, ToPixel(camera, n)), n, 1e-12));
    }
  }
}

// The same lens without its distortion: both ways, in closed form.
TEST(CameraModel, UndistortedPixelsAreThoseOfTheIdealLens) {
  CameraModel camera = BentLens();
  camera.skew = 2.5;
  CameraModel ideal = camera;
  ideal.distortion = {};
  const Vector2d n(0.31, -0.22);
  const Vector2d pixel(610.0 * 0.31 + 2.5 * -0.22 + 330.0, 590.0 * -0.22 + 228.0);
  EXPECT_TRUE(test::Near(ToUndistortedPixel(camera, n), pixel, 1e-12));
  EXPECT_EQ(ToUndistortedPixel(camera, n), ToPixel(ideal, n));
  EXPECT_TRUE(test::Near(FromUndistortedPixel(camera, pixel), n, 1e-15));
  EXPECT_EQ(FromUndistortedPixel(camera, pixel), ToNormalised(ideal, pixel));
}

TEST(CameraModel, PixelJacobianMatchesCentralDifference) {
  CameraModel camera = BentLens();
  camera.skew = 2.5;
  const Vector2d n(0.31, -0.22);
  const auto numeric = test::CentralDifference(
      [&](const Eigen::VectorXd& step) { return ToPixel(camera, n + Vector2d(step)); }, 2, 2);
  EXPECT_TRUE(test::Near(PixelJacobian(camera, n), numeric, 1e-6));
}

TEST(CameraModel, InImageHasInclusiveBorders) {
  const CameraModel camera;
  EXPECT_TRUE(InImage(camera, {0, 0}));
  EXPECT_TRUE(InImage(camera, {639, 479}));
  EXPECT_FALSE(InImage(camera, {639.5, 100}));
  EXPECT_FALSE(InImage(camera, {19.9, 100}, 20.0));
  EXPECT_FALSE(InImage(camera, {std::numeric_limits<double>::quiet_NaN(), 100}));
}

TEST(Project, DividesByDepth) {
  const auto point = Project({0.3, -0.2, 0.5});
  ASSERT_TRUE(point.has_value());
  EXPECT_TRUE(test::Near(point->n, Vector2d(0.6, -0.4), 1e-15));
  EXPECT_EQ(point->depth, 0.5);
}

TEST(Project, RefusesPointsBehindAndNaN) {
  EXPECT_FALSE(Project({0.1, 0.1, 0.0}));
  EXPECT_FALSE(Project({0.1, 0.1, -1.0}));
  EXPECT_FALSE(Project({std::numeric_limits<double>::quiet_NaN(), 0.1, 1.0}));
}

}  // namespace
}  // namespace vantage
