#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>

#include <Eigen/Core>
#include <Eigen/LU>

#include "vantage/vision/disc_image.h"
#include "vantage/vision/image.h"

/// @file
/// Images for tests of detection, drawn by brute force: 16x16 samples to a pixel.

namespace vantage::test {

constexpr int kDark = 25;
constexpr int kBright = 230;

inline GreyImage Blank(int width = 160, int height = 120, std::uint8_t level = 120) {
  GreyImage image;
  image.Resize(width, height);
  std::fill(image.pixels.begin(), image.pixels.end(), level);
  return image;
}

/// Σ of an ellipse with semi-axes a, b [px], the first turned by `angle` from u to v.
inline Eigen::Matrix2d Shape(double a, double b, double angle) {
  Eigen::Matrix2d R;
  R << std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle);
  return R * Eigen::Vector2d(a * a, b * b).asDiagonal() * R.transpose();
}

/// A disc and its ring of twice the size.
inline void DrawDot(GreyImage* image, const Eigen::Vector2d& centre, const Eigen::Matrix2d& shape,
                    bool dark) {
  const Eigen::Matrix2d inverse = shape.inverse();
  constexpr int kSamples = 16;
  for (int v = 0; v < image->height; ++v) {
    for (int u = 0; u < image->width; ++u) {
      if ((Eigen::Vector2d(u, v) - centre).norm() > 2.2 * std::sqrt(shape.trace()) + 2.0) continue;
      double sum = 0.0;
      for (int j = 0; j < kSamples; ++j) {
        for (int i = 0; i < kSamples; ++i) {
          const Eigen::Vector2d p =
              Eigen::Vector2d(u + (i + 0.5) / kSamples - 0.5, v + (j + 0.5) / kSamples - 0.5) -
              centre;
          const double r2 = p.dot(inverse * p);
          sum += r2 <= 1.0 ? (dark ? kDark : kBright)
                           : (r2 <= 4.0 ? (dark ? kBright : kDark) : *image->at(u, v));
        }
      }
      *image->at(u, v) = static_cast<std::uint8_t>(std::lround(sum / (kSamples * kSamples)));
    }
  }
}

/// Fills a rectangle.
inline void DrawBox(GreyImage* image, const PixelWindow& box, std::uint8_t level) {
  for (int v = std::max(0, box.v); v < std::min(image->height, box.v + box.height); ++v) {
    for (int u = std::max(0, box.u); u < std::min(image->width, box.u + box.width); ++u) {
      *image->at(u, v) = level;
    }
  }
}

inline void AddNoise(GreyImage* image, double sigma, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0.0, sigma);
  for (std::uint8_t& pixel : image->pixels) {
    pixel = static_cast<std::uint8_t>(std::clamp(std::lround(pixel + normal(random)), 0L, 255L));
  }
}

}  // namespace vantage::test
