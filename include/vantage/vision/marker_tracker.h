#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "vantage/math/time.h"
#include "vantage/vision/april_tag.h"
#include "vantage/vision/marker_detector.h"

namespace vantage {

/// Which detector measures the markers.
enum class DetectorKind {
  kDisc,     ///< DetectMarkers(): our own.
  kVispDot,  ///< ViSP's vpDot2; dots are named, and found anew, as by kDisc.
  kAprilTag,  ///< Corners of AprilTags through ViSP: see april_tag.h for their ids. Reads whole images.
};

/// Settings of a tracker.
struct TrackerOptions {
  DetectorKind kind{DetectorKind::kDisc};  ///< What measures the markers.
  DetectorOptions detector;                ///< For markers sought round their prediction.
  AcquisitionOptions acquisition;          ///< For searches of the whole image.
  double retry_interval{0.1};  ///< Least time between two searches of the whole image [s].
  /// A marker followed over two images is sought this near to its prediction [px]: small windows are what
  /// makes partial images cheap.
  double followed_margin{5.0};
  double memory{1.0};  ///< How long a lost marker's own offset is worth anything [s].
};

/// Follows markers from image to image: what the model predicts, corrected by how far it was off in
/// the image before. While a marker that should be seen is not, the whole image is searched now and then.
///
///   const SearchPlan plan = tracker.Plan(predictions, exposure);   // what of the image is needed
///   ... take the image ...
///   tracker.Track(view, predictions, exposure);                    // tracker.detections()
///
/// Plan() may be left out where whole images come anyway. Not thread-safe.
class MarkerTracker {
 public:
  /// For images of this camera.
  MarkerTracker(const CameraModel& camera, const TrackerOptions& options);

  /// What the next Track() will read.
  struct SearchPlan {
    bool whole_image{true};            ///< Markers are lost: windows are not enough.
    std::vector<PixelWindow> windows;  ///< Where whole_image is false.
  };
  /// Where in the next image to look.
  [[nodiscard]] const SearchPlan& Plan(const std::vector<MarkerPrediction>& predictions,
                                       Time exposure);

  /// Finds the markers in an image taken at `exposure`. Times must not decrease; after a step back the
  /// tracker starts anew.
  const MarkerDetections& Track(const GreyView& image,
                                const std::vector<MarkerPrediction>& predictions, Time exposure);

  [[nodiscard]] const MarkerDetections& detections() const noexcept { return detections_; }

  /// The last detections as a message's content; stamps and pose are the caller's.
  void Publish(ImageFeatures* features) const noexcept;

  /// Forgets all offsets.
  void Reset();

  /// Searches of the whole image so far.
  [[nodiscard]] std::int64_t acquisitions() const noexcept { return acquisitions_; }

 private:
  // How far the model is off for one marker.
  struct Track_ {
    int id{0};
    int group{0};
    bool seen{false};   // In the last image.
    bool known{false};  // The offset means something.
    bool followed{
        false};  // Seen in the last two images, near one another: the rate means something.
    Time last_seen{};
    Eigen::Vector2d offset{Eigen::Vector2d::Zero()};  // Measured less predicted centroid [px].
    Eigen::Vector2d rate{Eigen::Vector2d::Zero()};    // [px/s].
    double area_ratio{1.0};                           // Measured by predicted.
  };

  void Detect(const GreyView& image, bool whole_image, Time exposure);
  void Correct(const std::vector<MarkerPrediction>& predictions, Time exposure);
  [[nodiscard]] bool WantsWholeImage(Time exposure) const;
  void Learn(const std::vector<MarkerPrediction>& predictions, Time exposure);
  Track_* Find(int id);

  CameraModel camera_;
  TrackerOptions options_;
  std::optional<TagDetector> tags_;
  std::vector<Track_> tracks_;
  std::vector<MarkerPrediction> corrected_;
  MarkerDetections detections_;
  SearchPlan plan_;
  Time last_exposure_{Time::min()};
  Time last_acquisition_{Time::min()};
  std::int64_t acquisitions_{0};
};

}  // namespace vantage
