// vantage-run [SCENARIO]: runs a scenario to its end and leaves a run folder behind.

#include <fstream>
#include <iostream>

#include "app.h"
#include "run_lockstep.h"
#include "run_processes.h"
#include "vantage/config/camera_plan_file.h"
#include "vantage/config/config_text.h"
#include "vantage/math/error.h"

namespace vantage {
namespace {

struct Arguments {
  std::string scenario = kDefaultScenario;
  std::string camera = "active";
  std::string out = "runs";
  std::optional<std::uint64_t> seed;
  std::optional<double> time_limit;
  std::string camera_plan;
  double image_rate = 10.0;
  int priority = 80;
  bool lockstep = false;
  bool quiet = false;
  bool list = false;
};

int List() {
  for (const std::string& name : BuiltInConfigs(ConfigKind::kScenario)) {
    std::cout << (name == kDefaultScenario ? "* " : "  ") << name << ": "
              << LoadScenario(name).description << '\n';
  }
  return kExitOk;
}

// The scenario with the camera where the plan puts it, as a file in the run folder for all processes.
std::string WritePlannedScenario(const Arguments& arguments, const Scenario& scenario,
                                 const RunFolder& folder) {
  const std::string path = folder.File(scenario.name + ".yaml");
  std::ofstream file(path);
  file << SelfContainedScenario(arguments.scenario).text << "\n# By --camera-plan.\n"
       << CameraStartText(scenario.rig, scenario.q_c_start);
  file.close();
  if (!file) throw Error(path + ": cannot be written");
  return path;
}

int Run(const Arguments& arguments) {
  if (arguments.list) return List();
  // Everything is checked before anything is started or written.
  Scenario scenario = LoadScenario(arguments.scenario);
  const bool planned = !arguments.camera_plan.empty();
  if (planned) scenario.q_c_start = LoadCameraStart(arguments.camera_plan, scenario.rig);
  if (arguments.camera == "fixed") scenario.active.enabled = false;
  if (arguments.seed) scenario.sim.seed = *arguments.seed;
  if (arguments.time_limit) scenario.time_limit = *arguments.time_limit;

  const RunFolder folder(arguments.out, scenario.name);
  RunConsole console(arguments.quiet);
  console.Begin(scenario.name + ": " + scenario.description + " (camera " + arguments.camera +
                (arguments.lockstep ? ", simulated time)" : ")"));
  RunOutcome outcome;
  if (arguments.lockstep) {
    outcome = RunInLockstep(scenario, folder, &console);
  } else {
    ProcessRunOptions options;
    options.scenario =
        planned ? WritePlannedScenario(arguments, scenario, folder) : arguments.scenario;
    options.fixed_camera = !scenario.active.enabled;
    options.seed = arguments.seed;
    options.image_rate = arguments.image_rate;
    options.priority = arguments.priority;
    outcome = RunProcesses(options, scenario, folder, &console);
  }
  const std::string trouble = folder.Write(outcome.summary, outcome.samples);
  console.End(outcome.summary, folder.path().string() +
                                   "/: run.png, first.png, last.png, summary.json, samples.csv" +
                                   (arguments.lockstep ? "" : ", events.lcm"));
  if (!trouble.empty()) std::cerr << "vantage-run: no picture: " << trouble << '\n';
  return outcome.summary.converged ? kExitOk : kExitNotReached;
}

}  // namespace
}  // namespace vantage

int main(int argc, char** argv) {
  vantage::Arguments arguments;
  CLI::App app(
      "Runs a scenario: simulated cell, servo, active camera. Ends when the servo has converged or "
      "at the "
      "time limit; exit code 0 only if it converged.",
      "vantage-run");
  app.add_option("scenario", arguments.scenario, "Built-in scenario (see --list) or a YAML file")
      ->capture_default_str();
  app.add_flag("--list", arguments.list, "Lists the built-in scenarios and ends");
  app.add_option("--camera", arguments.camera, "active: moves to better views; fixed: stays")
      ->check(CLI::IsMember({"active", "fixed"}))
      ->capture_default_str();
  app.add_option("--camera-plan", arguments.camera_plan,
                 "Starts with the camera where this result of vantage-plan puts it");
  app.add_option("--time-limit", arguments.time_limit,
                 "Gives up after this long [s], instead of the scenario's")
      ->check(CLI::Range(0.1, 86400.0));
  app.add_option("--seed", arguments.seed,
                 "Seed of every random number, instead of the scenario's");
  app.add_option("--out", arguments.out, "Folder that the run folder is made in")
      ->capture_default_str();
  app.add_flag("--lockstep", arguments.lockstep,
               "Simulated time in one process: no LCM, faster, the same numbers every time");
  app.add_option("--image-rate", arguments.image_rate, "CAMERA_IMAGE messages [1/s]; 0: none")
      ->check(CLI::Range(0.0, 30.0))
      ->capture_default_str();
  app.add_option("--priority", arguments.priority,
                 "SCHED_FIFO priority of the control thread; 0: none")
      ->check(CLI::Range(0, 99))
      ->capture_default_str();
  app.add_flag("--quiet", arguments.quiet, "Prints nothing but errors");
  return vantage::RunApp(&app, argc, argv, [&] { return vantage::Run(arguments); });
}
