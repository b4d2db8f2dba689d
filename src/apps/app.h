#pragma once

#include <functional>

#include <CLI/CLI.hpp>

namespace vantage {

/// Exit codes of every program.
enum ExitCode : int {
  kExitOk = 0,
  kExitNotReached = 1,  ///< It ran, but did not reach its aim (vantage-run: not converged).
  kExitUsage = 2,       ///< Bad option, scenario or robot file. Nothing was written.
  kExitFailure = 3,     ///< Something else failed: a process, a disk, the network.
};

/// main() of a program: adds --version, parses, runs, and turns errors into one line on stderr and an
/// exit code.
int RunApp(CLI::App* app, int argc, char** argv, const std::function<int()>& run);

/// Version of the product: "0.1.0".
[[nodiscard]] const char* Version();

}  // namespace vantage
