#pragma once

#include "run_lockstep.h"
#include "vantage/messaging/transport.h"

namespace vantage {

struct ProcessRunOptions {
  std::string scenario;  ///< As given by the user: a name or a path.
  bool fixed_camera{false};
  std::optional<std::uint64_t> seed;
  double image_rate{10.0};  ///< Of CAMERA_IMAGE [1/s].
  int priority{80};         ///< Of the control thread; 0: none.
};

/// The scenario with real processes on the wall clock: starts vantage-sim, vantage-servo and a logger,
/// watches them over LCM, stops them at the end.
/// @param transport  That of ChooseTransport(): before the run folder is made.
/// Throws Error when one of them cannot be started or
/// says nothing.
[[nodiscard]] RunOutcome RunProcesses(const ProcessRunOptions& options, const Transport& transport,
                                      const Scenario& scenario, const RunFolder& folder,
                                      RunConsole* console);

}  // namespace vantage
