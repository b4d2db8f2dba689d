#include "vantage/camera/camera_model.h"

#include <Eigen/LU>

namespace vantage {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

Vector2d Distort(const Distortion& d, const Vector2d& n) noexcept {
  if (d.none()) return n;
  const double x = n.x();
  const double y = n.y();
  const double r2 = x * x + y * y;
  const double radial = 1.0 + r2 * (d.k1 + r2 * (d.k2 + r2 * d.k3));
  return {x * radial + 2.0 * d.p1 * x * y + d.p2 * (r2 + 2.0 * x * x),
          y * radial + d.p1 * (r2 + 2.0 * y * y) + 2.0 * d.p2 * x * y};
}

Matrix2d DistortionJacobian(const Distortion& d, const Vector2d& n) noexcept {
  if (d.none()) return Matrix2d::Identity();
  const double x = n.x();
  const double y = n.y();
  const double r2 = x * x + y * y;
  const double radial = 1.0 + r2 * (d.k1 + r2 * (d.k2 + r2 * d.k3));
  const double slope = 2.0 * (d.k1 + r2 * (2.0 * d.k2 + r2 * 3.0 * d.k3));  // d(radial)/d(r²) · 2
  Matrix2d J;
  J(0, 0) = radial + slope * x * x + 2.0 * d.p1 * y + 6.0 * d.p2 * x;
  J(0, 1) = slope * x * y + 2.0 * d.p1 * x + 2.0 * d.p2 * y;
  J(1, 0) = slope * x * y + 2.0 * d.p1 * x + 2.0 * d.p2 * y;
  J(1, 1) = radial + slope * y * y + 6.0 * d.p1 * y + 2.0 * d.p2 * x;
  return J;
}

}  // namespace

Matrix2d CalibrationJacobian(const CameraModel& camera) noexcept {
  Matrix2d K;
  K << camera.fx, camera.skew, 0.0, camera.fy;
  return K;
}

Vector2d ToUndistortedPixel(const CameraModel& camera, const Vector2d& n) noexcept {
  return CalibrationJacobian(camera) * n + Vector2d(camera.u0, camera.v0);
}

Vector2d FromUndistortedPixel(const CameraModel& camera, const Vector2d& pixel) noexcept {
  const double y = (pixel.y() - camera.v0) / camera.fy;
  return {(pixel.x() - camera.u0 - camera.skew * y) / camera.fx, y};
}

Vector2d ToPixel(const CameraModel& camera, const Vector2d& n) noexcept {
  return ToUndistortedPixel(camera, Distort(camera.distortion, n));
}

Vector2d ToNormalised(const CameraModel& camera, const Vector2d& pixel) noexcept {
  const Vector2d distorted = FromUndistortedPixel(camera, pixel);
  Vector2d n = distorted;
  if (camera.distortion.none()) return n;
  for (int i = 0; i < 20; ++i) {
    const Vector2d residual = Distort(camera.distortion, n) - distorted;
    if (residual.squaredNorm() < 1e-28) break;
    n -= DistortionJacobian(camera.distortion, n).inverse() * residual;
  }
  return n;
}

Matrix2d PixelJacobian(const CameraModel& camera, const Vector2d& n) noexcept {
  return CalibrationJacobian(camera) * DistortionJacobian(camera.distortion, n);
}

bool InImage(const CameraModel& camera, const Vector2d& pixel, double margin) noexcept {
  return pixel.x() >= margin && pixel.y() >= margin && pixel.x() <= camera.width - 1 - margin &&
         pixel.y() <= camera.height - 1 - margin;
}

}  // namespace vantage
