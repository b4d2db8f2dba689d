#pragma once

#include <string>
#include <vector>

#include "vantage/messaging/lcm_link.h"
#include "watch_state.h"

/// @file
/// What vantage-watch shows, as lines of styled text: a pure function of its state, drawn by whoever has a
/// terminal.

namespace vantage {

enum class TextStyle { kPlain, kDim, kTitle, kValue, kGood, kWarning, kBad, kCurve };

struct TextSpan {
  std::string text;  ///< UTF-8; every character is one cell wide.
  TextStyle style{TextStyle::kPlain};
};
using TextLine = std::vector<TextSpan>;

struct WatchHeader {
  std::string url;
  bool connected{false};
  bool paused{false};
};

/// The view for a terminal of this size: at most `rows` lines of at most `columns` cells.
[[nodiscard]] std::vector<TextLine> RenderWatch(const WatchState& state, const WatchHeader& header,
                                                Time now, int columns, int rows);

/// The newest `width` values as a curve of bars, from least to greatest; spaces where there is none.
/// `logarithmic` for positive values over many decades.
[[nodiscard]] std::string Sparkline(const std::deque<double>& values, int width, bool logarithmic);

/// Cells of a UTF-8 text whose characters are one wide.
[[nodiscard]] int CellsOf(const std::string& text);

}  // namespace vantage
