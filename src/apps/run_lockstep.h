#pragma once

#include "run_console.h"
#include "run_folder.h"
#include "sim/lockstep.h"
#include "vantage/config/scenario.h"

namespace vantage {

/// The scenario in simulated time, in this process; the folder gets the camera's first and last picture.
[[nodiscard]] sim::LockstepRun RunInLockstep(const Scenario& scenario, const RunFolder& folder,
                                             RunConsole* console,
                                             sim::RunUntil until = sim::RunUntil::kConverged);

}  // namespace vantage
