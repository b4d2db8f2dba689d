#pragma once

#include <string>

#include "measure_evaluate.h"

namespace vantage {

/// The measurement as one JSON object, indented, with stable keys. Matrices are lists of rows; what is
/// infinite (log w of 0, the condition of a singular J) or does not apply is null. Numbers keep all
/// digits.
[[nodiscard]] std::string ToJson(const MeasureSetup& setup, const MeasureReport& report);

/// The same for people: aligned tables, ends with a line break.
[[nodiscard]] std::string ToTable(const MeasureSetup& setup, const MeasureReport& report);

}  // namespace vantage
