#pragma once

#include <optional>

#include "vantage/math/time.h"
#include "vantage/messaging/refusal.h"

namespace vantage {

/// Bounds of a stamp.
struct StampGateOptions {
  /// Refuse what is not newer than the message before it.
  bool in_order{true};
  /// Refuse stamps later than now by more than this: a sender with a clock of its own, which makes
  /// every age wrong.
  bool not_from_future{true};
  Duration tolerance{std::chrono::milliseconds(100)};  ///< How far ahead of now a stamp may be.
  /// After this long without an accepted message any order is taken: the sender was restarted.
  Duration forget_after{std::chrono::seconds(1)};
};

/// Looks at the time stamps of one channel, one message after the other.
class StampGate {
 public:
  /// A gate that has let nothing through yet.
  explicit StampGate(const StampGateOptions& options = {}) : options_(options) {}

  /// kNone, kReordered (duplicates are that too) or kFuture.
  /// @param now  On the clock that stamps are of.
  [[nodiscard]] Refusal Check(Time stamp, Time now) noexcept;

 private:
  StampGateOptions options_;
  std::optional<Time> last_stamp_;
  Time last_accepted_{};  ///< When, by `now`.
};

}  // namespace vantage
