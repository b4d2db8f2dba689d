#include "vantage/runtime/histogram.h"

#include <algorithm>
#include <cmath>

namespace vantage {
namespace {

constexpr int kLinear = 32;  // Buckets of 1 ns.
constexpr int kStepsPerOctave = 16;
constexpr int kFirstExponent = 5;  // 2^5 = kLinear.

int IndexOf(std::int64_t ns) noexcept {
  if (ns < kLinear) return static_cast<int>(ns);
  const int exponent = 63 - __builtin_clzll(static_cast<unsigned long long>(ns));
  // The four bits after the leading one.
  const int step = static_cast<int>((ns >> (exponent - 4)) & (kStepsPerOctave - 1));
  const int index = kLinear + (exponent - kFirstExponent) * kStepsPerOctave + step;
  return std::min(index, DurationHistogram::kBuckets - 1);
}

std::int64_t LowerBorder(int index) noexcept {
  if (index < kLinear) return index;
  const int octave = (index - kLinear) / kStepsPerOctave;
  const int step = (index - kLinear) % kStepsPerOctave;
  return (std::int64_t{kStepsPerOctave} + step) << (octave + kFirstExponent - 4);
}

}  // namespace

void DurationHistogram::Add(Duration d) noexcept {
  const Duration clamped = std::max(d, Duration::zero());
  ++counts_[IndexOf(clamped.count())];
  ++count_;
  max_ = std::max(max_, clamped);
}

Duration DurationHistogram::Percentile(double fraction) const noexcept {
  if (count_ == 0) return Duration::zero();
  const double wanted = std::ceil(std::clamp(fraction, 0.0, 1.0) * static_cast<double>(count_));
  std::int64_t seen = 0;
  for (int i = 0; i < kBuckets; ++i) {
    seen += counts_[i];
    if (seen > 0 && static_cast<double>(seen) >= wanted) return std::min(bucket(i).upper, max_);
  }
  return max_;
}

DurationHistogram::Bucket DurationHistogram::bucket(int index) const noexcept {
  return {Duration(LowerBorder(index)), Duration(LowerBorder(index + 1)), counts_[index]};
}

}  // namespace vantage
