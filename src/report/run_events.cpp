#include "run_events.h"

#include <algorithm>

namespace vantage {
namespace {

double PathLength(const RunLog& log, double begin, double end) {
  double length = 0.0;
  const CameraPose* before = nullptr;
  for (const CameraPose& pose : log.camera_poses) {
    const double t = log.At(pose.stamp);
    if (t < begin) continue;
    if (t > end) break;
    if (before != nullptr) {
      length += (pose.X_WC.translation() - before->X_WC.translation()).norm();
    }
    before = &pose;
  }
  return length;
}

}  // namespace

std::vector<StateInterval> StatesOf(const RunLog& log) {
  std::vector<StateInterval> states;
  for (const ServoStatus& status : log.statuses) {
    const double t = log.At(status.stamp);
    if (!states.empty()) states.back().end = t;
    if (states.empty() || states.back().state != status.state ||
        states.back().reason != status.reason) {
      states.push_back({t, t, status.state, status.reason, status.error_px});
    }
  }
  return states;
}

std::vector<StateInterval> StopsOf(const std::vector<StateInterval>& states) {
  std::vector<StateInterval> stops;
  bool moved = false;
  for (const StateInterval& interval : states) {
    switch (interval.state) {
      case ServoState::kServoing:
      case ServoState::kRepositioning:
      case ServoState::kConverged:
        moved = true;
        break;
      case ServoState::kHolding:
      case ServoState::kFault:
      case ServoState::kIdle:
        if (moved) stops.push_back(interval);
        break;
      case ServoState::kAcquiring:
        break;
    }
  }
  return stops;
}

std::vector<CameraMove> CameraMovesOf(const RunLog& log) {
  std::vector<CameraMove> moves;
  bool moving = false;
  for (const ObservabilityReport& report : log.observability) {
    const double t = log.At(report.stamp);
    const bool now = report.active_state == ActiveState::kMoving;
    if (now && !moving) {
      CameraMove move;
      move.begin = t;
      move.reason = report.active_reason;
      move.cause = report.cause;
      move.trigger_before = report.trigger_value;
      move.mm_per_px_before = report.mm_per_px;
      moves.push_back(move);
    }
    if (now || moving) {
      moves.back().end = t;
      moves.back().trigger_after = report.trigger_value;
      moves.back().mm_per_px_after = report.mm_per_px;
    }
    moving = now;
  }
  if (log.camera_poses.empty()) return moves;
  for (CameraMove& move : moves) move.path = PathLength(log, move.begin, move.end);
  return moves;
}

std::vector<TriggerInterval> TriggersOf(const RunLog& log) {
  std::vector<TriggerInterval> triggers;
  bool fired = false;
  for (const ObservabilityReport& report : log.observability) {
    const double t = log.At(report.stamp);
    if (report.triggered && !fired) triggers.push_back({t, t, report.trigger_value});
    if (report.triggered || fired) triggers.back().end = t;
    if (report.triggered) {
      triggers.back().lowest = std::min(triggers.back().lowest, report.trigger_value);
    }
    fired = report.triggered;
  }
  return triggers;
}

}  // namespace vantage
