#include "sim/render/ray_bounds.h"

#include <algorithm>
#include <cmath>

namespace vantage::sim {

using Eigen::Vector2d;

RayBounds BoundRays(const CameraModel& camera, const PixelWindow& window) {
  RayBounds bounds;
  constexpr int kSteps = 8;
  for (int i = 0; i <= kSteps; ++i) {
    for (int j = 0; j <= kSteps; ++j) {
      if (i % kSteps != 0 && j % kSteps != 0) continue;  // The rim only.
      const Vector2d n =
          ToNormalised(camera, {window.u - 0.5 + window.width * i / double{kSteps},
                                window.v - 0.5 + window.height * j / double{kSteps}});
      bounds.x0 = std::min(bounds.x0, n.x());
      bounds.x1 = std::max(bounds.x1, n.x());
      bounds.y0 = std::min(bounds.y0, n.y());
      bounds.y1 = std::max(bounds.y1, n.y());
    }
  }
  if (!camera.distortion.none()) {  // The rim bows outwards between the samples.
    const double margin = 0.02 * std::max(bounds.x1 - bounds.x0, bounds.y1 - bounds.y0);
    bounds = {bounds.x0 - margin, bounds.x1 + margin, bounds.y0 - margin, bounds.y1 + margin};
  }
  return bounds;
}

RayBounds Intersection(const RayBounds& a, const RayBounds& b) noexcept {
  return {std::max(a.x0, b.x0), std::min(a.x1, b.x1), std::max(a.y0, b.y0), std::min(a.y1, b.y1)};
}

RayBounds Union(const RayBounds& a, const RayBounds& b) noexcept {
  return {std::min(a.x0, b.x0), std::max(a.x1, b.x1), std::min(a.y0, b.y0), std::max(a.y1, b.y1)};
}

double Area(const RayBounds& bounds) noexcept {
  return std::max(bounds.x1 - bounds.x0, 0.0) * std::max(bounds.y1 - bounds.y0, 0.0);
}

bool SphereMeets(const RayBounds& bounds, const Eigen::Vector3d& centre_C, double radius) {
  if (centre_C.z() < -radius) return false;
  const auto outside = [&](double along, double bound, double side) {
    return side * (along - bound * centre_C.z()) > radius * std::hypot(1.0, bound);
  };
  return !outside(centre_C.x(), bounds.x0, -1.0) && !outside(centre_C.x(), bounds.x1, 1.0) &&
         !outside(centre_C.y(), bounds.y0, -1.0) && !outside(centre_C.y(), bounds.y1, 1.0);
}

}  // namespace vantage::sim
