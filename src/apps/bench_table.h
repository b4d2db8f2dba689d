#pragma once

#include <string>
#include <utility>
#include <vector>

#include "sim/suite/run_task.h"

namespace vantage {

/// Results of one scenario with one strategy, in the order of the seeds.
struct BenchRow {
  std::string scenario;  ///< "S1/puma560".
  std::string strategy;
  std::uint64_t first_seed{1};
  std::vector<sim::TaskResult> results;
};

/// Wilson's score interval of a share at 95 %.
/// @see E. B. Wilson, J. American Statistical Association 22, 1927.
[[nodiscard]] std::pair<double, double> WilsonInterval(std::size_t successes, std::size_t runs);

/// The table for people.
[[nodiscard]] std::string BenchTable(const std::vector<BenchRow>& rows);

/// The same with every failure by its seed: {"suite", ..., "rows": [...]}. The same results give the
/// same bytes. Throws Error when the file cannot be written.
void WriteBenchJson(const std::vector<BenchRow>& rows, const std::string& suite, bool kinematic,
                    const std::string& path);

}  // namespace vantage
