#pragma once

#include <functional>
#include <string>
#include <vector>

/// @file
/// Those who work on one sweep or grid check together: the ranks of an MPI job in vantage-plan-mpi, this process
/// alone in vantage-plan. Which of the two is settled when the program is linked.

namespace vantage {

/// Lives as long as the program works. One at a time.
class PlanTeam {
 public:
  /// The program's name.
  static const char* const kProgram;

  /// Throws ConfigError when the process was started as one of several but cannot work with them.
  PlanTeam(int* argc, char*** argv);
  ~PlanTeam();
  PlanTeam(const PlanTeam&) = delete;
  PlanTeam& operator=(const PlanTeam&) = delete;

  /// 0: this process prints and writes.
  [[nodiscard]] int rank() const noexcept;
  [[nodiscard]] int size() const noexcept;

  /// Hands items out one at a time, to whoever is free next (DealItems of plan_shard.h). Called on all ranks; the
  /// items are those of rank 0, the others wait for it. Results arrive on rank 0, which works too. When `work`
  /// throws on any rank the error is printed and the whole job ends.
  void Deal(const std::vector<int>& items, const std::function<std::string(int)>& work,
            const std::function<void(int, const std::string&)>& take);

  /// Before the program ends with an exit code: one that failed ends the whole job with it, as the others may be
  /// waiting for it.
  void Leave(int exit_code) const noexcept;
};

}  // namespace vantage
