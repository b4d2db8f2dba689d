#pragma once

#include <Eigen/Core>

#include "vantage/vision/image.h"

/// @file
/// The pixel work of marker detection: one round dot measured from one pixel inside of it.

namespace vantage {

/// Why a marker was not measured, or its measurement not trusted.
enum class MarkerFault : int {
  kNone = 0,
  kNotExpected,    ///< By the model it is behind the camera, turned away or outside the image.
  kNoContrast,     ///< No edge of the right polarity round the pixel looked at.
  kTooSmall,       ///< Image too small to be measured.
  kTooLarge,       ///< Edges farther away than a disc's may be.
  kTouchesWindow,  ///< The blob runs out of the window searched.
  kTouchesBorder,  ///< The blob runs out of the image, or nearly.
  kNotElliptic,    ///< Area and moments are not an ellipse's: something covers it.
  kWeakRing,       ///< The ring is not whole: something covers it.
  kWrongArea,      ///< Area or shape not the predicted one.
  kAmbiguous,      ///< Two names fit the same dot, or two dots the same name.
  kNotFound,       ///< None of the dots found has this name.
};

/// Name as printed and logged: "TOUCHES_BORDER", ...
[[nodiscard]] const char* Name(MarkerFault fault) noexcept;

/// What counts as a whole disc.
struct DiscOptions {
  double min_contrast{40.0};    ///< Between disc and ring [grey levels]; > 0.
  double min_semi_axis{1.8};    ///< Shortest semi-axis of the disc's image [px].
  double max_semi_axis{120.0};  ///< Longest [px].
  double border{2.0};           ///< Least distance of the disc to the image border [px]; >= 1.
  /// Two ellipse tests on the moments: A / (4π √det cov) lies within `ellipse_tolerance + ellipse_slack /
  /// A` of 1, and the norm of the whitened third central moments is at most `skewness_tolerance +
  /// skewness_slack / A`. The first finds cuts on both sides, the second a cut on one: a disc that lost a
  /// hundredth of its area at one side has a skewness of about 0.02. The values leave room for grey
  /// noise up to 6 levels in 200 and blur up to 1.5 px.
  double ellipse_tolerance{0.004};
  double ellipse_slack{1.8};        ///< [px²].
  double skewness_tolerance{0.01};  ///< Bound for large discs [-].
  double skewness_slack{2.5};       ///< [px²].
  double ring_tolerance{0.3};  ///< Deviation of the ring's samples from their median, in contrasts.
};

/// A dot as measured in the real image.
struct DiscBlob {
  Eigen::Vector2d centroid{Eigen::Vector2d::Zero()};  ///< [px].
  Eigen::Matrix2d shape{Eigen::Matrix2d::Zero()};     ///< Σ of DiscImage [px²].
  double area{0.0};                                   ///< [px²].
  double contrast{0.0};                               ///< Between disc and ring [grey levels].
  double roundness{0.0};                              ///< A / (4π √det cov); 1 for an ellipse.
  double skewness{0.0};                         ///< Norm of whitened third moments; 0 likewise.
  PixelWindow bounds;                           ///< Of the disc, at half contrast.
  MarkerFault fault{MarkerFault::kNoContrast};  ///< kNone: the rest is good.
};

/// Measures the disc that holds the pixel (u, v).
///
/// Its levels are read along the row and the column through the pixel, the disc is filled at the level
/// half way, and its moments are sums of grey-weighted pixels, with weights cut off where they are noise.
/// Wide edges (blur) are allowed for in the second moments.
///
/// @param dark    Darker than its ring, or brighter.
/// @param window  Where the image may be read, clipped to it; a blob that leaves it is refused.
/// Real-time safe.
[[nodiscard]] DiscBlob MeasureDisc(const GreyView& image, const PixelWindow& window, int u, int v,
                                   bool dark, const DiscOptions& options) noexcept;

}  // namespace vantage
