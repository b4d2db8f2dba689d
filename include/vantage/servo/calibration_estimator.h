#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "vantage/camera/camera_model.h"
#include "vantage/robot/arm_model.h"

namespace vantage {

/// How well camera and arm are calibrated, as standard deviations; what the servo may correct.
struct CalibrationPrior {
  bool estimate{true};     ///< False: the calibration is taken as it is.
  double position{0.006};  ///< Of the camera's pose on its rig, each axis [m]; >= 0.
  double rotation{0.01};   ///< The same, about each axis [rad]; >= 0.
  double focal{0.008};     ///< Of the focal length, as a share of it [-]; >= 0.
  double joint{0.008};     ///< Of each encoder's zero [rad or m]; >= 0.
};

/// What is wrong with the calibration of camera and arm, from images of the arm's own markers: an
/// extended Kalman filter whose state is the error of the camera's pose on its rig (constant in C), the focal
/// length's and the encoders' zeros. One view leaves most of it open; as camera and arm move, the markers
/// are the calibration target.
/// @see S. Thrun, W. Burgard, D. Fox, "Probabilistic Robotics", MIT Press 2005, ch. 3.3; J. Solà,
///   "Quaternion kinematics for the error-state Kalman filter", 2017, ch. 6 (the pose's error is reset
///   after each correction).
class CalibrationEstimator {
 public:
  /// @param joints  Of the arm.
  CalibrationEstimator(const CalibrationPrior& prior, int joints);

  /// One measurement of a marker fixed to the end effector.
  ///
  /// @param camera   As calibrated.
  /// @param X_WC     The camera's pose as calibrated.
  /// @param q        Joints as read.
  /// @param p_EM     The marker [m].
  /// @param pixel    Lens distortion removed.
  /// @param sigma_px Standard deviation of a pixel coordinate [px]; > 0.
  /// @return false, and the estimate not changed, when the prior says not to estimate, the marker is not
  ///   in front of the camera, or the measurement is further from what is expected than `gate` standard
  ///   deviations. After many such in a row the estimate is what is wrong, and starts from its prior.
  /// Real-time safe.
  bool Update(const CameraModel& camera, const Eigen::Isometry3d& X_WC, const ArmModel& arm,
              const JointVector& q, const Eigen::Vector3d& p_EM, const Eigen::Vector2d& pixel,
              double sigma_px, double gate = 5.0) noexcept;

  /// The camera's true pose is its calibrated one times this.
  [[nodiscard]] const Eigen::Isometry3d& X_CTrue() const noexcept { return X_CTrue_; }
  /// The true focal length by the calibrated one [-].
  [[nodiscard]] double focal_factor() const noexcept { return focal_factor_; }
  /// What the encoders read too much [rad or m].
  [[nodiscard]] const JointVector& joint_bias() const noexcept { return joint_bias_; }
  /// Standard deviations of the pose's error: position [m], rotation [rad], in the true camera's axes.
  [[nodiscard]] Eigen::Matrix<double, 6, 1> pose_sigma() const noexcept {
    return covariance_.diagonal().head<6>().cwiseSqrt();
  }

 private:
  static constexpr int kMost = 7 + kMaxJoints;
  using State = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kMost, 1>;
  using Covariance =
      Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMost, kMost>;

  [[nodiscard]] Covariance PriorCovariance() const noexcept;

  CalibrationPrior prior_;
  Eigen::Isometry3d X_CTrue_{Eigen::Isometry3d::Identity()};
  double focal_factor_{1.0};
  JointVector joint_bias_;
  Covariance covariance_;
  int refused_in_a_row_{0};
};

/// The camera as corrected: its focal lengths times the factor.
[[nodiscard]] CameraModel WithFocalFactor(const CameraModel& camera, double factor) noexcept;

}  // namespace vantage
