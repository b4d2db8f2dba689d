#pragma once

#include <vector>

#include "vantage/vision/marker_detector.h"
#include "vantage/vision/visp_dot.h"

/// @file
/// The detectors that bench_vision sets side by side, with one signature.

namespace vantage::bench {

using Detector = void (*)(const GreyView&, const CameraModel&, const std::vector<MarkerPrediction>&,
                          MarkerDetections*);

void DetectOurs(const GreyView& image, const CameraModel& camera,
                const std::vector<MarkerPrediction>& predictions, MarkerDetections* detections);

/// ViSP's vpDot2.
void DetectVisp(const GreyView& image, const CameraModel& camera,
                const std::vector<MarkerPrediction>& predictions, MarkerDetections* detections);

/// The usual way with OpenCV: Otsu's threshold in the marker's window, contours, the moments of the one
/// whose size is nearest to the prediction.
void DetectOpenCv(const GreyView& image, const CameraModel& camera,
                  const std::vector<MarkerPrediction>& predictions, MarkerDetections* detections);

struct NamedDetector {
  const char* name;
  Detector detect;
  bool needs_start;  ///< Must be told of a pixel inside the dot.
};
inline constexpr NamedDetector kDetectors[] = {
    {"ours", DetectOurs, false}, {"vpDot2", DetectVisp, true}, {"opencv", DetectOpenCv, false}};

}  // namespace vantage::bench
