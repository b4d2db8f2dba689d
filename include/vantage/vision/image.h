#pragma once

#include <cassert>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "vantage/camera/camera_model.h"

/// @file
/// Images as plain memory, row by row from the top; pixel (u, v) is at row v, column u.

namespace vantage {

/// A grey image that someone else owns.
struct GreyView {
  const std::uint8_t* data{nullptr};  ///< Upper left pixel; 0 is black.
  int width{0};                       ///< Columns [px].
  int height{0};                      ///< Rows [px].
  int stride{0};                      ///< Bytes from one row to the next; >= width.

  /// First pixel of a row.
  [[nodiscard]] const std::uint8_t* row(int v) const noexcept {
    return data + static_cast<std::ptrdiff_t>(v) * stride;
  }
  /// Grey level of the pixel in column u, row v.
  [[nodiscard]] std::uint8_t at(int u, int v) const noexcept { return row(v)[u]; }
  [[nodiscard]] bool empty() const noexcept { return width <= 0 || height <= 0; }
};

/// An image of `Channels` interleaved values of type T per pixel, rows packed.
template <typename T, int Channels>
struct Image {
  int width{0};           ///< Columns [px].
  int height{0};          ///< Rows [px].
  std::vector<T> pixels;  ///< width * height * Channels values.

  /// Changes the size; keeps the memory when it suffices. The content is unspecified afterwards.
  void Resize(int new_width, int new_height) {
    width = new_width;
    height = new_height;
    pixels.resize(static_cast<std::size_t>(width) * height * Channels);
  }
  /// First channel of the pixel in column u, row v.
  [[nodiscard]] const T* at(int u, int v) const noexcept {
    assert(u >= 0 && v >= 0 && u < width && v < height);
    return pixels.data() + (static_cast<std::size_t>(v) * width + u) * Channels;
  }
  /// The same, to be written.
  [[nodiscard]] T* at(int u, int v) noexcept {
    return const_cast<T*>(static_cast<const Image&>(*this).at(u, v));
  }
};

using GreyImage = Image<std::uint8_t, 1>;    ///< Intensity, 0 to 255.
using ColourImage = Image<std::uint8_t, 3>;  ///< Red, green, blue.
using DepthImage = Image<float, 1>;          ///< Depth Z in the camera frame [m].
using IdImage = Image<std::uint16_t, 1>;     ///< What each pixel shows.

/// The image, not owned.
[[nodiscard]] inline GreyView View(const GreyImage& image) noexcept {
  return {image.pixels.data(), image.width, image.height, image.width};
}

/// A rectangle of pixels: columns [u, u + width), rows [v, v + height).
struct PixelWindow {
  int u{0};       ///< First column [px]; may lie outside the image.
  int v{0};       ///< First row [px]; the same.
  int width{0};   ///< Columns [px]; <= 0: empty.
  int height{0};  ///< Rows [px]; <= 0: empty.

  [[nodiscard]] bool empty() const noexcept { return width <= 0 || height <= 0; }
  [[nodiscard]] std::int64_t area() const noexcept {
    return empty() ? 0 : static_cast<std::int64_t>(width) * height;
  }
  /// Whether the windows share a pixel.
  [[nodiscard]] bool overlaps(const PixelWindow& other) const noexcept {
    return u < other.u + other.width && other.u < u + width && v < other.v + other.height &&
           other.v < v + height;
  }
  /// Whether the pixel is in it.
  [[nodiscard]] bool contains(int column, int line) const noexcept {
    return column >= u && line >= v && column < u + width && line < v + height;
  }
};

/// The part of a window inside an image of the given size; empty when there is none.
[[nodiscard]] PixelWindow Clip(const PixelWindow& window, int width, int height) noexcept;

/// Smallest window that holds both; an empty one adds nothing.
[[nodiscard]] PixelWindow Hull(const PixelWindow& a, const PixelWindow& b) noexcept;

/// Windows clipped to the image, overlapping ones replaced by their hull until none overlap: the same
/// pixels at least, and none twice.
[[nodiscard]] std::vector<PixelWindow> MergeOverlapping(const std::vector<PixelWindow>& windows,
                                                        int width, int height);

/// Windows wider by `margin` pixels on each side.
[[nodiscard]] std::vector<PixelWindow> Grow(const std::vector<PixelWindow>& windows, int margin);

}  // namespace vantage
