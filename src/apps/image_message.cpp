#include "image_message.h"

#include <opencv2/imgcodecs.hpp>

namespace vantage {
namespace {

constexpr int kJpegQuality = 85;

}  // namespace

CameraImage JpegMessage(const cv::Mat& bgr, Time stamp) {
  CameraImage message;
  message.stamp = stamp;
  message.width = bgr.cols;
  message.height = bgr.rows;
  message.format = PixelFormat::kJpeg;
  cv::imencode(".jpg", bgr, message.data, {cv::IMWRITE_JPEG_QUALITY, kJpegQuality});
  return message;
}

}  // namespace vantage
