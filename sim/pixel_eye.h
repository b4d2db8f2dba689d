#pragma once

#include "sim/effects.h"
#include "sim/eye.h"
#include "sim/render/renderer.h"
#include "vantage/robot/arm_model.h"
#include "vantage/vision/marker_tracker.h"

namespace vantage::sim {

/// Renders the world, and finds the markers on the pixels.
class PixelEye final : public Eye {
 public:
  /// @param nominal  Camera as the detector believes it to be; the renderer has the true one.
  PixelEye(Renderer renderer, ArmModel arm, const CameraModel& nominal,
           const TrackerOptions& tracker, const ImageEffects& effects, std::uint64_t seed);

  void See(Time now, const Eigen::Isometry3d& X_WC_true, const JointVector& q_true,
           const Eigen::Isometry3d& X_WG, const std::vector<MarkerPrediction>& predictions,
           ImageFeatures* features) override;

 private:
  Renderer renderer_;
  ArmModel arm_;
  EffectChain chain_;
  MarkerTracker tracker_;
  GreyImage image_;
};

}  // namespace vantage::sim
