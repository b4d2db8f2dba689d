#pragma once

#include <string>
#include <utility>
#include <vector>

#include "vantage/observability/measures.h"

/// @file
/// When the view is too poor: a threshold with hysteresis and debouncing on one measure of J_c.

namespace vantage {

/// Which measure the trigger compares with its threshold.
enum class TriggerMeasure : int {
  kGeometricMean = 0,  ///< w_c^(1/s), the geometric mean singular value of J_c [px/rad].
  kCompositeW,         ///< w_c itself [px^s/rad^s].
  kSigmaMin,           ///< σ_min of J_c [px/rad].
  kInverseCondition,   ///< σ_min / σ_max of J_c [-].
};

/// Settings of a trigger.
struct TriggerOptions {
  TriggerMeasure measure{TriggerMeasure::kGeometricMean};  ///< What is compared with the threshold.
  double threshold{120.0};  ///< The camera moves below it, in the measure's unit; > 0.
  double hysteresis{1.2};   ///< Re-armed above hysteresis * threshold; >= 1.
  int debounce{3};          ///< Consecutive evaluations below the threshold that fire; >= 1.
};

/// Throws ConfigError (key "active.trigger...") when an option is out of bounds.
void Validate(const TriggerOptions& options);

/// The measure a trigger compares, from the composite Jacobian's singular values. 0 without any.
[[nodiscard]] double TriggerValue(TriggerMeasure measure, const Measure& composite) noexcept;

/// The measures by the names that files and command lines have for them: "geometric_mean", ...
[[nodiscard]] const std::vector<std::pair<std::string, TriggerMeasure>>& TriggerMeasureKeys();

/// Name as printed: "w_c^(1/s)", "w_c", ...
[[nodiscard]] const char* Name(TriggerMeasure measure) noexcept;

/// What the trigger remembers.
struct TriggerState {
  int below{0};           ///< Evaluations below the threshold in a row.
  bool triggered{false};  ///< Fired, and not yet back above hysteresis * threshold.
  bool fired{false};      ///< This evaluation is the one that fired.
};

/// The state after one more evaluation. A value that is not finite counts as below: nothing good is
/// known of the view. Real-time safe.
[[nodiscard]] TriggerState UpdateTrigger(const TriggerOptions& options, const TriggerState& state,
                                         double value) noexcept;

}  // namespace vantage
