#pragma once

#include <algorithm>
#include <vector>

#include <visp3/core/vpImage.h>

#include "vantage/vision/image.h"

namespace vantage {

/// Pixels as ViSP wants them: rows without gaps, not const. It does not write to them.
class VispImage {
 public:
  explicit VispImage(const GreyView& image) {
    const auto width = static_cast<unsigned>(image.width);
    const auto height = static_cast<unsigned>(image.height);
    auto* data = const_cast<unsigned char*>(image.data);
    if (image.stride != image.width) {
      packed_.resize(static_cast<std::size_t>(width) * height);
      for (int v = 0; v < image.height; ++v) {
        std::copy_n(image.row(v), width, packed_.data() + static_cast<std::size_t>(v) * width);
      }
      data = packed_.data();
    }
    image_.init(data, height, width, /*copyData=*/false);
  }
  [[nodiscard]] const vpImage<unsigned char>& get() const { return image_; }

 private:
  std::vector<unsigned char> packed_;
  vpImage<unsigned char> image_;
};

}  // namespace vantage
