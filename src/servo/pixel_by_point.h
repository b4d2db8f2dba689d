#pragma once

#include <Eigen/Core>

#include "vantage/camera/pinhole.h"

namespace vantage {

/// How an undistorted pixel moves with the point before the camera that it shows: ∂(u, v)/∂p_C [px/m].
/// @param K  ∂(u, v)/∂n, that of CalibrationJacobian() [px].
[[nodiscard]] inline Eigen::Matrix<double, 2, 3> PixelByPoint(const Eigen::Matrix2d& K,
                                                              const ImagePoint& point) noexcept {
  Eigen::Matrix<double, 2, 3> n_p;  // ∂n/∂p_C
  n_p << 1.0, 0.0, -point.n.x(), 0.0, 1.0, -point.n.y();
  n_p /= point.depth;
  return K * n_p;
}

}  // namespace vantage
