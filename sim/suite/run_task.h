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
  double true_error_mm{0.0};    ///< Worst marker.
  double joint_error_deg{0.0};  ///< Worst joint's distance to the goal's joints [deg].
  double error_px{0.0};
  double mm_per_px{0.0};
  std::int64_t lost_events{0};  ///< Times that a needed marker went out of sight.
  double travel_m{0.0};         ///< Way of the camera's centre.
  std::int64_t moves{0};
  std::int64_t limit_violations{0};
  std::string end;  ///< "converged", or the state and reason at the time limit.
};

/// Plays the scenario to its end in lockstep. Deterministic.
/// @param q_goal  Joints at the goal, for judging.
[[nodiscard]] TaskResult RunTask(const Scenario& scenario, const JointVector& q_goal);

}  // namespace vantage::sim
