#pragma once

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <exception>
#include <initializer_list>
#include <limits>

#include <vantage_lcm/layouts.h>

#include "vantage/math/time.h"
#include "vantage/messaging/codec.h"
#include "vantage/messaging/message_guard.h"

/// @file
/// What the codecs of all types share: bytes to lcm-gen's classes and back, and checks of their fields.

namespace vantage {

/// Decodes the bytes once they are known to be what they claim.
template <typename Wire>
Refusal DecodeWire(const void* data, std::size_t size, std::size_t max_size, Wire* wire) noexcept {
  constexpr const MessageLayout& kLayout = *kLayoutOf<Wire>;
  static_assert(MostFields(kLayout) <= kMaxFields);
  const Refusal refusal = CheckBytes(kLayout, Wire::getHash(), data, size, max_size);
  if (refusal != Refusal::kNone) return refusal;
  try {
    const int length = static_cast<int>(size);
    return wire->decode(data, 0, length) == length ? Refusal::kNone : Refusal::kUndecodable;
  } catch (const std::exception&) {
    return Refusal::kUndecodable;
  }
}

template <typename Wire>
void EncodeWire(const Wire& wire, Bytes* out) {
  out->resize(static_cast<std::size_t>(wire.getEncodedSize()));
  const int length = wire.encode(out->data(), 0, static_cast<int>(out->size()));
  assert(length == static_cast<int>(out->size()));
  (void)length;
}

/// Each check has the Refusal it stands for; the first that fails is the outcome.
class Checks {
 public:
  Checks& Require(bool condition, Refusal otherwise) noexcept {
    if (refusal_ == Refusal::kNone && !condition) refusal_ = otherwise;
    return *this;
  }
  Checks& Finite(std::initializer_list<double> values) noexcept {
    return Require(
        std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); }),
        Refusal::kNotFinite);
  }
  Checks& Finite(const double* values, int count) noexcept {
    return Require(std::all_of(values, values + count, [](double v) { return std::isfinite(v); }),
                   Refusal::kNotFinite);
  }
  Checks& Magnitude(const double* values, int count) noexcept {
    Finite(values, count);
    return Require(
        std::all_of(values, values + count, [](double v) { return std::abs(v) <= kMaxMagnitude; }),
        Refusal::kOutOfRange);
  }
  /// An enumerator, or a small count, in [0, last].
  Checks& UpTo(std::int64_t last, std::int64_t value) noexcept {
    return Require(value >= 0 && value <= last, Refusal::kOutOfRange);
  }
  Checks& NotNegative(std::initializer_list<std::int64_t> values) noexcept {
    return Require(std::all_of(values.begin(), values.end(), [](std::int64_t v) { return v >= 0; }),
                   Refusal::kOutOfRange);
  }
  /// A time that the monotonic clock can show: a Time counts nanoseconds.
  Checks& Stamp(std::int64_t utime) noexcept {
    return Require(utime >= 0 && utime <= std::numeric_limits<std::int64_t>::max() / 1000,
                   Refusal::kBadTime);
  }
  [[nodiscard]] Refusal result() const noexcept { return refusal_; }
  [[nodiscard]] bool failed() const noexcept { return refusal_ != Refusal::kNone; }

 private:
  Refusal refusal_{Refusal::kNone};
};

}  // namespace vantage
