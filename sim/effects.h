#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include "vantage/math/time.h"
#include "vantage/vision/image.h"

namespace vantage::sim {

/// What a real camera does to a grey image. All zero: nothing.
struct ImageEffects {
  double noise{0.0};      ///< Standard deviation of each pixel [grey levels of 255]; >= 0.
  double blur{0.0};       ///< Standard deviation of a Gaussian blur [px]; in [0, 10].
  double gain_step{0.0};  ///< Exposure jumps: the log of the gain is uniform in ± this; in [0, 1].
  double gain_period{1.0};  ///< Mean time between two jumps [s]; > 0.
};

/// Applies them: blur, then gain, then noise. Seeded, and the same inside windows as in the whole image:
/// what happens to a pixel depends on the seed, the images before and the pixel, not on what was rendered.
class EffectChain {
 public:
  /// Throws ConfigError (key "camera.effects...") when an option is out of bounds.
  EffectChain(const ImageEffects& effects, std::uint64_t seed);

  /// To be called once for each image, in order.
  void Begin(Time exposure);

  void Apply(GreyImage* image);
  /// Inside the windows only; needs the image rendered up to margin() pixels round them (Grow()).
  void Apply(const std::vector<PixelWindow>& windows, GreyImage* image);

  [[nodiscard]] int margin() const noexcept;  ///< Reach of the blur [px].
  [[nodiscard]] double gain() const noexcept { return gain_; }

 private:
  void Scale(const PixelWindow& window, GreyImage* image) const;
  void AddNoise(const PixelWindow& window, GreyImage* image) const;

  ImageEffects effects_;
  std::mt19937_64 random_;
  std::vector<std::int16_t> noise_;  // Sixteenths of a grey level.
  std::uint64_t image_key_{0};
  double gain_{1.0};
  Time next_jump_{Time::max()};
  bool started_{false};
};

}  // namespace vantage::sim
