#include "vantage/messaging/clock_offset.h"

#include <algorithm>

namespace vantage {

Time ClockOffset::Translate(Time sent, Time arrival) noexcept {
  const Duration offset = arrival - sent;
  if (!least_ || arrival >= window_end_) {
    least_before_ = least_;
    least_ = offset;
    window_end_ = arrival + window_;
  }
  least_ = std::min(*least_, offset);
  const Duration best = least_before_ ? std::min(*least_, *least_before_) : *least_;
  return sent + best;
}

}  // namespace vantage
