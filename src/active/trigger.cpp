#include "vantage/active/trigger.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "vantage/math/error.h"

namespace vantage {

void Validate(const TriggerOptions& options) {
  if (!(options.threshold > 0.0) || !std::isfinite(options.threshold)) {
    throw ConfigError("", "active.trigger.threshold",
                      "must be > 0, is " + std::to_string(options.threshold));
  }
  if (!(options.hysteresis >= 1.0) || !std::isfinite(options.hysteresis)) {
    throw ConfigError("", "active.trigger.hysteresis",
                      "must be >= 1, is " + std::to_string(options.hysteresis));
  }
  if (options.debounce < 1) {
    throw ConfigError("", "active.trigger.debounce",
                      "must be >= 1, is " + std::to_string(options.debounce));
  }
}

double TriggerValue(TriggerMeasure measure, const Measure& composite) noexcept {
  if (composite.sigma.size() == 0) return 0.0;
  switch (measure) {
    case TriggerMeasure::kGeometricMean:
      return composite.geometric_mean();
    case TriggerMeasure::kCompositeW:
      return composite.w;
    case TriggerMeasure::kSigmaMin:
      return composite.sigma_min;
    case TriggerMeasure::kInverseCondition:
      return composite.sigma(0) > 0.0 ? composite.sigma_min / composite.sigma(0) : 0.0;
  }
  return std::numeric_limits<double>::quiet_NaN();
}

const std::vector<std::pair<std::string, TriggerMeasure>>& TriggerMeasureKeys() {
  static const std::vector<std::pair<std::string, TriggerMeasure>> keys{
      {"geometric_mean", TriggerMeasure::kGeometricMean},
      {"composite_w", TriggerMeasure::kCompositeW},
      {"sigma_min", TriggerMeasure::kSigmaMin},
      {"inverse_condition", TriggerMeasure::kInverseCondition}};
  return keys;
}

const char* Name(TriggerMeasure measure) noexcept {
  switch (measure) {
    case TriggerMeasure::kGeometricMean:
      return "w_c^(1/s)";
    case TriggerMeasure::kCompositeW:
      return "w_c";
    case TriggerMeasure::kSigmaMin:
      return "sigma_min";
    case TriggerMeasure::kInverseCondition:
      return "1/cond";
  }
  return "UNKNOWN";
}

TriggerState UpdateTrigger(const TriggerOptions& options, const TriggerState& state,
                           double value) noexcept {
  TriggerState next = state;
  next.fired = false;
  const bool below = !(value >= options.threshold);  // A NaN is below.
  next.below = below ? std::min(state.below + 1, options.debounce) : 0;
  if (state.triggered) {
    next.triggered = !(value > options.hysteresis * options.threshold);
  } else if (next.below >= options.debounce) {
    next.triggered = true;
    next.fired = true;
  }
  return next;
}

}  // namespace vantage
