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

/// What both show; empty, with x0 > x1 or y0 > y1, where they do not meet.
[[nodiscard]] RayBounds Intersection(const RayBounds& a, const RayBounds& b) noexcept;

/// Smallest bounds that hold both.
[[nodiscard]] RayBounds Union(const RayBounds& a, const RayBounds& b) noexcept;

/// Area on the plane one metre before the camera; 0 for empty ones.
[[nodiscard]] double Area(const RayBounds& bounds) noexcept;

/// Whether a sphere, in the camera's frame, may be seen within the bounds.
[[nodiscard]] bool SphereMeets(const RayBounds& bounds, const Eigen::Vector3d& centre_C,
                               double radius);

}  // namespace vantage::sim
