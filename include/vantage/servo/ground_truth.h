#pragma once

#include <cstdint>

#include "vantage/math/sizes.h"
#include "vantage/math/time.h"

namespace vantage {

/// What only a simulator can know: content of the SIM_TRUTH channel. For reports and tests; a
/// controller has no access to it.
struct GroundTruth {
  Time stamp{};                      ///< When this was true, on the simulator's clock.
  JointVector q;                     ///< True joints [rad or m].
  double worst_error{0.0};           ///< Largest distance of a marker to its goal point [m].
  double rms_error{0.0};             ///< Root mean square of the same [m].
  std::int64_t limit_violations{0};  ///< Commands and motion outside the arm's limits so far.
};

}  // namespace vantage
