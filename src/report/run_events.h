#pragma once

#include <optional>
#include <vector>

#include "run_log.h"

/// @file
/// What happened in a run, as intervals of its time axis.

namespace vantage {

/// A time in which the servo's state and reason stayed the same.
struct StateInterval {
  double begin{0.0}, end{0.0};  ///< [s].
  ServoState state{ServoState::kIdle};
  HoldReason reason{HoldReason::kNone};
  double error_px{0.0};  ///< At its begin.
  [[nodiscard]] double duration() const { return end - begin; }
};

/// A move of the camera.
struct CameraMove {
  double begin{0.0}, end{0.0};  ///< [s].
  ActiveReason reason{ActiveReason::kNone};
  LowCause cause{LowCause::kNone};                 ///< At its begin.
  double trigger_before{0.0}, trigger_after{0.0};  ///< The trigger's measure.
  double mm_per_px_before{0.0}, mm_per_px_after{0.0};
  std::optional<double> path;  ///< Way of the camera's centre [m]; nullopt without CAMERA_POSE.
};

/// A time in which the trigger was fired.
struct TriggerInterval {
  double begin{0.0}, end{0.0};  ///< [s].
  double lowest{0.0};           ///< Of the trigger's measure.
};

[[nodiscard]] std::vector<StateInterval> StatesOf(const RunLog& log);
[[nodiscard]] std::vector<CameraMove> CameraMovesOf(const RunLog& log);
[[nodiscard]] std::vector<TriggerInterval> TriggersOf(const RunLog& log);

/// The intervals in which a servo that had moved before did not: HOLDING, FAULT, or stopped (IDLE).
[[nodiscard]] std::vector<StateInterval> StopsOf(const std::vector<StateInterval>& states);

}  // namespace vantage
