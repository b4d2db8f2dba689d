#pragma once

#include <vector>

#include <Eigen/Geometry>

#include "vantage/active/view_planner.h"
#include "vantage/camera/camera_rig.h"
#include "view_scene.h"

/// @file
/// The best views of a rig's workspace: occlusion, which is dear, is checked late.

namespace vantage {

/// One view under consideration. Before occlusion is checked `view` may promise too much.
struct ViewCandidate {
  RigVector q_c;
  Eigen::Isometry3d X_WC;
  SampleValues values;
  ViewScore view;
  double uncertified{0.0};
  double travel{0.0};   ///< [m + rad]
  double worth{0.0};    ///< Score less the cost of travel.
  bool checked{false};  ///< For occlusion.
};

/// Scores views of one request. Keeps references to what it is made of.
class ViewSearch {
 public:
  ViewSearch(const ViewScene& scene, const CameraRig& rig, const PlannerOptions& options,
             const RigVector& from);

  /// Scores everything but occlusion.
  [[nodiscard]] ViewCandidate Open(const RigVector& q_c);

  /// Checks for occlusion; the worth may fall.
  void Close(ViewCandidate* c) const;

  /// `count` views over the workspace, each with the best of its rolls.
  [[nodiscard]] std::vector<ViewCandidate> OpenWorkspace(const Eigen::Vector3d& aim_W, int count,
                                                         bool roll_matters);

  /// Climbs from a view by single steps along the axes, which become smaller.
  [[nodiscard]] ViewCandidate Refine(const Eigen::Vector3d& aim_W, ViewCandidate best);

  [[nodiscard]] int scored() const noexcept { return scored_; }

 private:
  void Rate(ViewCandidate* c) const;

  const ViewScene& scene_;
  const CameraRig& rig_;
  const PlannerOptions& options_;
  RigVector from_;
  Eigen::Isometry3d X_WFrom_;
  int scored_{0};
};

}  // namespace vantage
