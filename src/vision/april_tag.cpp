#include "vantage/vision/april_tag.h"

#include <string>

#include <visp3/core/vpImagePoint.h>
#include <visp3/detection/vpDetectorAprilTag.h>

#include "visp_image.h"

namespace vantage {
namespace {

using Eigen::Vector2d;

constexpr double kHalfPixel = 0.5;

}  // namespace

std::array<Vector2d, 4> TagCorners(double size) noexcept {
  const double h = 0.5 * size;
  return {Vector2d(-h, -h), Vector2d(h, -h), Vector2d(h, h), Vector2d(-h, h)};
}

std::vector<Marker> TagMarkers(const Tag& tag) {
  std::vector<Marker> markers;
  for (const Vector2d& corner : TagCorners(tag.size)) {
    Marker marker;
    marker.id = 4 * tag.id + static_cast<int>(markers.size());
    marker.p = tag.X_FT * Eigen::Vector3d(corner.x(), corner.y(), 0.0);
    marker.normal = tag.X_FT.linear().col(2);
    marker.radius = tag.size / 16.0;
    markers.push_back(marker);
  }
  return markers;
}

class TagDetector::Impl {
 public:
  Impl() : detector_(vpDetectorAprilTag::TAG_36h11) {
    detector_.setAprilTagQuadDecimate(1.0F);
    detector_.setAprilTagRefineEdges(true);
  }

  const std::vector<TagImage>& Find(const GreyView& image) {
    tags_.clear();
    const VispImage visp(image);
    if (!detector_.detect(visp.get())) return tags_;
    for (std::size_t i = 0; i < detector_.getNbObjects(); ++i) {
      const std::vector<vpImagePoint> polygon = detector_.getPolygon(i);
      // "36h11 id: 7".
      const std::string& message = detector_.getMessage(i);
      const std::size_t at = message.find("id: ");
      if (polygon.size() != 4 || at == std::string::npos) continue;
      TagImage tag;
      tag.id = std::stoi(message.substr(at + 4));
      for (std::size_t k = 0; k < 4; ++k) {
        tag.corners[k] << polygon[k].get_u() - kHalfPixel, polygon[k].get_v() - kHalfPixel;
      }
      tags_.push_back(tag);
    }
    return tags_;
  }

 private:
  vpDetectorAprilTag detector_;
  std::vector<TagImage> tags_;
};

TagDetector::TagDetector() : impl_(std::make_unique<Impl>()) {}
TagDetector::~TagDetector() = default;
TagDetector::TagDetector(TagDetector&&) noexcept = default;
TagDetector& TagDetector::operator=(TagDetector&&) noexcept = default;

const std::vector<TagImage>& TagDetector::Find(const GreyView& image) {
  return impl_->Find(image);
}

void TagDetector::Detect(const GreyView& image, const CameraModel& camera,
                         const std::vector<MarkerPrediction>& predictions,
                         const DetectorOptions& options, double max_shift,
                         MarkerDetections* detections) {
  const std::vector<TagImage>& tags = Find(image);
  detections->clear();
  for (const MarkerPrediction& prediction : predictions) {
    MarkerDetection detection;
    detection.id = prediction.id;
    detection.fault = prediction.expected ? MarkerFault::kNotFound : MarkerFault::kNotExpected;
    for (const TagImage& tag : tags) {
      if (!prediction.expected || tag.id != prediction.id / 4) continue;
      detection.centroid = tag.corners[static_cast<std::size_t>(prediction.id % 4)];
      detection.pixel = UndistortPixel(camera, detection.centroid);
      detection.area = prediction.image.area;
      detection.fault = MarkerFault::kNone;
      if (!InImage(camera, detection.centroid, options.disc.border)) {
        detection.fault = MarkerFault::kTouchesBorder;
      } else if ((detection.centroid - prediction.image.centre).norm() > max_shift) {
        detection.fault = MarkerFault::kWrongArea;
      }
    }
    detections->push_back(detection);
  }
}

}  // namespace vantage
