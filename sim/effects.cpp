#include "sim/effects.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include <opencv2/imgproc.hpp>

#include "vantage/math/error.h"

namespace vantage::sim {
namespace {

constexpr int kFraction = 16;
constexpr std::size_t kTableSize = std::size_t{1} << 18U;

// A well mixed number from a key (the finaliser of splitmix64).
std::uint64_t Mix(std::uint64_t key) {
  key = (key ^ (key >> 30U)) * 0xbf58476d1ce4e5b9U;
  key = (key ^ (key >> 27U)) * 0x94d049bb133111ebU;
  return key ^ (key >> 31U);
}

void Require(bool condition, const char* key, const std::string& bound, double value) {
  if (condition) return;
  throw ConfigError("", std::string("camera.effects.") + key,
                    "must be " + bound + ", is " + std::to_string(value));
}

}  // namespace

EffectChain::EffectChain(const ImageEffects& effects, std::uint64_t seed)
    : effects_(effects), random_(seed) {
  Require(effects.noise >= 0.0 && effects.noise <= 100.0, "noise", "in [0, 100] grey levels",
          effects.noise);
  Require(effects.blur >= 0.0 && effects.blur <= 10.0, "blur", "in [0, 10] px", effects.blur);
  Require(effects.gain_step >= 0.0 && effects.gain_step <= 1.0, "gain_step", "in [0, 1]",
          effects.gain_step);
  Require(effects.gain_period > 0.0, "gain_period", "> 0 s", effects.gain_period);
  if (effects.noise <= 0.0) return;
  std::normal_distribution<double> normal(0.0, effects.noise * kFraction);
  noise_.resize(kTableSize);
  for (std::int16_t& value : noise_) {
    value = static_cast<std::int16_t>(std::lround(std::clamp(normal(random_), -4080.0, 4080.0)));
  }
}

int EffectChain::margin() const noexcept {
  return effects_.blur > 0.0 ? static_cast<int>(std::ceil(4.0 * effects_.blur)) : 0;
}

void EffectChain::Begin(Time exposure) {
  image_key_ = random_();
  if (effects_.gain_step <= 0.0) return;
  std::exponential_distribution<double> wait(1.0 / effects_.gain_period);
  if (!started_) next_jump_ = exposure + FromSeconds(wait(random_));
  started_ = true;
  std::uniform_real_distribution<double> step(-effects_.gain_step, effects_.gain_step);
  while (next_jump_ <= exposure) {
    gain_ = std::exp(step(random_));
    next_jump_ += FromSeconds(wait(random_));
  }
}

void EffectChain::Apply(GreyImage* image) {
  Apply({{0, 0, image->width, image->height}}, image);
}

void EffectChain::Apply(const std::vector<PixelWindow>& windows, GreyImage* image) {
  // No pixel twice.
  const std::vector<PixelWindow> apart = MergeOverlapping(windows, image->width, image->height);
  if (effects_.blur > 0.0) {
    // All of the blur is computed before any of it is written: windows may lie near one another.
    const cv::Mat sharp(image->height, image->width, CV_8U, image->pixels.data());
    const int reach = margin();
    std::vector<cv::Mat> blurred;
    for (const PixelWindow& window : apart) {
      const PixelWindow around = Clip(
          {window.u - reach, window.v - reach, window.width + 2 * reach, window.height + 2 * reach},
          image->width, image->height);
      cv::Mat wide;
      cv::GaussianBlur(sharp(cv::Rect(around.u, around.v, around.width, around.height)), wide,
                       cv::Size(2 * reach + 1, 2 * reach + 1), effects_.blur, effects_.blur,
                       cv::BORDER_REPLICATE | cv::BORDER_ISOLATED);
      blurred.push_back(
          wide(cv::Rect(window.u - around.u, window.v - around.v, window.width, window.height))
              .clone());
    }
    for (std::size_t i = 0; i < apart.size(); ++i) {
      for (int row = 0; row < apart[i].height; ++row) {
        std::copy_n(blurred[i].ptr(row), apart[i].width, image->at(apart[i].u, apart[i].v + row));
      }
    }
  }
  for (const PixelWindow& window : apart) {
    if (gain_ != 1.0) Scale(window, image);
    if (!noise_.empty()) AddNoise(window, image);
  }
}

void EffectChain::Scale(const PixelWindow& window, GreyImage* image) const {
  std::array<std::uint8_t, 256> scaled{};
  for (int level = 0; level < 256; ++level) {
    scaled[level] = static_cast<std::uint8_t>(std::min(255L, std::lround(gain_ * level)));
  }
  for (int v = window.v; v < window.v + window.height; ++v) {
    std::uint8_t* const row = image->at(window.u, v);
    for (int i = 0; i < window.width; ++i) row[i] = scaled[row[i]];
  }
}

// Each row of each image has its own place in the table, so that a pixel's noise is its own.
void EffectChain::AddNoise(const PixelWindow& window, GreyImage* image) const {
  const std::uint64_t places = kTableSize - static_cast<std::uint64_t>(image->width);
  for (int v = window.v; v < window.v + window.height; ++v) {
    const std::uint64_t key = Mix(image_key_ + static_cast<std::uint64_t>(v) * 0x9e3779b97f4a7c15U);
    const std::int16_t* const noise = noise_.data() + key % places + window.u;
    const int rounding = static_cast<int>((key >> 60U) % kFraction);  // Without bias over the rows.
    std::uint8_t* const row = image->at(window.u, v);
    for (int i = 0; i < window.width; ++i) {
      const int value = (row[i] * kFraction + noise[i] + rounding) >> 4;
      row[i] = static_cast<std::uint8_t>(std::clamp(value, 0, 255));
    }
  }
}

}  // namespace vantage::sim
