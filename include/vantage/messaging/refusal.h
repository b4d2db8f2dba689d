#pragma once

#include <array>
#include <cstdint>

#include "vantage/servo/servo_report.h"

namespace vantage {

/// Why a message from outside was not used. The checks run in this order; the first that fails names
/// the refusal.
enum class Refusal : int {
  kNone = 0,
  kTooLarge,       ///< More bytes than any message of its type needs.
  kTruncated,      ///< Ends before its type does.
  kFingerprint,    ///< Another type, or another version of it.
  kBadCount,       ///< A negative count, or one that the bytes that follow cannot hold.
  kBadString,      ///< A string without its terminating NUL, or longer than the message.
  kTrailingBytes,  ///< Goes on after its type ends.
  kUndecodable,    ///< LCM's own decoder refused it.
  kLimit,          ///< More joints, markers, rows or pixels than this program can hold, or none.
  kNotFinite,      ///< A NaN or an infinity where there must be none.
  kOutOfRange,  ///< A value that cannot be: an unknown enumerator, a quaternion that is not unit.
  kBadTime,     ///< A time stamp that no clock shows, or an exposure after its sending.
  kReordered,   ///< Not newer than the message before it on the channel.
  kFuture,      ///< From the future, or from a sender with another clock.
};

inline constexpr int kNumRefusals = static_cast<int>(Refusal::kFuture) + 1;

/// "TOO_LARGE", "NOT_FINITE", ...
[[nodiscard]] const char* Name(Refusal refusal) noexcept;

/// As a servo's status has it.
[[nodiscard]] InputFault FaultOf(Refusal refusal) noexcept;

/// Messages refused, by reason.
using RefusalCounts = std::array<std::int64_t, kNumRefusals>;

}  // namespace vantage
