#include "camera_video.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

#include "vantage/math/format.h"
#include "vantage/messaging/channels.h"
#include "vantage/messaging/event_log.h"

namespace vantage {
namespace {

constexpr double kTrail = 2.0;  // [s].
constexpr int kStrip =
    44;  // Height of the lines of text above the image, where no player puts its buttons [px].
constexpr int kFirstLine = 17, kSecondLine = 36;
constexpr double kDefaultRate = 10.0;

const cv::Scalar kSeen(60, 200, 60), kLost(60, 60, 230), kGoal(0, 150, 255), kText(235, 235, 235),
    kDim(150, 150, 150);

// Empty when the bytes are no picture.
cv::Mat ToMat(const CameraImage& image) {
  if (image.format == PixelFormat::kJpeg) {
    try {
      return cv::imdecode(image.data, cv::IMREAD_COLOR);
    } catch (const cv::Exception&) {
      return {};  // A size that OpenCV refuses.
    }
  }
  // OpenCV only reads it.
  auto* pixels = const_cast<std::uint8_t*>(image.data.data());
  const auto stride = static_cast<std::size_t>(image.row_stride);
  const bool grey = image.format == PixelFormat::kGray;
  const cv::Mat raw(image.height, image.width, grey ? CV_8UC1 : CV_8UC3, pixels, stride);
  cv::Mat bgr;
  cv::cvtColor(raw, bgr, grey ? cv::COLOR_GRAY2BGR : cv::COLOR_RGB2BGR);
  return bgr;
}

// Index of the last value that is not after `time`; -1: none.
template <typename Values, typename Stamp>
int LastBefore(const Values& values, Time time, Stamp&& stamp) {
  const auto after = std::upper_bound(values.begin(), values.end(), time,
                                      [&](Time t, const auto& value) { return t < stamp(value); });
  return static_cast<int>(after - values.begin()) - 1;
}

/// Draws what the log says of one instant over its image.
class Overlay {
 public:
  explicit Overlay(const RunLog& log) : log_(log) {}

  void Draw(Time stamp, cv::Mat* frame) {
    const double width = log_.scenario ? log_.scenario->task.view.camera.width : frame->cols;
    scale_ = frame->cols / width;
    const int newest =
        LastBefore(log_.features, stamp, [](const ImageFeatures& f) { return f.exposure; });
    if (newest >= 0) {
      Trails(newest, frame);
      Markers(log_.features[static_cast<std::size_t>(newest)], frame);
    }
    Strip(stamp, frame);
  }

 private:
  // In 1/16 of a pixel, as OpenCV takes it for smooth lines. The picture shows the lens's distortion, which
  // the features are free of.
  [[nodiscard]] cv::Point Place(const Eigen::Vector2d& pixel) const {
    Eigen::Vector2d seen = pixel;
    if (log_.scenario && !log_.scenario->task.view.camera.distortion.none()) {
      const CameraModel& camera = log_.scenario->task.view.camera;
      seen = ToPixel(camera, FromUndistortedPixel(camera, pixel));
    }
    return {static_cast<int>(std::lround(16 * ((seen.x() + 0.5) * scale_ - 0.5))),
            static_cast<int>(std::lround(16 * ((seen.y() + 0.5) * scale_ - 0.5)))};
  }

  void Trails(int newest, cv::Mat* frame) const {
    const Time now = log_.features[static_cast<std::size_t>(newest)].exposure;
    for (int i = newest; i > 0; --i) {
      const ImageFeatures& later = log_.features[static_cast<std::size_t>(i)];
      const ImageFeatures& earlier = log_.features[static_cast<std::size_t>(i) - 1];
      const double age = ToSeconds(now - earlier.exposure);
      if (age > kTrail) break;
      for (int k = 0; k < later.count; ++k) {
        const MarkerMeasurement& marker = later.markers[k];
        const MarkerMeasurement* before = earlier.Find(marker.id);
        if (!marker.valid || before == nullptr || !before->valid || log_.IsGoalMarker(marker.id))
          continue;
        const double strength = 1.0 - age / kTrail;
        cv::line(*frame, Place(before->pixel), Place(marker.pixel),
                 cv::Scalar(60 + 120 * strength, 160 + 60 * strength, 60), 1, cv::LINE_AA, 4);
      }
    }
  }

  void Markers(const ImageFeatures& image, cv::Mat* frame) {
    for (int i = 0; i < image.count; ++i) {
      const MarkerMeasurement& marker = image.markers[i];
      if (marker.valid) last_seen_[marker.id] = marker.pixel;
      const auto last = last_seen_.find(marker.id);
      if (last == last_seen_.end()) continue;
      const cv::Scalar colour =
          !marker.valid ? kLost : (log_.IsGoalMarker(marker.id) ? kGoal : kSeen);
      const cv::Point place = Place(last->second);
      cv::circle(*frame, place, 16 * 9, colour, 2, cv::LINE_AA, 4);
      cv::putText(*frame, std::to_string(marker.id), {place.x / 16 + 11, place.y / 16 - 7},
                  cv::FONT_HERSHEY_SIMPLEX, 0.4, colour, 1, cv::LINE_AA);
    }
  }

  void Strip(Time stamp, cv::Mat* frame) const {
    cv::copyMakeBorder(*frame, *frame, kStrip, 0, 0, 0, cv::BORDER_CONSTANT,
                       cv::Scalar(32, 28, 24));
    Write(frame, Format("%7.2f s", log_.At(stamp)), 8, kFirstLine, kText);
    const auto by_stamp = [](const auto& value) { return value.stamp; };
    const int status = LastBefore(log_.statuses, stamp, by_stamp);
    const int report = LastBefore(log_.observability, stamp, by_stamp);
    if (status >= 0) {
      const ServoStatus& s = log_.statuses[static_cast<std::size_t>(status)];
      std::string state = Name(s.state);
      if (s.reason != HoldReason::kNone) state += std::string(" ") + Name(s.reason);
      const bool holds = s.state == ServoState::kHolding || s.state == ServoState::kFault;
      Write(frame, state, 90, kFirstLine, holds ? kLost : kText);
      Write(frame, Format("error %.2f px", s.error_px), 8, kSecondLine, kDim);
    }
    if (report < 0) return;
    const ObservabilityReport& o = log_.observability[static_cast<std::size_t>(report)];
    std::string camera = std::string("camera ") + Name(o.active_state);
    if (o.active_state == ActiveState::kMoving) camera += std::string(" ") + Name(o.active_reason);
    Write(frame, camera, 150, kSecondLine, kDim);
    Gauge(o, frame);
  }

  // The trigger's measure as a bar, with a mark at the threshold, which stands in its middle.
  static void Gauge(const ObservabilityReport& o, cv::Mat* frame) {
    if (o.k == 0 || !(o.threshold > 0.0)) return;
    const int left = frame->cols - 190;
    constexpr int kLength = 180;
    const int filled =
        static_cast<int>(kLength * std::clamp(o.trigger_value / (2.0 * o.threshold), 0.0, 1.0));
    const bool low = o.trigger_value < o.threshold;
    Write(frame, Format("%.4g / %.4g", o.trigger_value, o.threshold), left, kFirstLine,
          low ? kGoal : kText);
    cv::rectangle(*frame, {left, 24, kLength, 8}, cv::Scalar(70, 65, 60), cv::FILLED);
    cv::rectangle(*frame, {left, 24, filled, 8}, low ? kGoal : kSeen, cv::FILLED);
    cv::line(*frame, {left + kLength / 2, 21}, {left + kLength / 2, 35}, kText, 1);
  }

  static void Write(cv::Mat* frame, const std::string& text, int x, int y,
                    const cv::Scalar& colour) {
    cv::putText(*frame, text, {x, y}, cv::FONT_HERSHEY_SIMPLEX, 0.45, colour, 1, cv::LINE_AA);
  }

  const RunLog& log_;
  double scale_{1.0};
  std::map<int, Eigen::Vector2d> last_seen_;
};

double FrameRate(const RunLog& log, const std::string& channel) {
  const auto traffic = log.channels.find(channel);
  const double rate = traffic == log.channels.end() ? 0.0 : traffic->second.rate();
  return rate > 0.1 ? std::min(rate, 120.0) : kDefaultRate;
}

bool Open(const std::string& path, double rate, const cv::Size& size, cv::VideoWriter* video) {
  // H.264 is what every browser plays; MPEG-4 where there is no encoder for it.
  for (const char* code : {"avc1", "mp4v"}) {
    if (video->open(path, cv::CAP_FFMPEG,
                    cv::VideoWriter::fourcc(code[0], code[1], code[2], code[3]), rate, size)) {
      return true;
    }
  }
  return false;
}

}  // namespace

bool WriteCameraVideo(const std::string& log_path, const std::string& prefix, const RunLog& log,
                      const std::string& path) {
  const std::string channel = prefix + kCameraImageChannel;
  Overlay overlay(log);
  cv::VideoWriter video;
  cv::Size size;
  EventLogReader events(log_path);
  for (LoggedEvent event; events.Next(&event);) {
    CameraImage image;
    if (event.channel != channel ||
        Decode(event.data.data(), event.data.size(), &image) != Refusal::kNone) {
      continue;
    }
    cv::Mat frame = ToMat(image);
    if (frame.empty()) continue;
    overlay.Draw(image.stamp, &frame);
    // Encoders want even sides.
    if (size.area() == 0) {
      size = {frame.cols & ~1, frame.rows & ~1};
      if (!Open(path, FrameRate(log, channel), size, &video)) {
        std::error_code ignored;
        std::filesystem::remove(path, ignored);
        return false;
      }
    }
    if (frame.size() != size) cv::resize(frame, frame, size);
    video.write(frame);
  }
  return size.area() > 0;
}

}  // namespace vantage
