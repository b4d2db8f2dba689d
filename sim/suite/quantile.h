#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace vantage::sim {

/// Value below which `share` of the values lie, by linear interpolation; 0 of none.
[[nodiscard]] inline double Quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  const double at = share * static_cast<double>(values.size() - 1);
  const auto low = static_cast<std::size_t>(at);
  const std::size_t high = std::min(low + 1, values.size() - 1);
  return values[low] + (at - static_cast<double>(low)) * (values[high] - values[low]);
}

}  // namespace vantage::sim
