#pragma once

#include <vector>

#include "vantage/active/view_planner.h"

namespace vantage {

/// Goal points that do not fit the arm's exactly never will: a solution whose rms distance from them is this
/// many times that of the first one is as good.
inline constexpr double kFitSlack = 1.5;

/// Where the arm's joints may end, and what the way there has against it.
struct Branch {
  JointVector q;             ///< Joints at the goal; empty: out of reach.
  double fit{0.0};           ///< Rms distance from the goal points that q leaves [m].
  double time{0.0};          ///< At the joints' greatest speeds [s].
  bool at_limit{false};      ///< A joint ends at its limit: an error of its encoder is too much.
  bool touches_goal{false};  ///< The arm or a marker of its would run into a marker of the goal.
  bool unwatchable{false};   ///< No view of the rig's sees every marker all the way.
  bool passes_singularity{
      false};  ///< In between the joints move the markers hardly in some direction.
};

/// Whether the plate of a marker of the arm would run into the plate of one of the goal's.
[[nodiscard]] bool PlatesTouch(const std::vector<PlacedMarker>& arm_markers,
                               const std::vector<PlacedMarker>& goal_markers) noexcept;

/// What a branch is chosen for.
struct BranchRequest {
  JointVector q;                           ///< Joints now.
  std::vector<Eigen::Vector3d> p_EM;       ///< Markers in the end effector's frame [m].
  std::vector<Eigen::Vector3d> p_WG;       ///< Their goal points in the world [m].
  std::vector<PlacedMarker> goal_markers;  ///< The goal's own in the scene; may be empty.
  RigVector q_c;                           ///< Where the camera is.
  std::vector<JointVector> failed;         ///< Branches that are left out.
};

/// Solves for the goal's joints from the present ones and from random starts (always the same), and takes
/// the solution whose straight way in the joints has least against it: that ends at no limit, runs into
/// nothing, is watched by some view, passes no singularity, in this order; of equals the nearest. A pure function; takes
/// milliseconds.
/// @param solved  A solution nearer than this to every goal point is one [m].
[[nodiscard]] Branch ChooseBranch(const ViewModel& view, const CameraRig& rig,
                                  const PlannerOptions& planner, const BranchRequest& request,
                                  double solved);

}  // namespace vantage
