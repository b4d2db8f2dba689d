#include "vantage/servo/calibration_estimator.h"

#include <cmath>

#include <Eigen/LU>

#include "pixel_by_point.h"
#include "vantage/camera/pinhole.h"
#include "vantage/math/spatial.h"
#include "vantage/robot/kinematics.h"

namespace vantage {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// So many refused measurements in a row are no outliers.
constexpr int kMostRefused = 30;
// Places in the state.
constexpr int kFocal = 6;
constexpr int kJoints = 7;

}  // namespace

CalibrationEstimator::CalibrationEstimator(const CalibrationPrior& prior, int joints)
    : prior_(prior), joint_bias_(JointVector::Zero(joints)), covariance_(PriorCovariance()) {}

CalibrationEstimator::Covariance CalibrationEstimator::PriorCovariance() const noexcept {
  const auto size = kJoints + joint_bias_.size();
  State sigma(size);
  sigma.head<3>().setConstant(prior_.position);
  sigma.segment<3>(3).setConstant(prior_.rotation);
  sigma(kFocal) = prior_.focal;
  sigma.tail(joint_bias_.size()).setConstant(prior_.joint);
  return Covariance(sigma.cwiseAbs2().asDiagonal());
}

bool CalibrationEstimator::Update(const CameraModel& camera, const Isometry3d& X_WC,
                                  const ArmModel& arm, const JointVector& q, const Vector3d& p_EM,
                                  const Vector2d& pixel, double sigma_px, double gate) noexcept {
  if (!prior_.estimate || !pixel.allFinite()) return false;
  const Kinematics kinematics = ComputeKinematics(arm, q - joint_bias_);
  const Isometry3d X_CW = (X_WC * X_CTrue_).inverse();
  const Vector3d p_CM = X_CW * (kinematics.X_WE * p_EM);
  const auto point = Project(p_CM);
  if (!point) return false;

  const CameraModel corrected = WithFocalFactor(camera, focal_factor_);
  const Eigen::Matrix2d K = CalibrationJacobian(corrected);
  const Eigen::Matrix<double, 2, 3> pixel_p = PixelByPoint(K, *point);
  const Vector3d p_EM_W = kinematics.X_WE.linear() * p_EM;
  using Row = Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::ColMajor, 2, kMost>;
  Row H(2, covariance_.rows());
  H.leftCols<3>() = -pixel_p;
  H.middleCols<3>(3) = pixel_p * Skew(p_CM);
  H.col(kFocal) = K * point->n / focal_factor_;
  const Eigen::Matrix<double, 2, 3> pixel_W = pixel_p * X_CW.linear();
  for (Eigen::Index i = 0; i < joint_bias_.size(); ++i) {
    const Twist V = kinematics.J_WE_W.col(i);
    H.col(kJoints + i) = -(pixel_W * (V.head<3>() + V.tail<3>().cross(p_EM_W)));
  }

  const Vector2d innovation = pixel - ToUndistortedPixel(corrected, point->n);
  const Row H_P = H.lazyProduct(covariance_);
  const Eigen::Matrix2d S =
      H_P.lazyProduct(H.transpose()) + sigma_px * sigma_px * Eigen::Matrix2d::Identity();
  const Eigen::Matrix2d S_inverse = S.inverse();
  if (!(innovation.dot(S_inverse * innovation) <= gate * gate)) {
    if (++refused_in_a_row_ > kMostRefused) {
      covariance_ = PriorCovariance();
      refused_in_a_row_ = 0;
    }
    return false;
  }
  refused_in_a_row_ = 0;
  const State step = H_P.transpose().lazyProduct(S_inverse * innovation);
  covariance_ -= H_P.transpose().lazyProduct(S_inverse).lazyProduct(H_P);
  covariance_ = Covariance(0.5 * (covariance_ + covariance_.transpose()));
  X_CTrue_ = Advance(X_CTrue_, step.head<6>());
  focal_factor_ += step(kFocal);
  joint_bias_ += step.tail(joint_bias_.size());
  return true;
}

CameraModel WithFocalFactor(const CameraModel& camera, double factor) noexcept {
  CameraModel corrected = camera;
  corrected.fx *= factor;
  corrected.fy *= factor;
  return corrected;
}

}  // namespace vantage
