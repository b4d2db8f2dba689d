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

std::vector<PixelWindow> MergeOverlapping(const std::vector<PixelWindow>& windows, int width,
                                          int height) {
  std::vector<PixelWindow> apart;
  for (const PixelWindow& window : windows) {
    PixelWindow grown = Clip(window, width, height);
    if (grown.empty()) continue;
    for (std::size_t i = 0; i < apart.size();) {
      if (!apart[i].overlaps(grown)) {
        ++i;
        continue;
      }
      grown = Hull(grown, apart[i]);
      apart.erase(apart.begin() + static_cast<std::ptrdiff_t>(i));
      i = 0;  // The hull may reach those passed over before.
    }
    apart.push_back(grown);
  }
  return apart;
}

std::vector<PixelWindow> Grow(const std::vector<PixelWindow>& windows, int margin) {
  std::vector<PixelWindow> grown = windows;
  for (PixelWindow& window : grown) {
    window = {window.u - margin, window.v - margin, window.width + 2 * margin,
              window.height + 2 * margin};
  }
  return grown;
}

}  // namespace vantage
