#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <random>
#include <vector>

#include "sim/eye.h"
#include "vantage/camera/camera_pose.h"
#include "vantage/config/sim_options.h"
#include "vantage/features/marker.h"
#include "vantage/robot/arm_model.h"

namespace vantage::sim {

/// What the camera's driver knows: nominal models, never the truth.
struct CameraKnowledge {
  ArmModel arm;
  CameraModel camera;                ///< Nominal.
  std::vector<Marker> tool_markers;  ///< In E.
  std::vector<Marker> goal_markers;  ///< In W, where they are believed to be.
};

/// A camera with its driver: takes images of the world at its rate, has the markers found in them, and
/// hands the features out after the latency.
class CameraDriver {
 public:
  CameraDriver(std::unique_ptr<Eye> eye, CameraKnowledge knowledge, const CameraEffects& effects,
               std::uint64_t seed);

  /// The first image is due at `now`.
  void Start(Time now) noexcept { next_exposure_ = now; }

  /// True when the next image is due at `now`.
  [[nodiscard]] bool Due(Time now) const noexcept { return now >= next_exposure_; }

  /// Takes an image of the true state. The measured pose and joints go into the markers' prediction.
  void Expose(Time now, const Eigen::Isometry3d& X_WC_true, const JointVector& q_true,
              const Eigen::Isometry3d& X_WG_true, const Eigen::Isometry3d& X_WC_measured,
              const JointVector& q_measured);

  /// The newest features whose latency has passed, once each.
  [[nodiscard]] std::optional<ImageFeatures> Deliver(Time now);

 private:
  struct Pending {
    Time due;
    ImageFeatures features;
  };

  std::unique_ptr<Eye> eye_;
  CameraKnowledge knowledge_;
  CameraEffects effects_;
  std::mt19937_64 random_;
  std::vector<MarkerPrediction> predictions_;
  std::deque<Pending> pending_;
  Time next_exposure_{};
};

}  // namespace vantage::sim
