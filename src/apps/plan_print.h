#pragma once

#include <optional>
#include <string>

#include "plan_shard.h"
#include "progress_bar.h"
#include "vantage/config/placement_file.h"
#include "vantage/plan/grid_check.h"

/// @file
/// What vantage-plan says on the terminal.

namespace vantage {

/// The stage and the best value so far.
class PlanProgressBar {
 public:
  explicit PlanProgressBar(bool quiet);
  void operator()(const std::string& stage, double share, const std::optional<double>& best);
  void End();

 private:
  ProgressBar bar_;
  double share_{0.0};
  std::optional<double> best_;
};

/// "R 0.95 m, theta 34.12 deg, ...".
[[nodiscard]] std::string CoordinatesText(const CameraRig& rig, const RigVector& q_c);
/// What is made great: "the integral of w_c over 4 s (eq. 14)".
[[nodiscard]] std::string ObjectiveText(const PlacementProblem& problem);
/// Line by line: the best camera, what holds it back, what it is worth beside the others.
[[nodiscard]] std::string ResultText(const PlacementSetup& setup, const PlacementModel& model,
                                     const PlacementResult& result, double seconds);
/// Which limits make the problem infeasible, and by how much.
[[nodiscard]] std::string InfeasibleText(const PlacementSetup& setup,
                                         const PlacementResult& result);
[[nodiscard]] std::string PathText(const PlacementModel& model, const CameraPathResult& result,
                                   double seconds);
/// What a shard found of its part of the grid.
[[nodiscard]] std::string GridPartText(const PlacementModel& model, const Shard& shard,
                                       const SearchedGrid& grid);
[[nodiscard]] std::string GridCheckText(const GridCheck& check);

}  // namespace vantage
