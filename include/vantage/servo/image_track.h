#pragma once

#include <optional>

#include <Eigen/Core>

#include "vantage/math/time.h"

namespace vantage {

/// Place and velocity of something that moves in the image, from noisy places: an alpha-beta filter with
/// critical damping.
/// @see P. R. Kalata, "The tracking index", IEEE Trans. Aerospace and Electronic Systems 20(2), 1984.
class ImageTrack {
 public:
  /// @param place   Measured, normalised coordinates.
  /// @param carried By how much the camera's own motion has moved it since the last update.
  /// Starts anew after a gap of more than kLongestGap. Real-time safe.
  void Update(Time exposure, const Eigen::Vector2d& place,
              const Eigen::Vector2d& carried) noexcept {
    const double dt = last_ ? ToSeconds(exposure - *last_) : 0.0;
    if (!last_ || dt > kLongestGap) {
      place_ = place;
      rate_.setZero();
    } else {
      const Eigen::Vector2d expected = place_ + carried + dt * rate_;
      place_ = expected + kAlpha * (place - expected);
      rate_ += kBeta / dt * (place - expected);
    }
    last_ = exposure;
  }

  [[nodiscard]] const Eigen::Vector2d& place() const noexcept { return place_; }  ///< At last().
  [[nodiscard]] const Eigen::Vector2d& rate() const noexcept { return rate_; }    ///< [1/s].
  [[nodiscard]] std::optional<Time> last() const noexcept { return last_; }

 private:
  static constexpr double kLongestGap = 0.3;  // [s]
  static constexpr double kAlpha = 0.5;
  static constexpr double kBeta = kAlpha * kAlpha / (2.0 - kAlpha);

  Eigen::Vector2d place_{Eigen::Vector2d::Zero()};
  Eigen::Vector2d rate_{Eigen::Vector2d::Zero()};
  std::optional<Time> last_;
};

}  // namespace vantage
