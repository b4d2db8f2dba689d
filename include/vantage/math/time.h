#pragma once

#include <chrono>
#include <cstdint>

/// @file
/// One clock for the whole product: the monotonic one. Simulated time uses the same type, counted
/// from the start of the simulation.

namespace vantage {

/// CLOCK_MONOTONIC.
using Clock = std::chrono::steady_clock;
/// A time stamp on this machine [ns].
using Time = std::chrono::time_point<Clock, std::chrono::nanoseconds>;
/// A span of time [ns].
using Duration = std::chrono::nanoseconds;

/// Seconds as a duration, rounded to the nanosecond.
[[nodiscard]] constexpr Duration FromSeconds(double seconds) noexcept {
  const double ns = seconds * 1e9;
  return Duration(static_cast<std::int64_t>(ns < 0.0 ? ns - 0.5 : ns + 0.5));
}

/// A duration in seconds [s].
[[nodiscard]] constexpr double ToSeconds(Duration d) noexcept {
  return 1e-9 * static_cast<double>(d.count());
}

/// Microseconds since the clock's epoch, as messages carry them (utime) [us].
[[nodiscard]] constexpr std::int64_t ToMicroseconds(Time t) noexcept {
  return std::chrono::duration_cast<std::chrono::microseconds>(t.time_since_epoch()).count();
}

/// Inverse of ToMicroseconds().
[[nodiscard]] constexpr Time FromMicroseconds(std::int64_t utime) noexcept {
  return Time(std::chrono::microseconds(utime));
}

}  // namespace vantage
