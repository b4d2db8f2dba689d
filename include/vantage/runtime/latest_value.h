#pragma once

#include <array>
#include <atomic>
#include <cstdint>

/// @file
/// The only way data crosses threads in this project.

namespace vantage {

/// Hands the newest value from one writer thread to one reader thread without waiting on either side
/// (a triple buffer). Older values are dropped: a controller wants the last measurement, not a queue.
///
/// Real-time safe on both sides as long as copying a T does not allocate.
template <typename T>
class LatestValue {
 public:
  LatestValue() = default;
  LatestValue(const LatestValue&) = delete;
  LatestValue& operator=(const LatestValue&) = delete;

  /// Writer thread only.
  void Publish(const T& value) noexcept {
    slots_[write_] = value;
    // Release: the reader that gets this slot sees its content. Acquire: the slot that comes back is
    // no longer being read.
    const unsigned before = middle_.exchange(write_ | kFresh, std::memory_order_acq_rel);
    write_ = before & kIndex;
    published_.store(published_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
    if ((before & kFresh) != 0) {
      dropped_.store(dropped_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
    }
  }

  /// Reader thread only. Copies the newest value to *out; false (and *out as it was) when nothing came
  /// since the last call.
  [[nodiscard]] bool Take(T* out) noexcept {
    if ((middle_.load(std::memory_order_relaxed) & kFresh) == 0) return false;
    read_ = middle_.exchange(read_, std::memory_order_acq_rel) & kIndex;
    *out = slots_[read_];
    return true;
  }

  /// Values published so far. Any thread.
  [[nodiscard]] std::int64_t published() const noexcept {
    return published_.load(std::memory_order_relaxed);
  }
  /// Values that a newer one replaced before the reader took them. Any thread.
  [[nodiscard]] std::int64_t dropped() const noexcept {
    return dropped_.load(std::memory_order_relaxed);
  }

 private:
  static constexpr unsigned kFresh = 4;
  static constexpr unsigned kIndex = 3;
  static constexpr int kCacheLine = 64;

  // Each slot is owned by exactly one of: the writer (write_), the reader (read_), nobody (middle_).
  std::array<T, 3> slots_{};
  alignas(kCacheLine) unsigned write_{0};
  // Written by the writer alone: a load and a store do, without a locked instruction.
  std::atomic<std::int64_t> published_{0};
  std::atomic<std::int64_t> dropped_{0};
  alignas(kCacheLine) std::atomic<unsigned> middle_{1};
  alignas(kCacheLine) unsigned read_{2};
};

}  // namespace vantage
