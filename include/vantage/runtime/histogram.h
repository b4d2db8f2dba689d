#pragma once

#include <array>
#include <cstdint>

#include "vantage/math/time.h"

namespace vantage {

/// Histogram of durations from 0 to about 17 s with a resolution of 1/16 of the value: linear up to
/// 32 ns, then 16 steps for each doubling. Fixed storage. Real-time safe.
class DurationHistogram {
 public:
  /// Negative durations count as 0; longer ones than the range count in the last bucket.
  void Add(Duration d) noexcept;

  [[nodiscard]] std::int64_t count() const noexcept { return count_; }
  [[nodiscard]] Duration max() const noexcept { return max_; }

  /// Least bucket border that at least `fraction` of the durations do not exceed; never more than
  /// max(). 0 when nothing was added.
  /// @param fraction  In [0, 1]: 0.999 gives the 99.9th percentile.
  [[nodiscard]] Duration Percentile(double fraction) const noexcept;

  /// One bucket: `count` durations in [lower, upper).
  struct Bucket {
    Duration lower;      ///< Least duration it counts.
    Duration upper;      ///< First duration that it does not count.
    std::int64_t count;  ///< Durations in it so far.
  };
  /// 32 of 1 ns each, then 16 for each of 29 doublings.
  static constexpr int kBuckets = 32 + 16 * 29;
  /// Count and bounds of one bucket.
  [[nodiscard]] Bucket bucket(int index) const noexcept;

 private:
  std::array<std::int64_t, kBuckets> counts_{};
  std::int64_t count_{0};
  Duration max_{0};
};

}  // namespace vantage
