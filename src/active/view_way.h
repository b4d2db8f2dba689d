#pragma once

#include <Eigen/Core>

#include "vantage/active/rig_motion.h"
#include "view_scene.h"
#include "view_search.h"

/// @file
/// Ways of the camera on which the markers stay in sight.

namespace vantage {

struct ViewWay {
  RigPath path;
  double duration{0.0};  ///< [s]
  int losses{0};         ///< Markers that go out of sight on it.
  bool found{false};
};

/// The fastest way that loses no marker; where some may be lost, the one with the fewest losses.
[[nodiscard]] ViewWay FindWay(const ViewScene& scene, const CameraRig& rig,
                              const PlanRequest& request, const Eigen::Vector3d& aim_W,
                              const ViewCandidate& to, MarkerSet seen_at_start);

}  // namespace vantage
