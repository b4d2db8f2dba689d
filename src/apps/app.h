#pragma once

#include <functional>
#include <string>

#include <CLI/CLI.hpp>

namespace vantage {

/// Exit codes of every program.
enum ExitCode : int {
  kExitOk = 0,
  kExitNotReached = 1,  ///< It ran, but did not reach its aim (vantage-run: not converged).
  kExitUsage = 2,       ///< Bad option, file, log or output folder. Nothing was started.
  kExitFailure = 3,     ///< Something else failed: a process, a disk, the network, the output.
};

/// main() of a program: adds --version and the exit codes to --help, parses, runs, and turns errors into one
/// line on stderr and an exit code. Output that could not be written is a failure.
/// @param not_reached  What exit code 1 says of this program; empty when it never ends with it.
int RunApp(CLI::App* app, int argc, char** argv, const std::string& not_reached,
           const std::function<int()>& run);

/// Makes the folder that an option names, and its parents. Throws ConfigError when that fails or nothing can be
/// written into it.
void MakeOutputFolder(const std::string& option, const std::string& folder);

/// For options that count: CLI11 itself takes -1 for a very large number.
[[nodiscard]] CLI::Validator WholeNumber();

/// Version of the product: "0.1.0".
[[nodiscard]] const char* Version();

}  // namespace vantage
