#pragma once

#include <Eigen/Core>

#include "vantage/camera/camera_model.h"
#include "vantage/vision/image.h"

/// @file
/// What a window of an image can show, in terms of the ideal rays through it.

namespace vantage::sim {

/// Bounds of the ideal rays (X/Z, Y/Z) through a window: what lies outside of them is not in it.
struct RayBounds {
  double x0{1e9}, x1{-1e9}, y0{1e9}, y1{-1e9};
};

[[nodiscard]] RayBounds BoundRays(const CameraModel& camera, const PixelWindow& window);

/// Whether a sphere, in the camera's frame, may be seen within the bounds.
[[nodiscard]] bool SphereMeets(const RayBounds& bounds, const Eigen::Vector3d& centre_C,
                               double radius);

}  // namespace vantage::sim
