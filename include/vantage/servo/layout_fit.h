#pragma once

#include <array>

#include <Eigen/Core>

#include "vantage/math/sizes.h"

namespace vantage {

/// A point of a rigid layout, and where an image shows it.
struct LayoutPoint {
  Eigen::Vector3d p_LP_C;  ///< From the layout's origin to the point, in the camera's axes [m].
  Eigen::Vector2d n;       ///< Its image at unit focal length.
};

/// What an image of a layout may be off by; all > 0.
struct LayoutErrors {
  double n{5e-4};      ///< Of an image coordinate at unit focal length.
  double point{5e-4};  ///< Of a point in the layout [m].
  double turn{6e-3};   ///< Of the camera's orientation, about each axis [rad].
};

/// Where a layout stands before one camera.
struct LayoutFit {
  Eigen::Vector3d p_CL{Eigen::Vector3d::Zero()};  ///< Its origin in the camera's frame [m].
  double depth_sigma{0.0};                        ///< Standard deviation of p_CL.z() [m].
  bool solved{false};  ///< False: fewer than two points, or the layout is not before the camera.
};

/// Translation of a layout whose orientation is known but for a small turn, from one image: linear least
/// squares over x (Z + r_z) = X + r_x and the same for y, points r turned by θ to first order. The layout's
/// known size stands in for a calibrated distance: an error of the focal length or of the camera's position
/// shifts the result so that the layout is still seen where and as large as it is.
///
/// Real-time safe. @pre count <= kMaxPoints.
[[nodiscard]] LayoutFit FitLayout(const std::array<LayoutPoint, kMaxPoints>& points, int count,
                                  const LayoutErrors& errors) noexcept;

}  // namespace vantage
