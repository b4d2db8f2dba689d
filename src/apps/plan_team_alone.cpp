// One process: vantage-plan without MPI.

#include <cstdlib>
#include <string>

#include "plan_shard.h"
#include "plan_team.h"
#include "vantage/math/error.h"

namespace vantage {

const char* const PlanTeam::kProgram = "vantage-plan";

PlanTeam::PlanTeam(int* /*argc*/, char*** /*argv*/) {
  // Started by mpirun (Open MPI, MPICH) as one of many, each would do all the work and write the same files.
  for (const char* variable : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE"}) {
    const char* size = std::getenv(variable);
    if (size != nullptr && std::atoi(size) > 1) {
      throw ConfigError(
          "", "",
          std::string("one of ") + size +
              " processes of an MPI job, but without MPI: start vantage-plan-mpi, or cut "
              "the work with --shard i/N");
    }
  }
}

PlanTeam::~PlanTeam() = default;

int PlanTeam::rank() const noexcept {
  return 0;
}

int PlanTeam::size() const noexcept {
  return 1;
}

void PlanTeam::Deal(const std::vector<int>& items, const std::function<std::string(int)>& work,
                    const std::function<void(int, const std::string&)>& take) {
  DealToMyself(items, work, take);
}

void PlanTeam::Leave(int /*exit_code*/) const noexcept {}

}  // namespace vantage
