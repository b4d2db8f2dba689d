#include "sim/grey_noise.h"

#include <algorithm>
#include <cmath>

namespace vantage::sim {
namespace {

constexpr std::size_t kTableSize =
    (1u << 20) - 3;  // odd: rows of an image do not fall in step with it
constexpr int kFraction = 16;

}  // namespace

GreyNoise::GreyNoise(double sigma, std::uint64_t seed) : random_(seed) {
  if (sigma <= 0.0) return;
  std::normal_distribution<double> normal(0.0, sigma * kFraction);
  table_.resize(kTableSize);
  for (std::int16_t& value : table_) {
    value = static_cast<std::int16_t>(std::lround(std::clamp(normal(random_), -4080.0, 4080.0)));
  }
}

void GreyNoise::Add(GreyImage* image, const std::vector<PixelWindow>& windows) {
  if (table_.empty()) return;
  const std::vector<PixelWindow> whole{{0, 0, image->width, image->height}};
  std::uniform_int_distribution<std::size_t> entry(0, kTableSize - 1);
  std::uniform_int_distribution<int> dither(0, kFraction - 1);
  for (const PixelWindow& wanted : windows.empty() ? whole : windows) {
    const PixelWindow window = Clip(wanted, image->width, image->height);
    std::size_t next = entry(random_);
    const int rounding = dither(random_);  // unbiased over images
    for (int v = window.v; v < window.v + window.height; ++v) {
      std::uint8_t* row = image->at(window.u, v);
      for (int i = 0; i < window.width; ++i) {
        const int value = (row[i] * kFraction + table_[next] + rounding) / kFraction;
        row[i] = static_cast<std::uint8_t>(std::clamp(value, 0, 255));
        next = next + 1 == kTableSize ? 0 : next + 1;
      }
    }
  }
}

}  // namespace vantage::sim
