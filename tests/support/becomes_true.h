#pragma once

#include <chrono>
#include <functional>
#include <thread>

namespace vantage::test {

/// How long a test waits for what other threads and processes do: only a failing one uses it up.
inline constexpr std::chrono::seconds kPatience{30};

/// Waits until `condition` holds; false when it still does not after `patience`.
[[nodiscard]] inline bool BecomesTrue(const std::function<bool()>& condition,
                                      std::chrono::nanoseconds patience = kPatience) {
  const auto end = std::chrono::steady_clock::now() + patience;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return true;
}

}  // namespace vantage::test
