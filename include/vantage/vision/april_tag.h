#pragma once

#include <array>
#include <memory>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "vantage/camera/camera_model.h"
#include "vantage/features/marker.h"
#include "vantage/vision/image.h"
#include "vantage/vision/marker_detector.h"

/// @file
/// AprilTags of the family 36h11 as markers, found by ViSP's detector: for cells that have tags already.
/// The four corners of tag t are the markers 4 t to 4 t + 3, in the order of TagCorners().

namespace vantage {

/// Corners of a tag's black square of edge `size` in the tag's own frame: x to the right and y up as the
/// tag is printed, seen from its front; from the lower left one on, against the clock [m].
[[nodiscard]] std::array<Eigen::Vector2d, 4> TagCorners(double size) noexcept;

/// A tag glued on something.
struct Tag {
  int id{0};  ///< As printed; 0 to kMaxTagId.
  Eigen::Isometry3d X_FT{
      Eigen::Isometry3d::Identity()};  ///< Tag frame T in the frame it is fixed to.
  double size{0.06};                   ///< Edge of the black square [m]; > 0.
};

/// Greatest id of a tag of the family.
inline constexpr int kMaxTagId = 586;

/// Its corners as markers. Their radius is what has to be seen round a corner: a sixteenth of the edge.
[[nodiscard]] std::vector<Marker> TagMarkers(const Tag& tag);

/// A tag found in an image.
struct TagImage {
  int id{0};                               ///< As decoded; 0 to kMaxTagId.
  std::array<Eigen::Vector2d, 4> corners;  ///< In the order of TagCorners() [px].
};

/// Finds AprilTags (36h11) by ViSP. Not real-time safe. Not copyable.
class TagDetector {
 public:
  TagDetector();
  ~TagDetector();
  TagDetector(TagDetector&&) noexcept;
  TagDetector& operator=(TagDetector&&) noexcept;

  /// All tags of the image. ViSP counts pixels from the upper left pixel's corner here, unlike elsewhere;
  /// the half pixel is taken off.
  [[nodiscard]] const std::vector<TagImage>& Find(const GreyView& image);

  /// Find(), and each prediction's corner by its name. Faults: kNotExpected, kNotFound, kTouchesBorder
  /// (within `options.disc.border` of it) and kWrongArea (farther than `max_shift` [px] from its
  /// prediction: a tag of another cell).
  void Detect(const GreyView& image, const CameraModel& camera,
              const std::vector<MarkerPrediction>& predictions, const DetectorOptions& options,
              double max_shift, MarkerDetections* detections);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace vantage
