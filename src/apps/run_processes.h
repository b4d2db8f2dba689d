#pragma once

#include <optional>
#include <string>
#include <vector>

#include "run_console.h"
#include "run_folder.h"
#include "vantage/config/scenario.h"
#include "vantage/messaging/transport.h"

namespace vantage {

/// What came of a run.
struct RunOutcome {
  RunSummary summary;
  std::vector<RunSample> samples;
};

/// What the processes of a run are told.
struct ProcessRunOptions {
  std::string scenario;               ///< A name or a path.
  bool fixed_camera{false};           ///< The camera stays where it is.
  std::optional<std::uint64_t> seed;  ///< Of every random number; none: the scenario's.
  double image_rate{10.0};            ///< Of CAMERA_IMAGE [1/s].
  int priority{80};                   ///< Of the control thread; 0: none.
};

/// The scenario with real processes on the wall clock: starts vantage-sim, vantage-servo and a logger,
/// watches them over LCM, stops them at the end.
/// @param transport  That of ChooseTransport(): before the run folder is made.
/// Throws Error when one of them cannot be started or says nothing.
[[nodiscard]] RunOutcome RunProcesses(const ProcessRunOptions& options, const Transport& transport,
                                      const Scenario& scenario, const RunFolder& folder,
                                      RunConsole* console);

}  // namespace vantage
