#pragma once

#include "run_console.h"
#include "run_folder.h"
#include "vantage/config/scenario.h"

namespace vantage {

/// What came of a run.
struct RunOutcome {
  RunSummary summary;
  std::vector<RunSample> samples;
};

/// The scenario in simulated time, in this process.
[[nodiscard]] RunOutcome RunInLockstep(const Scenario& scenario, const RunFolder& folder,
                                       RunConsole* console);

}  // namespace vantage
