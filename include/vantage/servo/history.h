#pragma once

#include <array>
#include <optional>

#include "vantage/math/time.h"

namespace vantage {

/// Ring buffer of the last N time-stamped values, oldest overwritten. Stamps must increase; a value
/// that does not is refused. Real-time safe as long as copying a T is.
template <typename T, int N>
class History {
 public:
  /// False, and nothing stored, when `stamp` is not after the newest one.
  bool Push(Time stamp, const T& value) {
    if (count_ > 0 && stamp <= stamps_[Index(0)]) return false;
    next_ = (next_ + 1) % N;
    stamps_[next_] = stamp;
    values_[next_] = value;
    if (count_ < N) ++count_;
    return true;
  }

  [[nodiscard]] bool empty() const { return count_ == 0; }
  [[nodiscard]] int size() const { return count_; }
  [[nodiscard]] Time newest_stamp() const { return stamps_[Index(0)]; }
  [[nodiscard]] const T& newest() const { return values_[Index(0)]; }

  /// Value at `time`, by `interpolate(a, b, fraction)` between the neighbours; the oldest or newest
  /// value outside the range. nullopt when empty.
  template <typename Interpolate>
  [[nodiscard]] std::optional<T> At(Time time, Interpolate&& interpolate) const {
    if (count_ == 0) return std::nullopt;
    if (time >= stamps_[Index(0)]) return values_[Index(0)];
    for (int i = 1; i < count_; ++i) {
      const int older = Index(i);
      if (stamps_[older] > time) continue;
      const int newer = Index(i - 1);
      const double fraction =
          ToSeconds(time - stamps_[older]) / ToSeconds(stamps_[newer] - stamps_[older]);
      return interpolate(values_[older], values_[newer], fraction);
    }
    return values_[Index(count_ - 1)];
  }

 private:
  // i = 0 is the newest.
  [[nodiscard]] int Index(int i) const { return (next_ - i + N) % N; }

  std::array<Time, N> stamps_{};
  std::array<T, N> values_{};
  int next_{N - 1};
  int count_{0};
};

}  // namespace vantage
