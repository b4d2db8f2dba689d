#include "vision_detectors.h"

#include <opencv2/imgproc.hpp>

namespace vantage::bench {

void DetectOurs(const GreyView& image, const CameraModel& camera,
                const std::vector<MarkerPrediction>& predictions, MarkerDetections* detections) {
  DetectMarkers(image, camera, predictions, {}, detections);
}

void DetectVisp(const GreyView& image, const CameraModel& camera,
                const std::vector<MarkerPrediction>& predictions, MarkerDetections* detections) {
  DetectWithVispDot(image, camera, predictions, {}, detections);
}

void DetectOpenCv(const GreyView& image, const CameraModel& camera,
                  const std::vector<MarkerPrediction>& predictions, MarkerDetections* detections) {
  const cv::Mat whole(image.height, image.width, CV_8U, const_cast<std::uint8_t*>(image.data),
                      static_cast<std::size_t>(image.stride));
  detections->clear();
  cv::Mat binary;
  std::vector<std::vector<cv::Point>> contours;
  for (const MarkerPrediction& prediction : predictions) {
    const PixelWindow w = Clip(SearchWindow(prediction, {}), image.width, image.height);
    cv::threshold(whole(cv::Rect(w.u, w.v, w.width, w.height)), binary, 0, 255,
                  (prediction.dark ? cv::THRESH_BINARY_INV : cv::THRESH_BINARY) | cv::THRESH_OTSU);
    cv::findContours(binary, contours, cv::RETR_LIST, cv::CHAIN_APPROX_NONE);
    MarkerDetection detection;
    detection.id = prediction.id;
    double best = 0.3 * prediction.image.area;
    for (const auto& contour : contours) {
      const cv::Moments m = cv::moments(contour);
      if (std::abs(m.m00 - prediction.image.area) >= best) continue;
      best = std::abs(m.m00 - prediction.image.area);
      detection.fault = MarkerFault::kNone;
      detection.centroid << w.u + m.m10 / m.m00, w.v + m.m01 / m.m00;
      detection.pixel = PublishedPixel(camera, prediction.image, detection.centroid);
    }
    detections->push_back(detection);
  }
}

}  // namespace vantage::bench
