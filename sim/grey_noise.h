#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include "vantage/vision/image.h"

namespace vantage::sim {

/// Gaussian noise of a camera chip, added to grey images. Drawn once from a table of seeded normal
/// numbers that each image enters at a random place: fast, and the same for the same seed.
class GreyNoise {
 public:
  /// @param sigma  Standard deviation [grey levels]; 0: none.
  GreyNoise(double sigma, std::uint64_t seed);

  /// Adds noise to the whole image, or inside the windows (clipped to the image).
  void Add(GreyImage* image, const std::vector<PixelWindow>& windows = {});

 private:
  std::mt19937_64 random_;
  std::vector<std::int16_t> table_;  // sixteenths of a grey level
};

}  // namespace vantage::sim
