#pragma once

#include <optional>

#include "vantage/math/time.h"

namespace vantage {

/// Translates the stamps of a sender with a clock of its own to our monotonic clock. The offset is that of
/// the message that was on its way for the least time, of the last `window` or so: what is left is that
/// least delay, which makes a stamp younger than it is, and what the clocks drift apart meanwhile. After a
/// pause longer than the window, or when the sender's clock goes back, it begins anew.
class ClockOffset {
 public:
  /// @param window  Of the messages that count.
  explicit ClockOffset(Duration window = std::chrono::seconds(10)) : window_(window) {}

  /// Our time of a message stamped `sent` that came at `arrival`: never after `arrival`.
  [[nodiscard]] Time Translate(Time sent, Time arrival) noexcept;

 private:
  Duration window_;
  // The least of the window under way and of the one before: together they reach back one to two windows.
  std::optional<Duration> least_, least_before_;
  Time window_end_{};
  Time last_sent_{};
};

}  // namespace vantage
