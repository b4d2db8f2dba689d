#pragma once

#include <limits>
#include <optional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "vantage/camera/camera_model.h"
#include "vantage/features/marker.h"
#include "vantage/math/sizes.h"
#include "vantage/vision/disc_blob.h"
#include "vantage/vision/disc_image.h"
#include "vantage/vision/image.h"

/// @file
/// Finds round markers in images, by name. Pure functions; MarkerTracker keeps the state.

namespace vantage {

/// Where the model expects a marker. Markers of one `group` (those on the arm; those of the goal) share
/// whatever error the model has, so they are found together.
struct MarkerPrediction {
  int id{0};             ///< Marker::id.
  int group{0};          ///< MarkerGroup, or the caller's own numbers.
  bool dark{true};       ///< Dark disc on a bright ring, or the reverse.
  bool expected{false};  ///< False: by the model the camera cannot see it now.
  /// The disc is not farther from here than this, and not than DetectorOptions::search_margin [px].
  double uncertainty{std::numeric_limits<double>::infinity()};
  DiscImage image;  ///< Of the disc; not filled in when the marker is behind the camera.
};

/// Prediction for a marker fixed to F. `expected` is set when its disc faces the camera (angle between
/// normal and ray below `max_incidence` [rad]) and its centroid lies in the image. Real-time safe.
[[nodiscard]] MarkerPrediction PredictMarker(const CameraModel& camera,
                                             const Eigen::Isometry3d& X_CF, const Marker& marker,
                                             int group, double max_incidence = 1.4) noexcept;

/// Groups of markers in predictions: the arm's markers share the errors of arm and camera, the goal's those
/// of the camera and the prior.
enum MarkerGroup : int { kToolGroup = 0, kGoalGroup = 1 };

/// Predictions for the markers of a cell: the end effector's, then the goal's.
///
/// @param X_CW, X_CE    World and end effector in the camera's frame.
/// @param predictions   Replaced; its capacity is kept.
void PredictMarkers(const CameraModel& camera, const Eigen::Isometry3d& X_CW,
                    const Eigen::Isometry3d& X_CE, const std::vector<Marker>& tool_markers,
                    const std::vector<Marker>& goal_markers,
                    std::vector<MarkerPrediction>* predictions);

/// Settings of a detection.
struct DetectorOptions {
  DiscOptions disc;             ///< What counts as a whole disc.
  double search_margin{12.0};   ///< A disc may be this far from its prediction [px].
  double area_tolerance{0.05};  ///< Relative deviation from the predicted area...
  double area_slack{3.0};       ///< ... plus this, divided by the area [px²].
  double min_spacing{3.0};      ///< Two markers are never nearer to one another [px].
};

/// What became of one prediction.
struct MarkerDetection {
  int id{0};                                          ///< Of the prediction.
  MarkerFault fault{MarkerFault::kNotFound};          ///< kNone: found, and trusted.
  Eigen::Vector2d centroid{Eigen::Vector2d::Zero()};  ///< Of the disc's image, as measured [px].
  Eigen::Vector2d pixel{Eigen::Vector2d::Zero()};     ///< To be published: see PublishedPixel().
  double area{0.0};                                   ///< [px²].

  [[nodiscard]] bool valid() const noexcept { return fault == MarkerFault::kNone; }
};

/// At most one detection for each prediction, in the same order.
using MarkerDetections = std::vector<MarkerDetection>;

/// The image of the marker's centre by the ideal lens: the measured centroid with the distortion
/// removed, plus the predicted distance of the projected centre from the centroid [px].
[[nodiscard]] Eigen::Vector2d PublishedPixel(const CameraModel& camera, const DiscImage& predicted,
                                             const Eigen::Vector2d& centroid) noexcept;

/// The part of the image that DetectMarkers() reads for a prediction (ring and margin).
[[nodiscard]] PixelWindow SearchWindow(const MarkerPrediction& prediction,
                                       const DetectorOptions& options) noexcept;

/// Looks for each expected marker round its predicted place and nowhere else.
///
/// @param detections  Replaced; its capacity is kept.
/// Real-time safe once *detections has the capacity.
void DetectMarkers(const GreyView& image, const CameraModel& camera,
                   const std::vector<MarkerPrediction>& predictions, const DetectorOptions& options,
                   MarkerDetections* detections);

/// How discs of the whole image are given names.
struct AcquisitionOptions {
  double max_shift{150.0};     ///< A group may be shifted this far from its predictions [px].
  double max_turn{0.5};        ///< ... turned in the image by this angle [rad] ...
  double max_scale{1.35};      ///< ... and scaled by this factor, or its inverse; > 1.
  double gate{6.0};            ///< Distance left to each marker after that [px].
  double area_tolerance{0.8};  ///< Relative deviation of a dot's area, or its inverse.
};

/// All dots of the image, wherever they are.
/// @param least_semi_axis  Shorter semi-axis of the smallest dot sought: the search steps by 1.1 of it [px].
[[nodiscard]] std::vector<DiscBlob> FindDiscs(const GreyView& image, bool dark,
                                              double least_semi_axis, const DiscOptions& options);

/// Looks for all predicted markers in the whole image, but for those that turn away from the camera or
/// are farther from the image than the largest shift. Dots get their names by the similarity
/// transform (shift, turn, scale, within bounds) that brings most predictions of a group onto dots of
/// their polarity and size, one to one. When two different namings fit about equally well, neither is
/// taken (kAmbiguous).
[[nodiscard]] MarkerDetections AcquireMarkers(const GreyView& image, const CameraModel& camera,
                                              const std::vector<MarkerPrediction>& predictions,
                                              const DetectorOptions& options,
                                              const AcquisitionOptions& acquisition);

/// Names dots by AcquireMarkers()' rule, the group that fits best first. Predictions with no area are left
/// out. Entry i: index into `blobs` of prediction i, -1 when none, -2
/// when ambiguous.
/// @param blob_dark  Polarity of each blob.
[[nodiscard]] std::vector<int> NameDiscs(const std::vector<MarkerPrediction>& predictions,
                                         const std::vector<DiscBlob>& blobs,
                                         const std::vector<bool>& blob_dark,
                                         const AcquisitionOptions& acquisition);

}  // namespace vantage
