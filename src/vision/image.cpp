#include "vantage/vision/image.h"

#include <algorithm>

namespace vantage {

PixelWindow Clip(const PixelWindow& window, int width, int height) noexcept {
  const int left = std::max(window.u, 0);
  const int top = std::max(window.v, 0);
  const int right = std::min(window.u + window.width, width);
  const int bottom = std::min(window.v + window.height, height);
  if (right <= left || bottom <= top) return {};
  return {left, top, right - left, bottom - top};
}

PixelWindow Hull(const PixelWindow& a, const PixelWindow& b) noexcept {
  if (a.empty()) return b;
  if (b.empty()) return a;
  const int left = std::min(a.u, b.u);
  const int top = std::min(a.v, b.v);
  return {left, top, std::max(a.u + a.width, b.u + b.width) - left,
          std::max(a.v + a.height, b.v + b.height) - top};
}

}  // namespace vantage
