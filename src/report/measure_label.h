#pragma once

#include "vantage/active/trigger.h"

namespace vantage {

/// Name and unit of a trigger's measure, as gnuplot's enhanced text.
[[nodiscard]] inline const char* MeasureLabel(TriggerMeasure measure) {
  switch (measure) {
    case TriggerMeasure::kGeometricMean:
      return "w_c^{1/s} [px/rad]";
    case TriggerMeasure::kCompositeW:
      return "w_c";
    case TriggerMeasure::kSigmaMin:
      return "σ_{min} of J_c [px/rad]";
    case TriggerMeasure::kInverseCondition:
      return "1 / condition of J_c";
  }
  return "";
}

}  // namespace vantage
