#include "vantage/messaging/stamp_gate.h"

namespace vantage {

Refusal StampGate::Check(Time stamp, Time now) noexcept {
  if (options_.not_from_future && stamp > now + options_.tolerance) return Refusal::kFuture;
  const bool remembers = last_stamp_ && now - last_accepted_ <= options_.forget_after;
  if (options_.in_order && remembers && stamp <= *last_stamp_) return Refusal::kReordered;
  last_stamp_ = stamp;
  last_accepted_ = now;
  return Refusal::kNone;
}

}  // namespace vantage
