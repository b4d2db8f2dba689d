#include "vantage/active/active_camera.h"

namespace vantage {

const char* Name(ActiveState state) noexcept {
  switch (state) {
    case ActiveState::kWatching:
      return "WATCHING";
    case ActiveState::kMoving:
      return "MOVING";
    case ActiveState::kDisabled:
      return "DISABLED";
  }
  return "UNKNOWN";
}

const char* Name(ActiveReason reason) noexcept {
  switch (reason) {
    case ActiveReason::kNone:
      return "NONE";
    case ActiveReason::kLowMeasure:
      return "LOW_MEASURE";
    case ActiveReason::kMarkerLost:
      return "MARKER_LOST";
    case ActiveReason::kMarkerAtRisk:
      return "MARKER_AT_RISK";
    case ActiveReason::kStalled:
      return "STALLED";
  }
  return "UNKNOWN";
}

const char* Name(ActiveRefusal refusal) noexcept {
  switch (refusal) {
    case ActiveRefusal::kNone:
      return "NONE";
    case ActiveRefusal::kArm:
      return "ARM";
    case ActiveRefusal::kNoBetterView:
      return "NO_BETTER_VIEW";
    case ActiveRefusal::kNoView:
      return "NO_VIEW";
    case ActiveRefusal::kNoPath:
      return "NO_PATH";
    case ActiveRefusal::kRigCannotMove:
      return "RIG_CANNOT_MOVE";
    case ActiveRefusal::kGuard:
      return "GUARD";
    case ActiveRefusal::kBadInputs:
      return "BAD_INPUTS";
  }
  return "?";
}

}  // namespace vantage
