#include "sim/pixel_eye.h"

#include "vantage/robot/kinematics.h"

namespace vantage::sim {

PixelEye::PixelEye(Renderer renderer, ArmModel arm, const CameraModel& nominal, double noise_grey,
                   std::uint64_t seed)
    : renderer_(std::move(renderer)),
      arm_(std::move(arm)),
      noise_(noise_grey, seed),
      tracker_(nominal, TrackerOptions()) {}

void PixelEye::See(Time now, const Eigen::Isometry3d& X_WC_true, const JointVector& q_true,
                   const std::vector<MarkerPrediction>& predictions, ImageFeatures* features) {
  const SceneState truth{ComputeLinkPoses(arm_, q_true), EndEffectorPose(arm_, q_true)};
  const MarkerTracker::SearchPlan& plan = tracker_.Plan(predictions, now);
  if (plan.whole_image) {
    renderer_.RenderGrey(X_WC_true, truth, &image_);
    noise_.Add(&image_);
  } else {
    renderer_.RenderGrey(X_WC_true, truth, plan.windows, &image_);
    noise_.Add(&image_, plan.windows);
  }
  tracker_.Track(View(image_), predictions, now);
  tracker_.Publish(features);
}

}  // namespace vantage::sim
