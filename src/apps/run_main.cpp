// vantage-run [SCENARIO]: runs a scenario to its end and leaves a run folder behind.

#include <filesystem>
#include <fstream>
#include <iostream>

#include "app.h"
#include "run_lockstep.h"
#include "run_processes.h"
#include "sim/render/arm_scene.h"
#include "vantage/config/camera_plan_file.h"
#include "vantage/config/config_text.h"
#include "vantage/config/robot_task.h"
#include "vantage/math/error.h"
#include "vantage/report/log_report.h"

namespace vantage {
namespace {

struct Arguments {
  std::string scenario = kDefaultScenario;
  RobotTask robot;      // Where robot.robot is not empty, the scenario is written for it.
  std::string markers;  // A number or a file.
  std::string camera = "active";
  std::string out = "runs";
  std::optional<std::uint64_t> seed;
  std::optional<double> time_limit;
  std::string camera_plan;
  double image_rate = 10.0;
  int priority = 80;
  bool lockstep = false;
  bool quiet = false;
  bool no_report = false;
  bool list = false;
};

int List() {
  for (const std::string& name : BuiltInConfigs(ConfigKind::kScenario)) {
    std::cout << (name == kDefaultScenario ? "* " : "  ") << name << ": "
              << LoadScenario(name).description << '\n';
  }
  return kExitOk;
}

// What the log of the run tells, for people. A run that has happened is not undone by a failure here.
void WriteReport(const RunFolder& folder, std::vector<std::string>* troubles) {
  try {
    LogReportOptions options;
    options.csv = false;  // Many megabytes that few need: vantage-report writes them.
    const LogReport report =
        WriteLogReport(folder.File("events.lcm"), folder.path().string(), options);
    troubles->insert(troubles->end(), report.remarks.begin(), report.remarks.end());
  } catch (const std::exception& error) {
    troubles->push_back(std::string("no report: ") + error.what());
  }
}

// The scenario as text, and its name.
struct Source {
  ConfigText text;
  std::string name;
};

Source WriteScenario(const Arguments& arguments) {
  RobotTask task = arguments.robot;
  if (!arguments.markers.empty()) {
    const bool number = arguments.markers.find_first_not_of("0123456789") == std::string::npos;
    if (number && arguments.markers.size() <= 3) {
      task.marker_count = std::stoi(arguments.markers);
      if (task.marker_count == 0) throw ConfigError("", "--markers", "must be at least 1, is 0");
    } else {
      task.marker_file = arguments.markers;
    }
  }
  const std::string name = std::filesystem::path(task.robot).stem().string();
  return {{"scenario written for " + task.robot, "", WriteScenarioFor(task)}, name};
}

void PrintRemarks(const Scenario& scenario) {
  for (const std::string& warning : scenario.remarks.warnings) {
    std::cerr << "vantage-run: warning: " << warning << '\n';
  }
  std::vector<std::string> unreadable;
  (void)sim::MakeArmBodies(scenario.task.view.arm, {}, &unreadable);
  for (const std::string& warning : unreadable) {
    std::cerr << "vantage-run: warning: " << warning << '\n';
  }
}

// A scenario's text as a file in the run folder: what the processes read.
std::string WriteScenarioFile(const RunFolder& folder, const std::string& name,
                              const std::string& text) {
  const std::string path = folder.File(name + ".yaml");
  std::ofstream file(path);
  file << text;
  file.close();
  if (!file) throw WriteError(path);
  return path;
}

int Run(const Arguments& arguments) {
  if (arguments.list) return List();
  // Everything is checked before anything is started or written.
  const bool own_robot = !arguments.robot.robot.empty();
  std::optional<Source> own;
  if (own_robot) own = WriteScenario(arguments);
  Scenario scenario =
      own_robot ? ReadScenario(own->text, own->name) : LoadScenario(arguments.scenario);
  PrintRemarks(scenario);
  const bool planned = !arguments.camera_plan.empty();
  if (planned) scenario.q_c_start = LoadCameraStart(arguments.camera_plan, scenario.rig);
  if (arguments.camera == "fixed") scenario.active.enabled = false;
  if (arguments.seed) scenario.sim.seed = *arguments.seed;
  if (arguments.time_limit) scenario.time_limit = *arguments.time_limit;

  std::optional<Transport> transport;
  if (!arguments.lockstep) transport = ChooseTransport();
  const RunFolder folder(arguments.out, scenario.name);
  std::string scenario_path = arguments.scenario;
  if (own_robot) {
    // A start for the user's own changes, too.
    scenario_path = WriteScenarioFile(folder, "scenario", own->text.text);
  }
  RunConsole console(arguments.quiet);
  console.Note(scenario.name + ": " + scenario.description + " (camera " + arguments.camera +
               (arguments.lockstep ? ", simulated time)" : ")"));
  RunOutcome outcome;
  if (arguments.lockstep) {
    const sim::LockstepRun run = RunInLockstep(scenario, folder, &console);
    outcome = {run.summary, run.samples};
  } else {
    ProcessRunOptions options;
    options.scenario = scenario_path;
    if (planned) {
      const std::string start = CameraStartText(scenario.rig, scenario.q_c_start);
      options.scenario = WriteScenarioFile(folder, scenario.name,
                                           SelfContainedScenario(scenario_path, start).text);
    }
    options.fixed_camera = !scenario.active.enabled;
    options.seed = arguments.seed;
    options.image_rate = arguments.image_rate;
    options.priority = arguments.priority;
    outcome = RunProcesses(options, *transport, scenario, folder, &console);
  }
  std::vector<std::string> troubles = folder.Write(outcome.summary, outcome.samples);
  if (!arguments.lockstep && !arguments.no_report) WriteReport(folder, &troubles);
  console.End(outcome.summary, folder.Contents());
  for (const std::string& trouble : troubles) std::cerr << "vantage-run: " << trouble << '\n';
  return outcome.summary.converged ? kExitOk : kExitNotReached;
}

}  // namespace
}  // namespace vantage

int main(int argc, char** argv) {
  vantage::Arguments arguments;
  CLI::App app(
      "Runs a scenario: simulated cell, servo, active camera. Ends when the servo has converged or "
      "at the time limit.",
      "vantage-run");
  app.add_option("scenario", arguments.scenario, "Built-in scenario (see --list) or a YAML file")
      ->capture_default_str();
  app.add_option("--robot", arguments.robot.robot,
                 "Writes a scenario for this arm and runs it: a URDF or robot file, or a built-in "
                 "robot; the scenario is left in the run folder")
      ->excludes("scenario");
  app.add_option(
         "--markers", arguments.markers,
         "With --robot: how many dots to put on the end effector, or a YAML file with a list "
         "`markers`")
      ->needs("--robot");
  app.add_option("--base-link", arguments.robot.base_link,
                 "With --robot: first link of the arm in a URDF file")
      ->needs("--robot");
  app.add_option("--tip-link", arguments.robot.tip_link,
                 "With --robot: last link of the arm in a URDF file")
      ->needs("--robot");
  app.add_flag("--list", arguments.list, "Lists the built-in scenarios and ends");
  app.add_option("--camera", arguments.camera, "active: moves to better views; fixed: stays")
      ->check(CLI::IsMember({"active", "fixed"}))
      ->capture_default_str();
  app.add_option("--camera-plan", arguments.camera_plan,
                 "Starts with the camera where this result of vantage-plan puts it");
  app.add_option("--time-limit", arguments.time_limit,
                 "Gives up after this long [s], instead of the scenario's")
      ->check(CLI::Range(0.1, 86400.0));
  app.add_option("--seed", arguments.seed, "Seed of every random number, instead of the scenario's")
      ->check(vantage::WholeNumber());
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
  app.add_flag("--no-report", arguments.no_report,
               "Writes no report.html; vantage-report makes one from events.lcm");
  app.add_flag("--quiet", arguments.quiet, "Prints nothing but errors");
  return vantage::RunApp(&app, argc, argv, "not converged",
                         [&] { return vantage::Run(arguments); });
}
