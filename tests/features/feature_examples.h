#pragma once

#include <algorithm>
#include <random>
#include <vector>

#include <Eigen/Core>

#include "vantage/camera/camera_model.h"
#include "vantage/features/feature_set.h"
#include "vantage/math/spatial.h"

/// @file
/// One feature of every kind, points to compute it from, and steps of camera and end effector.

namespace vantage::test {

inline constexpr int kExamplePoints = 5;

[[nodiscard]] inline CameraModel SkewedCamera() {
  CameraModel camera;
  camera.fx = 610.0;
  camera.fy = 575.0;
  camera.u0 = 321.0;
  camera.v0 = 237.0;
  camera.skew = 3.0;
  return camera;
}

/// A displacement with entries of at most `scale` [m, rad].
[[nodiscard]] inline Twist RandomStep(std::mt19937* random, double scale) {
  std::uniform_real_distribution<double> uniform(-scale, scale);
  Twist step;
  for (int i = 0; i < 6; ++i) step(i) = uniform(*random);
  return step;
}

/// E moved by a displacement of its origin and a turn about it, both in world axes.
[[nodiscard]] inline Eigen::Isometry3d MovedInWorldAxes(const Eigen::Isometry3d& X_WE,
                                                        const Twist& step_W) {
  Twist step_E;
  step_E.head<3>() = X_WE.linear().transpose() * step_W.head<3>();
  step_E.tail<3>() = X_WE.linear().transpose() * step_W.tail<3>();
  return Advance(X_WE, step_E);
}

/// A feature of the kind over points 0.. of kExamplePoints.
[[nodiscard]] inline Feature Example(FeatureKind kind) {
  switch (kind) {
    case FeatureKind::kPointX:
    case FeatureKind::kPointY:
      return {kind, {1}};
    case FeatureKind::kEdgeAngle:
      return {kind, {0, 1, 3, 4}};
    case FeatureKind::kMomentBasic:
      return {kind, {0, 1, 2, 4}, 2, 1};
    case FeatureKind::kMomentCentred:
      return {kind, {0, 1, 2, 4}, 1, 2};
    case FeatureKind::kDistance:
    case FeatureKind::kAngle:
    case FeatureKind::kSegmentX:
    case FeatureKind::kSegmentY:
    case FeatureKind::kSegmentLength:
    case FeatureKind::kSegmentAngle:
    case FeatureKind::kSegmentXNormalised:
    case FeatureKind::kSegmentYNormalised:
    case FeatureKind::kSegmentInverseLength:
      return {kind, {0, 2}};
    default:
      return {kind, {0, 1, 2, 4}, 0, 0, 900.0, 1.5};
  }
}

/// Rays (x, y, 1) into the image, apart: close to where points coincide, differences over a step say
/// little.
[[nodiscard]] inline std::vector<Eigen::Vector3d> RandomRays(std::mt19937* random) {
  std::uniform_real_distribution<double> side(-0.4, 0.4);
  std::vector<Eigen::Vector3d> rays;
  while (static_cast<int>(rays.size()) < kExamplePoints) {
    const Eigen::Vector3d ray(side(*random), side(*random), 1.0);
    const auto close = [&](const Eigen::Vector3d& other) { return (ray - other).norm() < 0.2; };
    if (std::none_of(rays.begin(), rays.end(), close)) rays.push_back(ray);
  }
  return rays;
}

}  // namespace vantage::test
