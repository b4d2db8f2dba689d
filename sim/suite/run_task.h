#pragma once

#include <cstdint>
#include <string>

#include "sim/suite/strategy.h"
#include "sim/suite/suite.h"

namespace vantage::sim {

/// A task counts as done when no marker is further from its goal point than this [mm].
inline constexpr double kSuccessMillimetres = 2.0;

/// How one task ended.
struct TaskResult {
  bool success{false};          ///< Converged, and the true error is below kSuccessMillimetres.
  bool converged{false};        ///< The servo said so.
  double duration{0.0};         ///< Simulated time until it converged or gave up [s].
  double true_error_mm{0.0};    ///< Worst marker, at the end; of a goal that moves: see RunTask().
  double joint_error_deg{0.0};  ///< Worst joint's distance to the goal's joints [deg].
  double error_px{0.0};
  double mm_per_px{0.0};
  std::int64_t lost_events{0};  ///< Times that a needed marker went out of sight.
  double travel_m{0.0};         ///< Way of the camera's centre.
  std::int64_t moves{0};
  std::int64_t limit_violations{0};
  double low_share{0.0};  ///< Share of the time that the trigger's measure was below its threshold.
  int goals_reached{0};   ///< Of a sequence; 1 of a single goal that was reached.
  std::string end;        ///< "converged", or the state and reason at the time limit.
};

/// A goal that moves counts as followed when, from this time on [s], no marker is further from its goal
/// point than that [mm] for 95 % of the time; this share's error is the result's true_error_mm.
inline constexpr double kFollowFrom = 15.0;
inline constexpr double kFollowMillimetres = 10.0;

/// The next goal of a sequence, from where arm and camera stand.
/// @param before  The scenario of the goal before, as a strategy plays it.
[[nodiscard]] Scenario NextStage(const Scenario& before, const GoalStage& next,
                                 const JointVector& q, const RigVector& q_c);

/// Plays the task to its end in lockstep: until it has converged, all its goals one after the other (the
/// arm and the camera stay where they are in between), or for the whole time limit where the goal moves.
/// Deterministic.
/// @param scenario  The task's, as a strategy plays it.
[[nodiscard]] TaskResult RunTask(const Scenario& scenario, const SuiteTask& task);

}  // namespace vantage::sim
