#pragma once

#include <deque>
#include <optional>
#include <random>
#include <vector>

#include "sim/effects.h"
#include "sim/render/renderer.h"
#include "vantage/camera/camera_pose.h"
#include "vantage/config/sim_options.h"
#include "vantage/features/marker.h"
#include "vantage/robot/arm_model.h"
#include "vantage/vision/marker_tracker.h"

namespace vantage::sim {

/// What the camera's driver knows: nominal models, never the truth.
struct CameraKnowledge {
  ArmModel arm;
  CameraModel camera;                ///< Nominal.
  std::vector<Marker> tool_markers;  ///< In E.
  std::vector<Marker> goal_markers;  ///< In W, where they are believed to be.
  TrackerOptions tracker;
};

/// A camera with its driver: takes images of the rendered world at its rate, finds the markers on the
/// pixels, and hands the features out after the latency.
class CameraDriver {
 public:
  CameraDriver(Renderer renderer, CameraKnowledge knowledge, const CameraEffects& effects,
               std::uint64_t seed);

  /// The first image is due at `now`.
  void Start(Time now) noexcept { next_exposure_ = now; }

  /// True when the next image is due at `now`.
  [[nodiscard]] bool Due(Time now) const noexcept { return now >= next_exposure_; }

  /// Takes an image of the true state. The measured pose and joints go into the markers' prediction.
  void Expose(Time now, const Eigen::Isometry3d& X_WC_true, const SceneState& truth,
              const Eigen::Isometry3d& X_WC_measured, const JointVector& q_measured);

  /// The newest features whose latency has passed, once each.
  [[nodiscard]] std::optional<ImageFeatures> Deliver(Time now);

  /// What became of each marker in the last image: the arm's, then the goal's.
  [[nodiscard]] const MarkerDetections& detections() const noexcept {
    return tracker_.detections();
  }

 private:
  struct Pending {
    Time due;
    ImageFeatures features;
  };

  Renderer renderer_;
  CameraKnowledge knowledge_;
  CameraEffects effects_;
  EffectChain chain_;
  std::mt19937_64 random_;
  MarkerTracker tracker_;
  std::vector<MarkerPrediction> predictions_;
  GreyImage image_;
  std::deque<Pending> pending_;
  Time next_exposure_{};
};

}  // namespace vantage::sim
