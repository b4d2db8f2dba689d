#include "sim/render/hidden_points.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace vantage::sim {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

class HiddenPoints : public ::testing::Test {
 protected:
  double Uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }

  Vector3d Direction() {
    Vector3d v;
    do {
      v = Vector3d(Uniform(-1, 1), Uniform(-1, 1), Uniform(-1, 1));
    } while (v.norm() > 1.0 || v.norm() < 0.1);
    return v.normalized();
  }

  SweptEllipsoid Solid(const Vector3d& semi_axes, double half) {
    const Eigen::Matrix3d axes =
        Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), Direction()).toRotationMatrix() *
        Eigen::AngleAxisd(Uniform(-3, 3), Vector3d::UnitZ()).toRotationMatrix();
    SweptEllipsoid solid;
    solid.centre = Vector3d(0, 0, 1) * Uniform(0.3, 4.0) + 0.2 * Direction();
    solid.half = half * axes.col(0);
    solid.semi_axes = semi_axes;
    solid.to_unit = axes * semi_axes.cwiseInverse().asDiagonal() * axes.transpose();
    return solid;
  }

  // Somewhere about the edge of its shadow, in it, behind it or before it.
  Vector3d PointNear(const SweptEllipsoid& solid) {
    const Vector3d on_surface = solid.centre + Uniform(-1, 1) * solid.half +
                                solid.to_unit.inverse() * (Uniform(0.9, 1.1) * Direction());
    return on_surface * (Uniform(0, 1) < 0.5 ? 1.0 : Uniform(0.6, 2.0));
  }

  std::mt19937 random_{20};
};

// In the unit of the ellipsoid, from the segment between the camera and p to the solid's: by searching the former, along
// which the distance is convex.
double Distance(const SweptEllipsoid& solid, const Vector3d& p) {
  const Vector3d a = -solid.to_unit * solid.centre;
  const Vector3d way = solid.to_unit * p;
  const Vector3d half = solid.to_unit * solid.half;
  const auto at = [&](double s) {
    const Vector3d q = a + s * way;
    const double t =
        half.norm() > 0.0 ? std::clamp(q.dot(half) / half.squaredNorm(), -1.0, 1.0) : 0.0;
    return (q - t * half).norm();
  };
  double low = 0.0;
  double high = 1.0;
  for (int i = 0; i < 200; ++i) {
    const double third = (high - low) / 3.0;
    (at(low + third) < at(high - third) ? high : low) =
        at(low + third) < at(high - third) ? high - third : low + third;
  }
  return at(0.5 * (low + high));
}

bool NearlyParallel(const SweptEllipsoid& solid, const Vector3d& p) {
  const Vector3d way = (solid.to_unit * p).normalized();
  const Vector3d half = solid.to_unit * solid.half;
  return half.norm() > 0.0 && way.cross(half.normalized()).norm() < 0.011;
}

TEST_F(HiddenPoints, AreThoseBehindTheSolid) {
  const std::vector<std::pair<Vector3d, double>> shapes{
      {{0.1, 0.1, 0.1}, 0.0},       // Ball.
      {{0.2, 0.1, 0.05}, 0.0},      //
      {{0.05, 0.05, 0.0005}, 0.0},  // Plate.
      {{0.06, 0.06, 0.06}, 0.2},    // Capsule.
      {{0.03, 0.05, 0.02}, 0.4},    //
      {{0.02, 0.1, 0.002}, 0.2},    // Board.
  };
  int hidden = 0;
  int seen = 0;
  for (const auto& [semi_axes, half] : shapes) {
    for (int i = 0; i < 60; ++i) {
      const SweptEllipsoid solid_C = Solid(semi_axes, half);
      Isometry3d X_CB = Isometry3d::Identity();
      X_CB.linear() = Eigen::AngleAxisd(Uniform(-3, 3), Direction()).toRotationMatrix();
      X_CB.translation() = solid_C.centre + 0.1 * Direction();
      std::vector<Vector3d> points_C;
      std::vector<float> x;
      std::vector<float> y;
      std::vector<float> z;
      for (int k = 0; k < 50; ++k) {
        points_C.push_back(PointNear(solid_C));
        const Eigen::Vector3f p = (X_CB.inverse() * points_C.back()).cast<float>();
        x.push_back(p.x());
        y.push_back(p.y());
        z.push_back(p.z());
      }
      std::vector<std::uint32_t> marks(points_C.size(), 1U);
      MarkHidden(solid_C, X_CB, {x.data(), y.data(), z.data(), 50}, 4U, marks.data());
      for (std::size_t k = 0; k < points_C.size(); ++k) {
        EXPECT_EQ(marks[k] & ~4U, 1U);
        const double distance = Distance(solid_C, points_C[k]);
        if ((marks[k] & 4U) != 0) {
          EXPECT_LE(distance, 1.001) << semi_axes.transpose();
          ++hidden;
        } else {
          EXPECT_TRUE(distance >= 0.999 || NearlyParallel(solid_C, points_C[k])) << distance;
          ++seen;
        }
      }
    }
  }
  EXPECT_GT(hidden, 4000);
  EXPECT_GT(seen, 4000);
}

// Points beside the rim of a thin plate that is looked at from the front.
TEST_F(HiddenPoints, AreNoneBesideAPlatesRim) {
  SweptEllipsoid plate;
  plate.centre = {0, 0, 3};
  plate.semi_axes = {0.1, 0.1, 0.0005};
  plate.to_unit = plate.semi_axes.cwiseInverse().asDiagonal();
  for (int i = 0; i < 1000; ++i) {
    const double angle = Uniform(-3.2, 3.2);
    const double depth = Uniform(3.01, 3.5);
    for (const double share : {0.998, 1.002}) {
      const double radius = share * 0.1 * depth / 3.0;
      const float x = static_cast<float>(radius * std::cos(angle));
      const float y = static_cast<float>(radius * std::sin(angle));
      const float z = static_cast<float>(depth);
      std::uint32_t mark = 0;
      MarkHidden(plate, Isometry3d::Identity(), {&x, &y, &z, 1}, 1U, &mark);
      ASSERT_EQ(mark, share < 1.0 ? 1U : 0U) << angle << " " << depth;
    }
  }
}

TEST_F(HiddenPoints, AreNoneForACameraWithin) {
  SweptEllipsoid solid;
  solid.centre = {0, 0, 0.5};
  solid.half = {0, 0, 0.45};
  solid.to_unit *= 10.0;
  solid.semi_axes *= 0.1;
  const float x = 0.0F;
  const float y = 0.0F;
  const float z = 2.0F;
  std::uint32_t mark = 0;
  MarkHidden(solid, Isometry3d::Identity(), {&x, &y, &z, 1}, 1U, &mark);
  EXPECT_EQ(mark, 0U);
  solid.centre.z() = 0.6;  // Now before the camera.
  MarkHidden(solid, Isometry3d::Identity(), {&x, &y, &z, 1}, 1U, &mark);
  EXPECT_EQ(mark, 1U);
}

}  // namespace
}  // namespace vantage::sim
