#pragma once

#include <algorithm>
#include <random>
#include <vector>

#include <Eigen/Core>

#include "vantage/camera/camera_model.h"
#include "vantage/features/feature_set.h"

/// @file
/// One feature of every kind, and points to compute it from.

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
