#include "sim/pixel_eye.h"

#include "vantage/robot/kinematics.h"

namespace vantage::sim {

PixelEye::PixelEye(Renderer renderer, ArmModel arm, const CameraModel& nominal,
                   const TrackerOptions& tracker, const ImageEffects& effects, std::uint64_t seed)
    : renderer_(std::move(renderer)),
      arm_(std::move(arm)),
      chain_(effects, seed),
      tracker_(nominal, tracker) {}

void PixelEye::See(Time now, const Eigen::Isometry3d& X_WC_true, const JointVector& q_true,
                   const Eigen::Isometry3d& X_WG, const std::vector<MarkerPrediction>& predictions,
                   ImageFeatures* features) {
  const SceneState truth{ComputeLinkPoses(arm_, q_true), EndEffectorPose(arm_, q_true), X_WG};
  const MarkerTracker::SearchPlan& plan = tracker_.Plan(predictions, now);
  chain_.Begin(now);
  if (plan.whole_image) {
    renderer_.RenderGrey(X_WC_true, truth, &image_);
    chain_.Apply(&image_);
  } else {
    renderer_.RenderGrey(X_WC_true, truth, Grow(plan.windows, chain_.margin()), &image_);
    chain_.Apply(plan.windows, &image_);
  }
  tracker_.Track(View(image_), predictions, now);
  tracker_.Publish(features);
}

}  // namespace vantage::sim
