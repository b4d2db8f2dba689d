#pragma once

#include <optional>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "vantage/camera/camera_model.h"
#include "vantage/features/marker.h"

/// @file
/// Images of round discs. A disc's image is an ellipse whose centre is not the image of the disc's
/// centre (0.1 px apart is common), so whoever measures the one and means the other must correct it.

namespace vantage {

/// What a camera sees of a disc.
struct DiscImage {
  /// Image of the disc's centre by the ideal lens (the pixel that ImageFeatures publish) [px].
  Eigen::Vector2d centre{Eigen::Vector2d::Zero()};
  /// Centroid of the disc's image in the real image, lens distortion included [px].
  Eigen::Vector2d centroid{Eigen::Vector2d::Zero()};
  /// Σ of its outline (p - centroid)ᵀ Σ⁻¹ (p - centroid) = 1 in the real image [px²]. Four times the
  /// second central moments of the area; exact without distortion.
  Eigen::Matrix2d shape{Eigen::Matrix2d::Identity()};
  double area{0.0};   ///< π √det Σ [px²].
  double depth{0.0};  ///< Z of the disc's centre in the camera frame [m].
  double cos_incidence{
      0.0};  ///< Cosine of the angle between normal and ray; > 0: seen from the front.
};

/// Image of a disc given in the camera's frame.
///
/// @param p_C       Centre [m].
/// @param normal_C  Unit normal.
/// @param radius    [m]; > 0.
/// @return nullopt when part of the disc is nearer than kMinDepth to the plane Cz = 0 or behind it, or
///   a value is not finite.
/// Real-time safe.
[[nodiscard]] std::optional<DiscImage> ProjectDisc(const CameraModel& camera,
                                                   const Eigen::Vector3d& p_C,
                                                   const Eigen::Vector3d& normal_C,
                                                   double radius) noexcept;

/// The same for a marker fixed to the frame F.
[[nodiscard]] std::optional<DiscImage> ProjectDisc(const CameraModel& camera,
                                                   const Eigen::Isometry3d& X_CF,
                                                   const Marker& marker) noexcept;

/// Semi-axes of an ellipse given by its Σ, the shorter first [px for px²]. Real-time safe.
[[nodiscard]] Eigen::Vector2d SemiAxes(const Eigen::Matrix2d& shape) noexcept;

/// Two unit vectors that make a right-handed frame (e1, e2, normal). Real-time safe.
struct PlaneAxes {
  Eigen::Vector3d e1;  ///< At right angles to the normal.
  Eigen::Vector3d e2;  ///< normal × e1.
};
/// Two unit vectors that span the plane with this normal.
[[nodiscard]] PlaneAxes AxesOfPlane(const Eigen::Vector3d& normal) noexcept;

/// A pixel as the ideal lens would have seen it: distortion removed [px]. Real-time safe.
[[nodiscard]] Eigen::Vector2d UndistortPixel(const CameraModel& camera,
                                             const Eigen::Vector2d& pixel) noexcept;

}  // namespace vantage
