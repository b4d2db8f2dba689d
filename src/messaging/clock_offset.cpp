#include "vantage/messaging/clock_offset.h"

#include <algorithm>

namespace vantage {
namespace {

constexpr Duration kMostReordered = std::chrono::seconds(1);

}  // namespace

Time ClockOffset::Translate(Time sent, Time arrival) noexcept {
  const Duration offset = arrival - sent;
  // A clock that went back is another one: the sender was started anew.
  if (least_ && sent < last_sent_ - kMostReordered) least_.reset();
  last_sent_ = sent;
  if (!least_ || arrival >= window_end_) {
    // After a gap that is longer than a window, the one before is no neighbour.
    least_before_ = arrival < window_end_ + window_ ? least_ : std::nullopt;
    least_ = offset;
    window_end_ = arrival + window_;
  }
  least_ = std::min(*least_, offset);
  const Duration best = least_before_ ? std::min(*least_, *least_before_) : *least_;
  return sent + best;
}

}  // namespace vantage
