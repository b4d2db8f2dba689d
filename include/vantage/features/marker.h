#pragma once

#include <array>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "vantage/math/sizes.h"
#include "vantage/math/time.h"

namespace vantage {

/// Outer radius of a marker's ring, in radii of its disc.
inline constexpr double kRingRadii = 2.0;
/// Radius of the plate that a marker is drawn on, in radii of its disc: the ring ends on the plate, not on
/// whatever is behind it, and a quarter of the disc's radius is left as a rim.
inline constexpr double kPlateRadii = 2.25;

/// A round dot: a disc of `radius` inside a contrasting ring.
struct Marker {
  int id{0};                                   ///< Unique in a scenario; names it in messages.
  Eigen::Vector3d p{Eigen::Vector3d::Zero()};  ///< Centre, in the frame it is fixed to [m].
  Eigen::Vector3d normal{Eigen::Vector3d::UnitZ()};  ///< Unit; the side it is seen from.
  double radius{0.01};                               ///< [m]; > 0.
  bool dark{true};  ///< Dark disc on a bright ring, or the reverse.
};

/// Most markers one image reports: those of the arm and those of the goal.
inline constexpr int kMaxMarkers = 2 * kMaxPoints;

/// What a detector found of one marker.
struct MarkerMeasurement {
  int id{0};                                       ///< Marker::id of the marker sought.
  Eigen::Vector2d pixel{Eigen::Vector2d::Zero()};  ///< Centre [px], lens distortion removed.
  bool valid{false};                               ///< False: not seen in this image.
};

/// All markers of one image. Lens distortion is removed by whoever publishes them: the pixels obey
/// the camera's matrix alone.
struct ImageFeatures {
  Time stamp{};                                           ///< When the features were sent.
  Time exposure{};                                        ///< When the image was taken.
  Eigen::Isometry3d X_WC{Eigen::Isometry3d::Identity()};  ///< Measured camera pose at the exposure.
  int count{0};  ///< Entries of `markers` in use, seen or not.
  std::array<MarkerMeasurement, kMaxMarkers> markers{};  ///< The first `count` have a meaning.

  /// The measurement of a marker, or nullptr when the image does not name it.
  [[nodiscard]] const MarkerMeasurement* Find(int id) const noexcept {
    for (int i = 0; i < count; ++i) {
      if (markers[i].id == id) return &markers[i];
    }
    return nullptr;
  }
};

}  // namespace vantage
