#pragma once

#include <string>

#include "run_log.h"

namespace vantage {

/// Writes the log's CAMERA_IMAGE messages as a video (MP4, H.264 where the system's OpenCV can, so that
/// browsers play it): over each image the newest features that were not exposed after it, their paths of the last
/// seconds, and what the servo says.
///
/// @param log  What ReadRunLog() gave for the same file.
/// @return false, with no file written, when the log holds no image that can be read or this OpenCV can write
///   no video.
/// Throws Error when the log cannot be read.
bool WriteCameraVideo(const std::string& log_path, const std::string& prefix, const RunLog& log,
                      const std::string& path);

}  // namespace vantage
