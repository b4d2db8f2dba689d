#pragma once

#include <opencv2/core.hpp>

#include "vantage/messaging/camera_image.h"

namespace vantage {

/// A picture for people as a JPEG message.
/// @param bgr  8 bit, one (grey) or three channels (blue, green, red).
[[nodiscard]] CameraImage JpegMessage(const cv::Mat& bgr, Time stamp);

}  // namespace vantage
