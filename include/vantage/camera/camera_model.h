#pragma once

#include <Eigen/Core>

/// @file
/// Intrinsic camera model: normalised coordinates n = (X/Z, Y/Z) to pixels p = (u, v) and back.
/// Pixel (0, 0) is the CENTRE of the upper left pixel, u to the right, v down.

namespace vantage {

/// Radial-tangential lens distortion in OpenCV's order (k1, k2, p1, p2, k3) [-]. All zero: none.
struct Distortion {
  double k1{0.0};  ///< Radial, of r² [-].
  double k2{0.0};  ///< Radial, of r⁴ [-].
  double p1{0.0};  ///< Tangential, of 2 x y in x_d [-].
  double p2{0.0};  ///< Tangential, of r² + 2 x² in x_d [-].
  double k3{0.0};  ///< Radial, of r⁶ [-].
  [[nodiscard]] bool none() const noexcept {
    return k1 == 0.0 && k2 == 0.0 && p1 == 0.0 && p2 == 0.0 && k3 == 0.0;
  }
};

/// Intrinsics of one camera: u = fx x_d + skew y_d + u0, v = fy y_d + v0, with (x_d, y_d) the
/// distorted normalised coordinates.
struct CameraModel {
  double fx{600.0};       ///< Focal length along u [px]; > 0.
  double fy{600.0};       ///< Focal length along v [px]; > 0.
  double u0{319.5};       ///< Column of the principal point [px].
  double v0{239.5};       ///< Row of the principal point [px].
  double skew{0.0};       ///< Shift of u by a unit of y_d [px].
  Distortion distortion;  ///< Of the lens; none by default.
  int width{640};         ///< Columns of the image [px]; > 0.
  int height{480};        ///< Rows of the image [px]; > 0.
};

/// Image of normalised coordinates n, distortion included [px].
[[nodiscard]] Eigen::Vector2d ToPixel(const CameraModel& camera, const Eigen::Vector2d& n) noexcept;

/// Normalised coordinates of a pixel, distortion removed by Newton's method (to 1e-12 for any lens whose
/// distortion is invertible over the image) [-].
[[nodiscard]] Eigen::Vector2d ToNormalised(const CameraModel& camera,
                                           const Eigen::Vector2d& pixel) noexcept;

/// Where normalised coordinates n would fall without the lens' distortion: the undistorted pixel
/// CalibrationJacobian() n + (u0, v0) [px]. What markers are measured as.
[[nodiscard]] Eigen::Vector2d ToUndistortedPixel(const CameraModel& camera,
                                                 const Eigen::Vector2d& n) noexcept;

/// Its inverse: normalised coordinates of an undistorted pixel [-].
[[nodiscard]] Eigen::Vector2d FromUndistortedPixel(const CameraModel& camera,
                                                   const Eigen::Vector2d& pixel) noexcept;

/// ∂(u, v)/∂n at n [px].
[[nodiscard]] Eigen::Matrix2d PixelJacobian(const CameraModel& camera,
                                            const Eigen::Vector2d& n) noexcept;

/// The same, of the ideal lens: what undistorted pixels obey [px].
[[nodiscard]] Eigen::Matrix2d CalibrationJacobian(const CameraModel& camera) noexcept;

/// True when the pixel lies at least `margin` [px] inside the image.
[[nodiscard]] bool InImage(const CameraModel& camera, const Eigen::Vector2d& pixel,
                           double margin = 0.0) noexcept;

}  // namespace vantage
