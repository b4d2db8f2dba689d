#include "vantage/vision/visp_dot.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <visp3/blob/vpDot2.h>
#include <visp3/core/vpException.h>

#include "vantage/math/angles.h"
#include "visp_image.h"

namespace vantage {

void DetectWithVispDot(const GreyView& image, const CameraModel& camera,
                       const std::vector<MarkerPrediction>& predictions,
                       const DetectorOptions& options, MarkerDetections* detections) {
  detections->clear();
  const VispImage visp(image);
  for (const MarkerPrediction& prediction : predictions) {
    MarkerDetection detection;
    detection.id = prediction.id;
    detection.fault = MarkerFault::kNotExpected;
    if (prediction.expected) {
      const Eigen::Vector2d& start = prediction.image.centroid;
      try {
        vpDot2 dot;
        dot.initTracking(visp.get(), vpImagePoint(start.y(), start.x()));
        detection.centroid << dot.getCog().get_u(), dot.getCog().get_v();
        // Its area is that of the polygon through the centres of the outline's pixels: half of each of
        // them lies outside.
        detection.area = dot.getArea() + std::sqrt(kPi * dot.getArea()) + 1.0;
        detection.fault = MarkerFault::kNone;
        const double deviation = std::abs(detection.area / prediction.image.area - 1.0);
        // Counted pixels are off by a part of the outline.
        const double slack = options.area_slack + std::sqrt(prediction.image.area);
        if (deviation > options.area_tolerance + slack / prediction.image.area) {
          detection.fault = MarkerFault::kWrongArea;
        }
        detection.pixel = PublishedPixel(camera, prediction.image, detection.centroid);
      } catch (const vpException&) {  // Its way to say that there is no dot.
        detection.fault = MarkerFault::kNoContrast;
      }
    }
    detections->push_back(detection);
  }
}

}  // namespace vantage
