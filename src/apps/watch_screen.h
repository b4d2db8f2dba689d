#pragma once

#include "watch_view.h"

namespace vantage {

/// The terminal in full-screen mode, by ncurses; given back at the end.
class WatchScreen {
 public:
  /// Throws Error when the terminal cannot be used.
  WatchScreen();
  ~WatchScreen();
  WatchScreen(const WatchScreen&) = delete;
  WatchScreen& operator=(const WatchScreen&) = delete;

  [[nodiscard]] int columns() const;
  [[nodiscard]] int rows() const;
  void Draw(const std::vector<TextLine>& lines);
  /// The next key, waiting for it at most `timeout`; 0: none.
  [[nodiscard]] int Key(Duration timeout);
};

}  // namespace vantage
