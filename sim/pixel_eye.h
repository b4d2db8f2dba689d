#pragma once

#include "sim/eye.h"
#include "sim/grey_noise.h"
#include "sim/render/renderer.h"
#include "vantage/robot/arm_model.h"
#include "vantage/vision/marker_tracker.h"

namespace vantage::sim {

/// Renders the world, and finds the markers on the pixels.
class PixelEye final : public Eye {
 public:
  /// @param nominal      Camera as the detector believes it to be; the renderer has the true one.
  /// @param noise_grey   Standard deviation of a pixel [grey levels of 255].
  PixelEye(Renderer renderer, ArmModel arm, const CameraModel& nominal, double noise_grey,
           std::uint64_t seed);

  void See(Time now, const Eigen::Isometry3d& X_WC_true, const JointVector& q_true,
           const std::vector<MarkerPrediction>& predictions, ImageFeatures* features) override;

 private:
  Renderer renderer_;
  ArmModel arm_;
  GreyNoise noise_;
  MarkerTracker tracker_;
  GreyImage image_;
};

}  // namespace vantage::sim
