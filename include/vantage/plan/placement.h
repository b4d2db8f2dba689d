#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "vantage/plan/placement_model.h"

/// @file
/// Where a camera should stand: global search, then polish (docs/placement.md).

namespace vantage {

/// Effort of a search. The defaults reach the global optimum of the benchmark's instances; they grow
/// with the number of free axes where they are 0.
struct PlacementSearch {
  int grid{0};     ///< Cameras scored at first; 0: 2560 for up to 4 free axes, else 40960.
  int starts{0};   ///< Hills that are climbed; 0: 16, or 192 by slopes, or 128 by evolution.
  int members{0};  ///< Of a generation of an evolution strategy; 0: 16 or 24.
  /// Of the evolution; 0: 24 or 80, but none with more than 4 free axes where slopes lead up: the integral of w or
  /// log w, from starts that all keep the limits.
  int generations{0};
  /// Best ends that are polished; twice as many of hills that were climbed by slopes.
  int polished{6};
  std::uint64_t seed{1};  ///< Of the evolution strategies' random numbers.
};

/// A limit that holds the optimum back.
struct ActiveLimit {
  std::string name;    ///< "field of view", "R, lower end", ...
  double margin{0.0};  ///< What is left of it [m], or of an axis' range [m or rad].
};

/// One camera and what it is worth.
struct PlacedCamera {
  RigVector q_c;                                          ///< Rig coordinates [m or rad].
  Eigen::Isometry3d X_WC{Eigen::Isometry3d::Identity()};  ///< The pose at q_c.
  double value{0.0};      ///< Of the objective: the paper's cost with the sign turned.
  PlanMargins margins{};  ///< Worst over motion, markers and perturbed poses [m].
  bool feasible{false};   ///< Every margin is kept, up to kMarginTolerance.
};

/// What one limit does to an infeasible problem.
struct LimitDiagnosis {
  std::string name;  ///< Of the limit: "least depth", "field of view", ...
  /// Best margin any camera tried has in this limit alone [m]: negative: it cannot be kept by itself.
  double best_margin{0.0};
  /// Margin at the camera that is nearest to keeping everything [m].
  double margin_at_nearest{0.0};
  /// Cameras are found that keep all other limits.
  bool alone_prevents{false};
};

/// A problem whose least value over the motion is not what the samples say (docs/paper.md, eq. 16).
struct WorstCaseWarning {
  /// What makes a sampled minimum worthless.
  enum class Kind {
    kNone,
    kChangesSign,  ///< det J_c changes its sign between two samples: the least value is 0 there.
    kArmSingular,  ///< At a sample J_c loses rank for every camera: the least value is 0 for all.
  };
  Kind kind{Kind::kNone};  ///< kNone: the samples can be believed.
  int sample{-1};          ///< The first such sample.
  double time{0.0};        ///< Of it [s].
};

/// Outcome of a search for a fixed camera.
struct PlacementResult {
  PlacedCamera
      best;  ///< feasible is false when no camera keeps all limits: then the nearest to it.
  PlacedCamera worst;               ///< The least good of the feasible cameras of the first grid.
  PlacedCamera start;               ///< The camera at q_c_start.
  std::vector<ActiveLimit> active;  ///< Limits that hold `best` back.
  std::vector<LimitDiagnosis> diagnosis;  ///< Empty where a camera was found.
  WorstCaseWarning warning;               ///< Of PlanAggregate::kWorst alone.
  std::int64_t evaluations{0};            ///< Jacobians measured.
  std::int64_t cameras{0};                ///< Cameras scored.
};

/// Told now and then how far a search is (share of its work) and the best value so far, if any.
using PlanProgress =
    std::function<void(const std::string& stage, double share, const std::optional<double>& best)>;

/// The camera with the greatest value that keeps all limits. The same problem and search give the same
/// result.
[[nodiscard]] PlacementResult PlaceCamera(const PlacementModel& model,
                                          const PlacementSearch& search = {},
                                          const PlanProgress& progress = {});

/// Value and margins of one camera.
[[nodiscard]] PlacedCamera JudgeCamera(const PlacementModel& model, const RigVector& q_c);

/// Values over two free axes of the rig, the others as in `q_c`; where a camera steps back along its
/// optical axis it does so just as far as field of view and least depth need.
struct PlacementMap {
  int axis_x{0};  ///< Rig axis that `x` is of.
  int axis_y{1};  ///< Rig axis that `y` is of.
  /// Values of axis_x, evenly from its lower to its upper limit [m or rad].
  std::vector<double> x;
  std::vector<double> y;            ///< The same of axis_y [m or rad].
  std::vector<PlacedCamera> cells;  ///< x.size() · y.size(), row by row of y.
};
/// The objective over two axes of the rig about q_c; NaN where a limit is broken.
[[nodiscard]] PlacementMap MapPlacements(const PlacementModel& model, const RigVector& q_c,
                                         int axis_x, int axis_y, int columns, int rows);

}  // namespace vantage
