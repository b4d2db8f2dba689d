#include "vantage/vision/disc_image.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "vantage/camera/pinhole.h"
#include "vantage/math/angles.h"

namespace vantage {
namespace {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// Moments of the disc's image through a bent lens, by a cubature over the undistorted ellipse that is
// exact for polynomials of degree 5 (Radon's seven points): lenses bend so little over one disc that
// what is left out is far below a thousandth of a pixel.
void BendImage(const CameraModel& camera, const Vector2d& n_centre, const Matrix2d& n_shape,
               DiscImage* image) noexcept {
  const Matrix2d root = n_shape.llt().matrixL();
  const double radius = std::sqrt(2.0 / 3.0);
  std::array<Vector2d, 7> pixels;
  std::array<double, 7> weights{};
  for (int i = 0; i < 7; ++i) {
    const double angle = kPi / 3.0 * i;
    const Vector2d unit = i == 6 ? Vector2d::Zero().eval()
                                 : Vector2d(radius * std::cos(angle), radius * std::sin(angle));
    const Vector2d n = n_centre + root * unit;
    pixels[i] = ToPixel(camera, n);
    weights[i] = (i == 6 ? 0.25 : 0.125) * std::abs(PixelJacobian(camera, n).determinant());
  }
  double total = 0.0;
  Vector2d mean = Vector2d::Zero();
  for (int i = 0; i < 7; ++i) {
    total += weights[i];
    mean += weights[i] * pixels[i];
  }
  mean /= total;
  Matrix2d moments = Matrix2d::Zero();
  for (int i = 0; i < 7; ++i) {
    moments += weights[i] / total * (pixels[i] - mean) * (pixels[i] - mean).transpose();
  }
  image->centroid = mean;
  image->shape = 4.0 * moments;
  image->area = total * kPi * root.determinant();
}

}  // namespace

Vector2d SemiAxes(const Matrix2d& shape) noexcept {
  const double mean = 0.5 * shape.trace();
  const double half = std::sqrt(std::max(0.0, mean * mean - shape.determinant()));
  return {std::sqrt(std::max(0.0, mean - half)), std::sqrt(mean + half)};
}

PlaneAxes AxesOfPlane(const Vector3d& normal) noexcept {
  const Vector3d e1 = normal.unitOrthogonal();
  return {e1, normal.cross(e1)};
}

Vector2d UndistortPixel(const CameraModel& camera, const Vector2d& pixel) noexcept {
  if (camera.distortion.none()) return pixel;
  return ToUndistortedPixel(camera, ToNormalised(camera, pixel));
}

std::optional<DiscImage> ProjectDisc(const CameraModel& camera, const Vector3d& p_C,
                                     const Vector3d& normal_C, double radius) noexcept {
  if (!p_C.allFinite() || !normal_C.allFinite()) return std::nullopt;
  const PlaneAxes axes = AxesOfPlane(normal_C);
  // Nearest point of the rim to the camera's plane.
  const double reach = radius * std::hypot(axes.e1.z(), axes.e2.z());
  if (!(p_C.z() - reach >= kMinDepth)) return std::nullopt;

  // (s, t, 1) in the disc's plane, in units of its radius, to homogeneous normalised coordinates.
  Matrix3d H;
  H << radius * axes.e1, radius * axes.e2, p_C;
  // Dual conic of the rim's image.
  const Matrix3d dual = H * Vector3d(1.0, 1.0, -1.0).asDiagonal() * H.transpose();
  const Vector2d n_centre = dual.topRightCorner<2, 1>() / dual(2, 2);
  const Matrix2d n_shape =
      n_centre * n_centre.transpose() - dual.topLeftCorner<2, 2>() / dual(2, 2);

  DiscImage image;
  const Matrix2d K = CalibrationJacobian(camera);
  image.centre = ToUndistortedPixel(camera, p_C.head<2>() / p_C.z());
  image.depth = p_C.z();
  image.cos_incidence = -normal_C.dot(p_C.normalized());
  image.centroid = ToUndistortedPixel(camera, n_centre);
  image.shape = K * n_shape * K.transpose();
  image.area = kPi * std::sqrt(std::max(0.0, image.shape.determinant()));
  if (!camera.distortion.none()) BendImage(camera, n_centre, n_shape, &image);
  return image;
}

std::optional<DiscImage> ProjectDisc(const CameraModel& camera, const Eigen::Isometry3d& X_CF,
                                     const Marker& marker) noexcept {
  return ProjectDisc(camera, X_CF * marker.p, X_CF.linear() * marker.normal, marker.radius);
}

}  // namespace vantage
