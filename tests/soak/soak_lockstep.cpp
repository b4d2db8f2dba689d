// soak_lockstep [--minutes M] [--seed S]: hours of servo on simulated time, with goals and faults at random. One
// task after another of the suite's bad starts, drawn and detected, while messages are lost, frozen, damaged or
// stamped wrong. In every period: the command is finite and within the limits, the plant's monitor has counted
// nothing, and just the messages are refused that had to be. At the end: most goals were reached, and the memory
// is no larger than it was.

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "faults.h"
#include "memory.h"
#include "sim/lockstep.h"
#include "sim/suite/suite.h"
#include "soak_main.h"

namespace vantage::soak {
namespace {

// Memory may grow by this after so many tasks, all arms among them: allocators keep what they had.
constexpr int kSettled = 20;
constexpr double kMostGrowth = 8.0;  // [MiB]
// Of the goals: faults cost time, and a task has a minute.
constexpr double kLeastReached = 0.8;

struct Totals {
  double seconds{0.0};
  std::int64_t periods{0};
  int tasks{0}, reached{0};
  std::int64_t refused{0}, stops{0}, violations{0}, broken{0};
};

// Prints the first few, counts all.
void Broken(Totals* totals, const std::string& task, double time, const char* what) {
  if (++totals->broken <= 20) std::printf("BROKEN %s at %.3f s: %s\n", task.c_str(), time, what);
}

void CheckCommand(const ServoOutput& output, const std::vector<JointLimits>& limits,
                  const std::string& task, double time, Totals* totals) {
  const JointVector& qdot = output.command.qdot;
  if (!qdot.allFinite() || !output.command.q.allFinite()) {
    Broken(totals, task, time, "a command that is not finite");
    return;
  }
  for (Eigen::Index i = 0; i < qdot.size(); ++i) {
    if (std::abs(qdot(i)) > limits[i].velocity * (1.0 + 1e-9)) {
      Broken(totals, task, time, "a command beyond a joint's speed");
    }
  }
}

void Play(const std::string& name, const Scenario& scenario, Faults* faults, Totals* totals) {
  sim::Lockstep lockstep(scenario);
  faults->Restart();
  const std::vector<JointLimits>& limits = scenario.task.view.arm.limits();
  bool reached = false;
  ServoStatus status;
  while (lockstep.time() < scenario.time_limit && !reached) {
    const ServoOutput& output = lockstep.Tick([&](PeriodInputs* inputs) { faults->Spoil(inputs); });
    status = output.status;
    ++totals->periods;
    CheckCommand(output, limits, name, lockstep.time(), totals);
    if (status.refused_messages != faults->to_be_refused()) {
      Broken(totals, name, lockstep.time(), "refused is not what had to be");
    }
    reached = status.state == ServoState::kConverged;
  }
  const GroundTruth truth = lockstep.world().truth();
  if (truth.limit_violations != 0) {
    Broken(totals, name, lockstep.time(), "limits of the arm violated");
  }
  totals->seconds += lockstep.time();
  totals->refused += status.refused_messages;
  totals->stops += status.stops;
  totals->violations += truth.limit_violations;
  ++totals->tasks;
  const double error_mm = 1e3 * truth.worst_error;
  if (reached && error_mm < 2.0) {
    ++totals->reached;
  } else {
    std::printf("  not reached: %s, %s %s, %.2f mm from the goal\n", name.c_str(),
                Name(status.state), Name(status.reason), error_mm);
  }
}

int Run(double minutes, std::uint64_t seed) {
  const std::vector<sim::SuiteEntry> entries = sim::SuiteEntries("bad-starts");
  Faults faults(seed);
  Totals totals;
  double settled = 0.0, last = 0.0, next_line = 0.0;
  for (std::uint64_t i = 0; totals.seconds < 60.0 * minutes; ++i) {
    const sim::SuiteEntry& entry = entries[i % entries.size()];
    const std::uint64_t task_seed = 1000 * seed + i;
    const std::string name = sim::Name(entry) + " " + std::to_string(task_seed);
    Play(name, sim::MakeSuiteTask(entry, task_seed).scenario, &faults, &totals);
    last = ResidentMebibytes();
    if (totals.tasks <= kSettled) settled = std::max(settled, last);
    if (totals.seconds >= next_line) {
      next_line += 6.0 * minutes;
      std::printf(
          "%6.1f min simulated, %4d tasks, %4d reached, %lld refused, %lld stops, %lld violations, "
          "%.1f MiB\n",
          totals.seconds / 60.0, totals.tasks, totals.reached,
          static_cast<long long>(totals.refused), static_cast<long long>(totals.stops),
          static_cast<long long>(totals.violations), last);
      std::fflush(stdout);
    }
  }
  int count = 0;
  for (const auto& fault : faults.counts()) {
    std::printf("  %5d  %s\n", fault.second, fault.first.c_str());
    count += fault.second;
  }
  std::printf(
      "%lld periods, %d faults, %lld invariants broken; memory %.1f MiB after %d tasks, "
      "%.1f MiB "
      "at the end\n",
      static_cast<long long>(totals.periods), count, static_cast<long long>(totals.broken), settled,
      std::min(kSettled, totals.tasks), last);
  bool good = totals.broken == 0;
  if (totals.reached < kLeastReached * totals.tasks) {
    std::printf("FAILED: only %d of %d goals reached\n", totals.reached, totals.tasks);
    good = false;
  }
  if (last > settled + kMostGrowth) {
    std::printf("FAILED: memory grew\n");
    good = false;
  }
  return good ? 0 : 1;
}

}  // namespace
}  // namespace vantage::soak

int main(int argc, char** argv) {
  return vantage::soak::SoakMain(
      argc, argv, "soak_lockstep",
      "Hours of servo on simulated time, with goals and faults at random", 60.0, "Simulated time",
      vantage::soak::Run);
}
