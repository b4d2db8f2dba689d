#include "vantage/vision/camera_source.h"

#include <algorithm>
#include <filesystem>

#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

#include "vantage/math/error.h"

namespace vantage {
namespace {

enum class Kind { kDevice, kPipeline, kStream, kNamedPipe, kSequence, kFile };

Kind KindOf(const std::string& source) {
  const bool number =
      !source.empty() && source.size() <= 3 &&
      std::all_of(source.begin(), source.end(), [](char c) { return c >= '0' && c <= '9'; });
  if (number || source.rfind("/dev/", 0) == 0) return Kind::kDevice;
  if (source.find(" ! ") != std::string::npos) return Kind::kPipeline;
  if (source.find("://") != std::string::npos) return Kind::kStream;
  if (source.find('%') != std::string::npos) return Kind::kSequence;
  std::error_code error;
  return std::filesystem::is_fifo(source, error) ? Kind::kNamedPipe : Kind::kFile;
}

class Video : public CameraSource {
 public:
  Video(std::string source, const VideoOptions& options)
      : source_(std::move(source)), kind_(KindOf(source_)), options_(options) {
    std::error_code error;
    if (kind_ == Kind::kFile && !std::filesystem::exists(source_, error)) {
      throw ConfigError("", "source", "no such file: " + source_);
    }
    if (kind_ == Kind::kFile && std::filesystem::is_directory(source_, error)) {
      throw ConfigError(
          "", "source",
          source_ + " is a folder: name its images by a pattern, " + source_ + "/%05d.png");
    }
    if (!Open()) {
      std::string reason = "cannot open " + description();
      if (kind_ == Kind::kDevice) reason += " (unplugged, in use, or no permission: group video?)";
      if (kind_ == Kind::kPipeline) {
        reason += " (does it end in '! appsink', and is OpenCV built with GStreamer?)";
      }
      if (kind_ == Kind::kFile || kind_ == Kind::kNamedPipe)
        reason += " (a video that OpenCV's FFmpeg can read?)";
      if (kind_ == Kind::kSequence) reason += " (no image of that name pattern)";
      throw ConfigError("", "source", reason);
    }
  }

  GrabStatus Grab(GreyImage* image, Time* exposure) override {
    bool grabbed = false;
    try {
      // The stamp first: decoding takes its time.
      grabbed = capture_.grab();
      *exposure = Clock::now() - FromSeconds(options_.delay);
      grabbed = grabbed && capture_.retrieve(frame_) && !frame_.empty();
    } catch (const cv::Exception&) {
      grabbed = false;
    }
    if (!grabbed) {
      // Let go of it: a device that is held while it is plugged in again comes back under another name.
      capture_.release();
      return is_file() ? GrabStatus::kEndOfFile : GrabStatus::kNoImage;
    }
    image->Resize(frame_.cols, frame_.rows);
    cv::Mat grey(image->height, image->width, CV_8U, image->pixels.data());
    switch (frame_.type()) {
      case CV_8UC1:
        frame_.copyTo(grey);
        break;
      case CV_8UC3:
        cv::cvtColor(frame_, grey, cv::COLOR_BGR2GRAY);
        break;
      case CV_8UC4:
        cv::cvtColor(frame_, grey, cv::COLOR_BGRA2GRAY);
        break;
      case CV_16UC1:
        frame_.convertTo(grey, CV_8U, 1.0 / 256.0);
        break;
      default:
        throw Error(description() + " gives images of a kind that is not known: OpenCV type " +
                    std::to_string(frame_.type()));
    }
    return GrabStatus::kImage;
  }

  bool Reopen() override {
    capture_.release();
    return Open();
  }

  [[nodiscard]] bool is_file() const noexcept override {
    return kind_ == Kind::kFile || kind_ == Kind::kSequence;
  }
  [[nodiscard]] double nominal_rate() const noexcept override { return rate_; }
  [[nodiscard]] std::string description() const override {
    switch (kind_) {
      case Kind::kDevice:
        return "device " + source_;
      case Kind::kPipeline:
        return "pipeline '" + source_ + "'";
      case Kind::kStream:
        return "stream " + source_;
      case Kind::kNamedPipe:
        return "named pipe " + source_;
      case Kind::kSequence:
        return "image sequence " + source_;
      case Kind::kFile:
        return "file " + source_;
    }
    return source_;
  }

 private:
  bool Open() {
    try {
      switch (kind_) {
        case Kind::kDevice:
          if (source_[0] == '/') {
            capture_.open(source_, cv::CAP_V4L2);
          } else {
            capture_.open(std::stoi(source_), cv::CAP_V4L2);
          }
          if (options_.width > 0) capture_.set(cv::CAP_PROP_FRAME_WIDTH, options_.width);
          if (options_.height > 0) capture_.set(cv::CAP_PROP_FRAME_HEIGHT, options_.height);
          if (options_.rate > 0.0) capture_.set(cv::CAP_PROP_FPS, options_.rate);
          // Old images are of no use.
          capture_.set(cv::CAP_PROP_BUFFERSIZE, 1);
          break;
        case Kind::kPipeline:
          capture_.open(source_, cv::CAP_GSTREAMER);
          break;
        case Kind::kSequence:
          capture_.open(source_, cv::CAP_IMAGES);
          break;
        case Kind::kStream:
        case Kind::kNamedPipe:
        case Kind::kFile:
          capture_.open(source_);
          break;
      }
    } catch (const cv::Exception&) {
      return false;
    }
    if (!capture_.isOpened()) return false;
    const double rate = capture_.get(cv::CAP_PROP_FPS);
    rate_ = rate > 0.0 && rate < 10000.0 && kind_ != Kind::kSequence ? rate : 0.0;
    return true;
  }

  std::string source_;
  Kind kind_;
  VideoOptions options_;
  cv::VideoCapture capture_;
  cv::Mat frame_;
  double rate_{0.0};
};

}  // namespace

const char* Name(GrabStatus status) noexcept {
  switch (status) {
    case GrabStatus::kImage:
      return "IMAGE";
    case GrabStatus::kEndOfFile:
      return "END_OF_FILE";
    case GrabStatus::kNoImage:
      return "NO_IMAGE";
  }
  return "UNKNOWN";
}

std::unique_ptr<CameraSource> OpenVideo(const std::string& source, const VideoOptions& options) {
  return std::make_unique<Video>(source, options);
}

}  // namespace vantage
