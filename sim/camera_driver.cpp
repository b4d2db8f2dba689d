#include "sim/camera_driver.h"

#include "vantage/robot/kinematics.h"

namespace vantage::sim {
CameraDriver::CameraDriver(std::unique_ptr<Eye> eye, CameraKnowledge knowledge,
                           const CameraEffects& effects, std::uint64_t seed)
    : eye_(std::move(eye)),
      knowledge_(std::move(knowledge)),
      effects_(effects),
      random_(seed + 1) {}

void CameraDriver::Expose(Time now, const Eigen::Isometry3d& X_WC_true, const JointVector& q_true,
                          const Eigen::Isometry3d& X_WG_true,
                          const Eigen::Isometry3d& X_WC_measured, const JointVector& q_measured) {
  const Duration period = FromSeconds(1.0 / effects_.rate);
  // On the camera's own grid, whatever the steps of the plant are.
  next_exposure_ += period;

  const Eigen::Isometry3d X_CW = X_WC_measured.inverse();
  const Eigen::Isometry3d X_CE = X_CW * EndEffectorPose(knowledge_.arm, q_measured);
  PredictMarkers(knowledge_.camera, X_CW, X_CE, knowledge_.tool_markers, knowledge_.goal_markers,
                 &predictions_);

  Pending pending{now + effects_.latency_frames * period, {}};
  eye_->See(now, X_WC_true, q_true, X_WG_true, predictions_, &pending.features);
  if (std::uniform_real_distribution<double>(0.0, 1.0)(random_) < effects_.drop_rate) return;
  pending.features.exposure = now;
  pending.features.stamp = pending.due;
  pending.features.X_WC = X_WC_measured;
  pending_.push_back(pending);
}

std::optional<ImageFeatures> CameraDriver::Deliver(Time now) {
  std::optional<ImageFeatures> newest;
  while (!pending_.empty() && pending_.front().due <= now) {
    newest = pending_.front().features;
    pending_.pop_front();
  }
  return newest;
}

}  // namespace vantage::sim
