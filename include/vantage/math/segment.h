#pragma once

#include <algorithm>

#include <Eigen/Core>

namespace vantage {

/// Squared distance [m²] of the point p from the segment that starts at a and runs along `along` [m]; from
/// a itself where `along` is 0. Real-time safe.
[[nodiscard]] inline double SquaredDistanceToSegment(const Eigen::Vector3d& p,
                                                     const Eigen::Vector3d& a,
                                                     const Eigen::Vector3d& along) noexcept {
  const double length2 = along.squaredNorm();
  const double share = length2 > 0.0 ? std::clamp(along.dot(p - a) / length2, 0.0, 1.0) : 0.0;
  return (p - a - share * along).squaredNorm();
}

}  // namespace vantage
