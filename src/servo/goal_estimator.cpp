#include "vantage/servo/goal_estimator.h"

#include <Eigen/LU>

#include "pixel_by_point.h"
#include "vantage/camera/pinhole.h"

namespace vantage {
namespace {

// So many refused measurements in a row are no outliers.
constexpr int kMostRefused = 10;
// Each further one widens the estimate by this factor...
constexpr double kWidening = 1.2;
// ... up to this standard deviation [m].
constexpr double kWidest = 1.0;

}  // namespace

GoalPointEstimator::GoalPointEstimator(const Eigen::Vector3d& p_WG, double sigma)
    : p_WG_(p_WG), covariance_(sigma * sigma * Eigen::Matrix3d::Identity()) {}

bool GoalPointEstimator::Update(const CameraModel& camera, const Eigen::Isometry3d& X_WC,
                                const Eigen::Vector2d& pixel, double sigma_px,
                                double gate) noexcept {
  if (!pixel.allFinite()) return false;
  const auto point = Project(X_WC.inverse() * p_WG_);
  if (!point) return false;
  const Eigen::Matrix2d K = CalibrationJacobian(camera);
  const Eigen::Matrix<double, 2, 3> H = PixelByPoint(K, *point) * X_WC.linear().transpose();

  const Eigen::Vector2d innovation = pixel - ToUndistortedPixel(camera, point->n);
  const Eigen::Matrix2d S =
      H * covariance_ * H.transpose() + sigma_px * sigma_px * Eigen::Matrix2d::Identity();
  const Eigen::Matrix2d S_inverse = S.inverse();
  if (innovation.dot(S_inverse * innovation) > gate * gate) {
    const bool narrow = covariance_.trace() < 3.0 * kWidest * kWidest;
    if (++refused_in_a_row_ > kMostRefused && narrow) covariance_ *= kWidening * kWidening;
    return false;
  }
  refused_in_a_row_ = 0;
  const Eigen::Matrix<double, 3, 2> gain = covariance_ * H.transpose() * S_inverse;
  p_WG_ += gain * innovation;
  // Joseph's form keeps the covariance symmetric and positive.
  const Eigen::Matrix3d I_KH = Eigen::Matrix3d::Identity() - gain * H;
  const Eigen::Matrix3d updated =
      I_KH * covariance_ * I_KH.transpose() + sigma_px * sigma_px * gain * gain.transpose();
  covariance_ = 0.5 * (updated + updated.transpose());
  return true;
}

}  // namespace vantage
