#pragma once

#include <memory>
#include <string>

#include "vantage/math/time.h"
#include "vantage/vision/image.h"

/// @file
/// Where images come from. A seam: whoever has a camera of his own implements CameraSource.

namespace vantage {

/// What became of one attempt to take an image.
enum class GrabStatus {
  kImage,      ///< There is one.
  kEndOfFile,  ///< The file or sequence has no more.
  kNoImage,    ///< The device gave none: unplugged, or a stream that broke off.
};

/// Name as printed: "IMAGE", "END_OF_FILE", "NO_IMAGE".
[[nodiscard]] const char* Name(GrabStatus status) noexcept;

/// A camera, or what plays one. Used by one thread at a time.
class CameraSource {
 public:
  CameraSource() = default;
  CameraSource(const CameraSource&) = delete;
  CameraSource& operator=(const CameraSource&) = delete;
  virtual ~CameraSource() = default;

  /// Waits for the next image.
  /// @param image     Grey; its memory is kept between calls.
  /// @param exposure  When it was taken, by the monotonic clock.
  /// Throws Error when the device gives pixels of a kind that is not known.
  [[nodiscard]] virtual GrabStatus Grab(GreyImage* image, Time* exposure) = 0;

  /// Closes and opens it again, for a device that was unplugged. False when that fails.
  [[nodiscard]] virtual bool Reopen() = 0;

  [[nodiscard]] virtual bool is_file() const noexcept = 0;
  /// Images per second as the source itself says; 0: it does not.
  [[nodiscard]] virtual double nominal_rate() const noexcept = 0;
  /// What it is, for messages: "device 0", "file a.avi", ...
  [[nodiscard]] virtual std::string description() const = 0;
};

/// What is asked of a camera.
struct VideoOptions {
  int width{0};      ///< Columns asked of a device [px]; 0: as it likes.
  int height{0};     ///< Rows asked of a device [px]; 0: as it likes.
  double rate{0.0};  ///< Rate asked of a device [1/s]; 0: as it likes.
  /// Exposures lie this much before an image arrives, for the delay that the device adds [s]; >= 0.
  double delay{0.0};
};

/// A camera or a recording through OpenCV's VideoCapture:
/// - "0", "1", ...: a device by its number, "/dev/video0" by its name;
/// - "rtsp://..." and other addresses with "://": a stream;
/// - text with " ! ": a GStreamer pipeline that ends in "! appsink";
/// - a name with "%": a sequence of images, "frames/%05d.png";
/// - a named pipe: a live video that another program writes to it;
/// - anything else: a video file.
///
/// Throws ConfigError (key "source") when it cannot be opened. A named pipe is waited for until it has a
/// writer.
[[nodiscard]] std::unique_ptr<CameraSource> OpenVideo(const std::string& source,
                                                      const VideoOptions& options = {});

}  // namespace vantage
