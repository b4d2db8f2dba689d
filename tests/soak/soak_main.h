#pragma once

#include <cstdint>
#include <string>

#include <CLI/CLI.hpp>

namespace vantage::soak {

/// The command line of a soak: reads --minutes and --seed and calls run(minutes, seed), whose exit code it returns.
/// @param what_minutes  What the minutes are of.
template <typename Run>
int SoakMain(int argc, char** argv, const char* name, const char* description, double minutes,
             const char* what_minutes, const Run& run) {
  std::uint64_t seed = 1;
  CLI::App app(description, name);
  app.add_option("--minutes", minutes, what_minutes)
      ->capture_default_str()
      ->check(CLI::Range(0.1, 1e6));
  app.add_option("--seed", seed, "Of everything that is random")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  return run(minutes, seed);
}

}  // namespace vantage::soak
