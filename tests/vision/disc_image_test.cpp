#include "vantage/vision/disc_image.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "eigen_matchers.h"
#include "vantage/math/angles.h"

namespace vantage {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::Vector3d;

CameraModel Straight() {
  CameraModel camera;
  camera.fx = 610.0;
  camera.fy = 590.0;
  camera.skew = 3.0;
  return camera;
}

CameraModel Bent() {
  CameraModel camera = Straight();
  camera.distortion = {-0.28, 0.09, 8e-4, -5e-4, -0.011};
  return camera;
}

struct Disc {
  Vector3d p_C, normal_C;
  double radius;
};

Disc RandomDisc(std::mt19937* random) {
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  Disc disc;
  disc.p_C =
      Vector3d(0.35 * uniform(*random), 0.28 * uniform(*random), 0.8 + 0.3 * uniform(*random));
  disc.normal_C = Vector3d(0.9 * uniform(*random), 0.9 * uniform(*random), -1.0).normalized();
  disc.radius = 0.015;
  return disc;
}

// Area, centroid and second moments of the disc's image by integration over the disc itself.
struct Moments {
  double area{0.0};
  Vector2d mean{Vector2d::Zero()};
  Matrix2d covariance{Matrix2d::Zero()};
};

Moments Integrate(const CameraModel& camera, const Disc& disc) {
  const PlaneAxes axes = AxesOfPlane(disc.normal_C);
  const auto pixel = [&](double s, double t) -> Vector2d {
    const Vector3d p = disc.p_C + disc.radius * (s * axes.e1 + t * axes.e2);
    return ToPixel(camera, p.head<2>() / p.z());
  };
  constexpr int kRings = 200;
  constexpr int kAngles = 120;
  Moments moments;
  for (int pass = 0; pass < 2; ++pass) {
    double total = 0.0;
    Vector2d first = Vector2d::Zero();
    Matrix2d second = Matrix2d::Zero();
    for (int i = 0; i < kRings; ++i) {
      for (int j = 0; j < kAngles; ++j) {
        const double r0 = std::sqrt(static_cast<double>(i) / kRings);
        const double r1 = std::sqrt((i + 1.0) / kRings);
        const double r = std::sqrt(0.5 * (r0 * r0 + r1 * r1));
        const double angle = 2.0 * kPi * (j + 0.5) / kAngles;
        const double s = r * std::cos(angle);
        const double t = r * std::sin(angle);
        constexpr double kStep = 1e-4;
        Matrix2d J;
        J << (pixel(s + kStep, t) - pixel(s - kStep, t)) / (2 * kStep),
            (pixel(s, t + kStep) - pixel(s, t - kStep)) / (2 * kStep);
        const double weight = std::abs(J.determinant()) * kPi / (kRings * kAngles);
        const Vector2d p = pixel(s, t);
        total += weight;
        first += weight * p;
        second += weight * (p - moments.mean) * (p - moments.mean).transpose();
      }
    }
    moments.area = total;
    moments.mean = first / total;
    moments.covariance = second / total;
  }
  return moments;
}

TEST(ProjectDisc, MatchesIntegrationOverTheDisc) {
  std::mt19937 random(3);
  for (int i = 0; i < 20; ++i) {
    const Disc disc = RandomDisc(&random);
    const auto image = ProjectDisc(Straight(), disc.p_C, disc.normal_C, disc.radius);
    ASSERT_TRUE(image.has_value());
    const Moments moments = Integrate(Straight(), disc);
    EXPECT_NEAR(image->area / moments.area, 1.0, 1e-5);
    EXPECT_TRUE(test::Near(image->centroid, moments.mean, 1e-5));
    EXPECT_TRUE(test::Near(image->shape / 4.0, moments.covariance, 1e-3));
  }
}

TEST(ProjectDisc, MatchesIntegrationThroughABentLens) {
  std::mt19937 random(4);
  for (int i = 0; i < 20; ++i) {
    const Disc disc = RandomDisc(&random);
    const auto image = ProjectDisc(Bent(), disc.p_C, disc.normal_C, disc.radius);
    ASSERT_TRUE(image.has_value());
    const Moments moments = Integrate(Bent(), disc);
    EXPECT_NEAR(image->area / moments.area, 1.0, 1e-4);
    EXPECT_TRUE(test::Near(image->centroid, moments.mean, 1e-4));
    EXPECT_TRUE(test::Near(image->shape / 4.0, moments.covariance, 5e-3));
  }
}

TEST(ProjectDisc, CentreIsTheProjectedCentreAndNotTheCentroid) {
  const Vector3d p_C(0.1, -0.05, 0.5);
  const auto image = ProjectDisc(Straight(), p_C, Vector3d(0.8, 0.0, -0.6).normalized(), 0.02);
  ASSERT_TRUE(image.has_value());
  EXPECT_TRUE(test::Near(image->centre, ToPixel(Straight(), p_C.head<2>() / p_C.z()), 1e-12));
  EXPECT_GT((image->centre - image->centroid).norm(), 0.2);
  EXPECT_DOUBLE_EQ(image->depth, 0.5);
}

TEST(ProjectDisc, IncidenceIsPositiveFromTheFront) {
  const Vector3d p_C(0.0, 0.0, 1.0);
  EXPECT_NEAR(ProjectDisc(Straight(), p_C, -Vector3d::UnitZ(), 0.01)->cos_incidence, 1.0, 1e-12);
  EXPECT_NEAR(ProjectDisc(Straight(), p_C, Vector3d::UnitZ(), 0.01)->cos_incidence, -1.0, 1e-12);
  EXPECT_NEAR(ProjectDisc(Straight(), p_C, Vector3d::UnitX(), 0.01)->cos_incidence, 0.0, 1e-12);
}

TEST(ProjectDisc, RefusesADiscPartlyBehindTheCamera) {
  EXPECT_FALSE(ProjectDisc(Straight(), {0.0, 0.0, 0.01}, Vector3d::UnitX(), 0.02));
}

TEST(ProjectDisc, RefusesNaN) {
  EXPECT_FALSE(ProjectDisc(Straight(), {0.0, std::nan(""), 1.0}, Vector3d::UnitX(), 0.02));
}

TEST(UndistortPixel, IsTheIdealLensPixelOfTheSameRay) {
  const Vector2d n(0.3, -0.25);
  CameraModel ideal = Bent();
  ideal.distortion = {};
  EXPECT_TRUE(test::Near(UndistortPixel(Bent(), ToPixel(Bent(), n)), ToPixel(ideal, n), 1e-9));
}

}  // namespace
}  // namespace vantage
