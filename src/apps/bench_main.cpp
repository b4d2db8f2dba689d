// vantage-bench: the scenario suite over many seeds, strategies side by side, in simulated time.

#include <atomic>
#include <fstream>
#include <iostream>
#include <mutex>
#include <thread>

#include "app.h"
#include "bench_table.h"
#include "progress_bar.h"
#include "run_lockstep.h"
#include "sim/suite/run_task.h"
#include "vantage/math/error.h"

namespace vantage {
namespace {

struct Arguments {
  std::string suite = "bad-starts";
  std::int64_t seeds = 20;
  std::uint64_t first_seed = 1;
  std::vector<std::string> strategies;
  std::vector<std::string> without;
  std::vector<std::string> replay;
  std::string trigger;
  double threshold = 0.0;
  std::string json;
  std::string out = "runs";
  int jobs = 0;
  bool kinematic = false;
  bool quiet = false;
  bool list = false;
};

// One run to be done, and where its result goes.
struct Job {
  sim::SuiteEntry entry;
  std::uint64_t seed;
  std::vector<std::pair<sim::Strategy, sim::TaskResult*>> runs;
};

// What all runs have in common.
struct Settings {
  bool kinematic{false};
  std::vector<const sim::Ablation*> ablations;
  std::optional<TriggerMeasure> measure;
  double threshold{0.0};
};

void Apply(const Settings& settings, Scenario* scenario) {
  scenario->sim.camera.kinematic = settings.kinematic;
  for (const sim::Ablation* ablation : settings.ablations) ablation->apply(scenario);
  if (settings.measure) scenario->active.trigger.measure = *settings.measure;
  if (settings.threshold > 0.0) scenario->active.trigger.threshold = settings.threshold;
}

// Runs every job; each result depends on its job alone, whatever thread does it.
void RunJobs(std::vector<Job>* jobs, const Settings& settings, int threads, ProgressBar* progress) {
  std::size_t runs = 0;
  for (const Job& job : *jobs) runs += job.runs.size();
  std::atomic<std::size_t> next{0}, done{0};
  std::exception_ptr failure;
  std::mutex failure_mutex;
  const auto work = [&] {
    for (std::size_t i = next++; i < jobs->size(); i = next++) {
      try {
        const Job& job = (*jobs)[i];
        const sim::SuiteTask task = sim::MakeSuiteTask(job.entry, job.seed);
        for (const auto& [strategy, result] : job.runs) {
          Scenario scenario = sim::WithStrategy(task.scenario, strategy);
          Apply(settings, &scenario);
          *result = sim::RunTask(scenario, task);
          const std::size_t now = ++done;
          progress->Show(static_cast<double>(now) / static_cast<double>(runs),
                         std::to_string(now) + " of " + std::to_string(runs) + " runs");
        }
      } catch (...) {
        const std::lock_guard<std::mutex> lock(failure_mutex);
        if (!failure) failure = std::current_exception();
        next = jobs->size();
      }
    }
  };
  std::vector<std::thread> pool;
  for (int i = 0; i < threads; ++i) pool.emplace_back(work);
  for (std::thread& thread : pool) thread.join();
  if (failure) std::rethrow_exception(failure);
}

Settings SettingsOf(const Arguments& arguments) {
  Settings settings;
  settings.kinematic = arguments.kinematic;
  for (const std::string& name : arguments.without) {
    settings.ablations.push_back(&sim::AblationOf(name));
  }
  for (const auto& [key, measure] : TriggerMeasureKeys()) {
    if (key == arguments.trigger) settings.measure = measure;
  }
  settings.threshold = arguments.threshold;
  return settings;
}

std::vector<sim::Strategy> StrategiesOf(const Arguments& arguments) {
  if (arguments.strategies.empty()) return {sim::Strategy::kFixed, sim::Strategy::kActive};
  std::vector<sim::Strategy> strategies;
  for (const std::string& name : arguments.strategies) {
    if (name == "all") return sim::AllStrategies();
    strategies.push_back(sim::StrategyOf(name));
  }
  return strategies;
}

int Replay(const Arguments& arguments, const Settings& settings) {
  const std::vector<sim::SuiteEntry> entries = sim::SuiteEntries(arguments.replay[0]);
  if (entries.size() != 1) {
    throw ConfigError("", "--replay",
                      "must name one row, such as S4/planar2, is " + arguments.replay[0]);
  }
  std::uint64_t seed = 0;
  try {
    std::size_t used = 0;
    seed = std::stoull(arguments.replay[1], &used);
    if (used != arguments.replay[1].size()) throw std::invalid_argument("");
  } catch (const std::exception&) {
    throw ConfigError("", "--replay", "the seed must be a number, is " + arguments.replay[1]);
  }
  const sim::SuiteTask task = sim::MakeSuiteTask(entries[0], seed);
  const std::vector<sim::Strategy> strategies = StrategiesOf(arguments);
  const sim::Strategy strategy =
      arguments.strategies.empty() ? sim::Strategy::kActive : strategies.front();
  Scenario scenario = sim::WithStrategy(task.scenario, strategy);
  Apply(settings, &scenario);

  std::string name = Name(entries[0]) + "-" + arguments.replay[1] + "-" + Name(strategy);
  for (char& c : name) c = c == '/' ? '-' : c;
  const auto play = [&](const std::string& run_name) {
    scenario.name = run_name;
    const RunFolder folder(arguments.out, run_name);
    RunConsole console(arguments.quiet);
    console.Note(run_name + " (simulated time" + (settings.kinematic ? ", kinematic)" : ")"));
    const sim::LockstepRun run = RunInLockstep(
        scenario, folder, &console,
        sim::Follows(scenario) ? sim::RunUntil::kTimeLimit : sim::RunUntil::kConverged);
    const std::vector<std::string> troubles = folder.Write(run.summary, run.samples);
    console.End(run.summary, folder.Contents());
    for (const std::string& trouble : troubles) std::cerr << "vantage-bench: " << trouble << '\n';
    return run;
  };
  if (task.next.empty()) return play(name).summary.converged ? kExitOk : kExitNotReached;
  // Each goal of a sequence has a folder of its own; as in the suite, the first that is not reached is the last.
  sim::LockstepRun run = play(name + "-goal1");
  for (std::size_t i = 0; i < task.next.size() && run.summary.converged; ++i) {
    scenario = sim::NextStage(scenario, task.next[i], run.truth.q, run.q_c);
    run = play(name + "-goal" + std::to_string(i + 2));
  }
  return run.summary.converged ? kExitOk : kExitNotReached;
}

int List() {
  std::cout << "rows:";
  for (const char* suite : {"all", "follow", "sequence"}) {
    for (const sim::SuiteEntry& entry : sim::SuiteEntries(suite)) std::cout << ' ' << Name(entry);
  }
  std::cout << "\nstrategies:";
  for (const sim::Strategy strategy : sim::AllStrategies()) std::cout << ' ' << Name(strategy);
  std::cout << "\nwithout:\n";
  for (const sim::Ablation& ablation : sim::AllAblations()) {
    std::cout << "  " << ablation.name << ": " << ablation.what << '\n';
  }
  return kExitOk;
}

int Bench(const Arguments& arguments) {
  if (arguments.list) return List();
  const Settings settings = SettingsOf(arguments);
  if (!arguments.replay.empty()) return Replay(arguments, settings);
  const std::vector<sim::SuiteEntry> entries = sim::SuiteEntries(arguments.suite);
  const std::vector<sim::Strategy> strategies = StrategiesOf(arguments);

  // Not after hours of work.
  if (!arguments.json.empty() && !std::ofstream(arguments.json)) {
    throw ConfigError("", "--json", "cannot write " + arguments.json);
  }
  const auto seeds = static_cast<std::size_t>(arguments.seeds);
  std::vector<BenchRow> rows;
  for (const sim::SuiteEntry& entry : entries) {
    for (const sim::Strategy strategy : strategies) {
      rows.push_back({Name(entry), Name(strategy), arguments.first_seed, {}});
      for (const sim::Ablation* ablation : settings.ablations) {
        rows.back().strategy += std::string("-") + ablation->name;
      }
      rows.back().results.resize(seeds);
    }
  }
  std::vector<Job> jobs;
  for (std::size_t e = 0; e < entries.size(); ++e) {
    for (std::size_t s = 0; s < seeds; ++s) {
      jobs.push_back({entries[e], arguments.first_seed + s, {}});
      for (std::size_t k = 0; k < strategies.size(); ++k) {
        jobs.back().runs.emplace_back(strategies[k], &rows[e * strategies.size() + k].results[s]);
      }
    }
  }
  const auto cores = static_cast<int>(std::thread::hardware_concurrency());
  const int threads = arguments.jobs > 0 ? arguments.jobs : std::max(1, cores);
  ProgressBar progress(arguments.quiet);
  RunJobs(&jobs, settings, threads, &progress);
  progress.End();
  std::cout << BenchTable(rows);
  if (!arguments.json.empty()) {
    WriteBenchJson(rows, arguments.suite, arguments.kinematic, arguments.json);
  }
  return kExitOk;
}

}  // namespace
}  // namespace vantage

int main(int argc, char** argv) {
  vantage::Arguments arguments;
  CLI::App app(
      "The scenario suite: random tasks by seed, strategies side by side, in simulated time on all "
      "cores. The same seeds give the same results.",
      "vantage-bench");
  app.add_option("--suite", arguments.suite,
                 "bad-starts, all, quick, follow, sequence, a scenario (S4) or a row (S4/planar2)")
      ->capture_default_str();
  app.add_option("--seeds", arguments.seeds, "Tasks of each row")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str();
  app.add_option("--first-seed", arguments.first_seed, "Seed of the first task")
      ->check(vantage::WholeNumber())
      ->capture_default_str();
  app.add_option("--strategy", arguments.strategies,
                 "fixed, classic, planned, minimax, active, gradient, stop-and-go or all; several "
                 "with commas (default: fixed, active)")
      ->delimiter(',');
  app.add_option("--without", arguments.without, "Ingredients switched off (see --list)")
      ->delimiter(',');
  app.add_option("--trigger", arguments.trigger, "Measure that moves the camera")
      ->check(CLI::IsMember(vantage::TriggerMeasureKeys()));
  app.add_option("--threshold", arguments.threshold, "Its threshold, in its unit")
      ->check(CLI::PositiveNumber);
  app.add_option("--json", arguments.json, "Writes all rows to this file");
  app.add_option("--jobs", arguments.jobs, "Threads (default: one for each core)")
      ->check(CLI::Range(1, 1024));
  app.add_flag("--kinematic", arguments.kinematic,
               "Projects the markers by the model instead of rendering and detecting them");
  app.add_option("--replay", arguments.replay,
                 "ROW SEED: plays one task and leaves a run folder, as vantage-run does")
      ->expected(2);
  app.add_option("--out", arguments.out, "Folder that a replay's run folder is made in")
      ->capture_default_str();
  app.add_flag("--list", arguments.list, "Names rows, strategies and ingredients, and ends");
  app.add_flag("--quiet", arguments.quiet, "No progress bar");
  return vantage::RunApp(&app, argc, argv, "a task of --replay that did not converge",
                         [&] { return vantage::Bench(arguments); });
}
