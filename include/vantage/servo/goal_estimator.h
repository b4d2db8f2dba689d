#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "vantage/camera/camera_model.h"

namespace vantage {

/// Where a marker of the goal stands in the world, from a prior and from images of it: an extended
/// Kalman filter with a point at rest as its state. One camera that stands still fixes only the ray;
/// as the camera moves the depth follows.
/// @see S. Thrun, W. Burgard, D. Fox, "Probabilistic Robotics", MIT Press 2005, ch. 3.3.
class GoalPointEstimator {
 public:
  /// @param p_WG   Prior position [m].
  /// @param sigma  Its standard deviation along each axis [m]; > 0.
  GoalPointEstimator(const Eigen::Vector3d& p_WG, double sigma);

  /// One measurement, with lens distortion removed from `pixel`.
  ///
  /// @param sigma_px  Standard deviation of a pixel coordinate [px]; > 0.
  /// A measurement further than `gate` standard deviations from what is expected is refused; when many
  /// in a row are, it is the estimate that is wrong, and its covariance grows until one is let in.
  /// @return false, and the estimate not changed, when it is refused, the estimate is not in front of the
  ///   camera or the pixel is not finite.
  /// Real-time safe.
  bool Update(const CameraModel& camera, const Eigen::Isometry3d& X_WC,
              const Eigen::Vector2d& pixel, double sigma_px, double gate = 5.0) noexcept;

  /// The point may have gone by `sigma` [m] along each axis since the last measurement. Real-time safe.
  void Drift(double sigma) noexcept { covariance_ += sigma * sigma * Eigen::Matrix3d::Identity(); }

  [[nodiscard]] const Eigen::Vector3d& p_WG() const noexcept { return p_WG_; }  ///< [m].
  [[nodiscard]] const Eigen::Matrix3d& covariance() const noexcept {
    return covariance_;
  }  ///< [m²].

 private:
  Eigen::Vector3d p_WG_;
  Eigen::Matrix3d covariance_;
  int refused_in_a_row_{0};
};

}  // namespace vantage
