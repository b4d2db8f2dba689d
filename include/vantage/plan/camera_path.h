#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "vantage/plan/placement.h"

/// @file
/// How a camera should move along with the arm (paper, eq. 15): a path problem, because its rig has speed
/// limits (docs/placement.md).

namespace vantage {

/// Rig coordinates at each sample of the motion, straight lines in between.
struct CameraPath {
  std::vector<RigVector> q_c;  ///< One entry a sample [m or rad].
  double value{0.0};  ///< The objective along it; where limits are broken, without those samples.
  int broken{0};      ///< Samples at which a limit is broken; 0: feasible.
};

/// Settings of the search for a path.
struct CameraPathSearch {
  int states{800};  ///< Camera coordinates of the finest coarse lattice; >= 2.
  int rounds{120};  ///< Refinements of the best path in a tube about it.
};

/// A camera path with what it cost to find.
struct CameraPathResult {
  CameraPath path;              ///< The best path found.
  CameraPath fixed;             ///< The best camera that stands still, for the same objective.
  std::int64_t evaluations{0};  ///< Jacobians measured.
};

/// Value and broken limits of a path, sample by sample. @pre one q_c for each sample.
[[nodiscard]] CameraPath JudgePath(const PlacementModel& model, std::vector<RigVector> q_c);

/// True when no axis and not the camera's centre moves faster than the rig allows between samples.
[[nodiscard]] bool KeepsSpeeds(const PlacementModel& model, const CameraPath& path);

/// The best path found: dynamic programming over coarse lattices in time and rig coordinates, then over ever
/// finer ones in a tube about the paths that these give. Never worse than the best fixed camera. The start is free.
///
/// Throws ConfigError (key "objective.over") for the worst case over the motion, and where the pose is
/// uncertain: those are of fixed cameras.
[[nodiscard]] CameraPathResult PlanCameraPath(const PlacementModel& model,
                                              const PlacedCamera& best_fixed,
                                              const CameraPathSearch& search = {},
                                              const PlanProgress& progress = {});

/// Refines samples [first, first + count) of a path by `rounds` tubes; the rest, and q_c[first] when
/// `hold_first`, stay. With the window moving along this is a planner with a receding horizon.
/// Returns what the window's samples gained.
double RefineWindow(const PlacementModel& model, int first, int count, int rounds, bool hold_first,
                    CameraPath* path);

/// The best sequence of states by dynamic programming (R. Bellman, "Dynamic Programming", 1957).
///
/// @param value        N×S: of each state at each step; -inf: not allowed.
/// @param predecessor  For each state those that it may follow, itself among them if it may stay.
/// @return one state a step; empty when there is no sequence.
[[nodiscard]] std::vector<int> BestSequence(const Eigen::MatrixXd& value,
                                            const std::vector<std::vector<int>>& predecessor);

}  // namespace vantage
