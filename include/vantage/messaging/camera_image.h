#pragma once

#include <cstdint>
#include <vector>

#include "vantage/math/time.h"

namespace vantage {

enum class PixelFormat {
  kGray,  ///< 8 bit grey.
  kRgb,   ///< 8 bit red, green, blue.
  kJpeg,  ///< A JPEG file; row_stride is 0.
};

/// One camera frame for people: content of the CAMERA_IMAGE channel.
struct CameraImage {
  Time stamp{};                            ///< When the image was taken.
  int width{0};                            ///< [px].
  int height{0};                           ///< [px].
  int row_stride{0};                       ///< Distance of two rows in data [byte].
  PixelFormat format{PixelFormat::kGray};  ///< What the bytes of `data` are.
  std::vector<std::uint8_t> data;          ///< Rows from top to bottom, or one JPEG file.
};

}  // namespace vantage
