#pragma once

#include <Eigen/Core>

#include "vantage/camera/pinhole.h"

/// @file
/// Closed form of the interaction matrix of an image point: for code that evaluates many views, where
/// ViSP's allocations would count. FeatureSet takes the matrix from ViSP; a test holds the two equal.

namespace vantage {

/// Interaction matrix of the image of a point fixed in the world: dn/dt = L V_WC_C.
///
/// @param point  As returned by Project().
/// @return 2×6; columns 0-2 in 1/m, columns 3-5 dimensionless (per rad).
/// Real-time safe.
/// @see F. Chaumette, S. Hutchinson, "Visual servo control, Part I: Basic approaches", IEEE Robotics &
///   Automation Magazine 13(4), 2006.
[[nodiscard]] inline Eigen::Matrix<double, 2, 6> PointInteraction(
    const ImagePoint& point) noexcept {
  const double x = point.n.x();
  const double y = point.n.y();
  const double d = 1.0 / point.depth;
  Eigen::Matrix<double, 2, 6> L;
  // clang-format off
  L << -d,  0.0, x * d,       x * y, -(1.0 + x * x),  y,
       0.0, -d,  y * d, 1.0 + y * y,         -x * y, -x;
  // clang-format on
  return L;
}

}  // namespace vantage
