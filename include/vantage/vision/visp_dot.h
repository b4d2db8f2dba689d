#pragma once

#include <vector>

#include "vantage/camera/camera_model.h"
#include "vantage/vision/image.h"
#include "vantage/vision/marker_detector.h"

namespace vantage {

/// DetectMarkers() through ViSP's vpDot2: for comparison, and for whoever trusts it more. It works on
/// thresholded pixels and looks at the outline only: some five times the error, seven times the time, and
/// it accepts discs that are partly hidden. The area gate of `options`
/// applies; its ring, ellipse and border gates are vpDot2's own.
///
/// @param detections  Replaced. Faults: kNotExpected, kNoContrast (vpDot2 found nothing) and kWrongArea.
void DetectWithVispDot(const GreyView& image, const CameraModel& camera,
                       const std::vector<MarkerPrediction>& predictions,
                       const DetectorOptions& options, MarkerDetections* detections);

}  // namespace vantage
