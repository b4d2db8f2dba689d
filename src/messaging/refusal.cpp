#include "vantage/messaging/refusal.h"

namespace vantage {

const char* Name(Refusal refusal) noexcept {
  switch (refusal) {
    case Refusal::kNone:
      return "NONE";
    case Refusal::kTooLarge:
      return "TOO_LARGE";
    case Refusal::kTruncated:
      return "TRUNCATED";
    case Refusal::kFingerprint:
      return "FINGERPRINT";
    case Refusal::kBadCount:
      return "BAD_COUNT";
    case Refusal::kBadString:
      return "BAD_STRING";
    case Refusal::kTrailingBytes:
      return "TRAILING_BYTES";
    case Refusal::kUndecodable:
      return "UNDECODABLE";
    case Refusal::kLimit:
      return "LIMIT";
    case Refusal::kNotFinite:
      return "NOT_FINITE";
    case Refusal::kOutOfRange:
      return "OUT_OF_RANGE";
    case Refusal::kBadTime:
      return "BAD_TIME";
    case Refusal::kReordered:
      return "REORDERED";
    case Refusal::kFuture:
      return "FUTURE";
  }
  return "UNKNOWN";
}

InputFault FaultOf(Refusal refusal) noexcept {
  switch (refusal) {
    case Refusal::kLimit:
      return InputFault::kWrongSize;
    case Refusal::kNotFinite:
      return InputFault::kNotFinite;
    case Refusal::kOutOfRange:
    case Refusal::kBadTime:
      return InputFault::kOutOfRange;
    case Refusal::kReordered:
      return InputFault::kReordered;
    case Refusal::kFuture:
      return InputFault::kFuture;
    default:
      return InputFault::kMalformed;
  }
}

}  // namespace vantage
