#include "run_processes.h"

#include <cmath>
#include <fstream>
#include <iostream>
#include <mutex>
#include <optional>

#include <opencv2/imgcodecs.hpp>

#include "vantage/math/error.h"
#include "vantage/messaging/event_recorder.h"
#include "vantage/messaging/lcm_link.h"
#include "vantage/messaging/transport.h"
#include "vantage/runtime/child_process.h"
#include "vantage/runtime/signal_stop.h"

namespace vantage {
namespace {

constexpr Duration kStartLimit = std::chrono::seconds(20);
constexpr Duration kGrace = std::chrono::seconds(3);
// After it has converged the run goes on for this long, so that the record shows it standing.
constexpr double kAfterConvergence = 0.5;

/// What comes in over LCM, as the link's thread sees it.
class Watcher {
 public:
  explicit Watcher(const RunFolder& folder) : folder_(folder) {}

  void Subscribe(LcmLink* link) {
    link->Subscribe<ServoStatus>(kServoStatusChannel, [this](const auto& v) {
      const std::lock_guard lock(mutex_);
      status_ = v;
    });
    link->Subscribe<ObservabilityReport>(kObservabilityChannel, [this](const auto& v) {
      const std::lock_guard lock(mutex_);
      observability_ = v;
    });
    link->Subscribe<GroundTruth>(kSimTruthChannel, [this](const auto& v) {
      const std::lock_guard lock(mutex_);
      truth_ = v;
    });
    link->Subscribe<CameraImage>(kCameraImageChannel, [this](const auto& v) {
      const std::lock_guard lock(mutex_);
      if (v.format != PixelFormat::kJpeg) return;
      if (image_.empty()) WritePicture(v.data, "first.png");
      image_ = v.data;
    });
  }

  struct State {
    std::optional<ServoStatus> status;
    std::optional<ObservabilityReport> observability;
    std::optional<GroundTruth> truth;
  };
  [[nodiscard]] State Get() const {
    const std::lock_guard lock(mutex_);
    return {status_, observability_, truth_};
  }
  void WriteLastPicture() {
    const std::lock_guard lock(mutex_);
    if (!image_.empty()) WritePicture(image_, "last.png");
  }

 private:
  void WritePicture(const std::vector<std::uint8_t>& jpeg, const char* name) const {
    const cv::Mat picture = cv::imdecode(jpeg, cv::IMREAD_COLOR);
    if (!picture.empty()) cv::imwrite(folder_.File(name), picture);
  }

  const RunFolder& folder_;
  mutable std::mutex mutex_;
  std::optional<ServoStatus> status_;
  std::optional<ObservabilityReport> observability_;
  std::optional<GroundTruth> truth_;
  std::vector<std::uint8_t> image_;
};

std::string Sibling(const char* program) {
  return (std::filesystem::canonical("/proc/self/exe").parent_path() / program).string();
}

/// The processes of a run.
class Processes {
 public:
  Processes(const ProcessRunOptions& options, const std::string& url, const RunFolder& folder)
      : sim_(Options(SimArguments(options), url, folder, "sim.txt")),
        servo_(Options(ServoArguments(options), url, folder, "servo.txt")) {}

  /// The name of a process that has ended, with how; nullopt while all run.
  [[nodiscard]] std::optional<std::string> Ended() {
    for (ChildProcess* child : {&sim_, &servo_}) {
      if (const auto status = child->Poll())
        return child->name() + " ended with " + status->ToString();
    }
    return std::nullopt;
  }

  /// The servo first: its last commands bring the arm to rest.
  void Stop() {
    servo_.Terminate(kGrace);
    sim_.Terminate(kGrace);
  }

 private:
  static ChildOptions Options(std::vector<std::string> arguments, const std::string& url,
                              const RunFolder& folder, const char* log) {
    ChildOptions options;
    options.arguments = std::move(arguments);
    options.environment["LCM_DEFAULT_URL"] = url;
    options.output = folder.File(log);
    return options;
  }
  static std::vector<std::string> SimArguments(const ProcessRunOptions& options) {
    std::vector<std::string> arguments{Sibling("vantage-sim"), options.scenario, "--image-rate",
                                       std::to_string(options.image_rate)};
    if (options.seed) arguments.insert(arguments.end(), {"--seed", std::to_string(*options.seed)});
    return arguments;
  }
  static std::vector<std::string> ServoArguments(const ProcessRunOptions& options) {
    return {Sibling("vantage-servo"),
            options.scenario,
            "--camera",
            options.fixed_camera ? "fixed" : "active",
            "--priority",
            std::to_string(options.priority)};
  }

  ChildProcess sim_, servo_;
};

std::string LastLines(const std::string& path) {
  std::ifstream file(path);
  std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  if (text.size() > 600) text = "..." + text.substr(text.size() - 600);
  return text;
}

std::string WhatTheySaid(const RunFolder& folder) {
  return "\nvantage-sim said:\n" + LastLines(folder.File("sim.txt")) + "vantage-servo said:\n" +
         LastLines(folder.File("servo.txt"));
}

}  // namespace

RunOutcome RunProcesses(const ProcessRunOptions& options, const Transport& transport,
                        const Scenario& scenario, const RunFolder& folder, RunConsole* console) {
  SignalStop stop;
  if (!transport.explanation.empty()) console->Note(transport.explanation);
  console->Note("watch it live in another terminal: " + transport.ReadyLine() +
                ", or vantage-watch in its place");

  Watcher watcher(folder);
  LcmLink link({transport.url, ""});
  watcher.Subscribe(&link);
  link.Start();
  // From before the first message on: only a log that holds all can be replayed.
  std::optional<EventRecorder> recorder(std::in_place, transport.url, folder.File("events.lcm"));
  Processes processes(options, transport.url, folder);

  RunOutcome outcome;
  RunSummary& summary = outcome.summary;
  summary.scenario = scenario.name;
  summary.camera = options.fixed_camera ? "fixed" : "active";
  summary.end = "time limit";
  summary.lowest_trigger_value = std::numeric_limits<double>::infinity();

  const Time launch = Clock::now();
  bool started = false;  // the servo has reported with all its inputs
  bool converged = false;
  Time start = launch;
  while (!stop.WaitFor(std::chrono::milliseconds(20))) {
    const Time now = Clock::now();
    if (const auto ended = processes.Ended()) {
      if (!started) {
        processes.Stop();
        throw Error(*ended + WhatTheySaid(folder));
      }
      summary.end = *ended;
      break;
    }
    const Watcher::State state = watcher.Get();
    const bool reports = state.status && state.observability && state.observability->k > 0;
    if (!started && reports) {
      started = true;
      start = now;
    }
    if (!started) {
      if (now - launch < kStartLimit) continue;
      processes.Stop();
      throw Error((link.stats().connected
                       ? "no report of a working servo within 20 s"
                       : "nobody answers at " + transport.url + " (LCM_DEFAULT_URL)") +
                  WhatTheySaid(folder));
    }
    const double t = ToSeconds(now - start);
    RunSample sample = MakeSample(t, *state.status, *state.observability);
    if (state.truth) sample.true_error_mm = 1e3 * state.truth->worst_error;
    outcome.samples.push_back(sample);
    console->Show(sample, *state.observability, *state.status);
    summary.lowest_trigger_value = std::min(summary.lowest_trigger_value, sample.trigger_value);
    summary.status = *state.status;
    summary.observability = *state.observability;
    summary.duration = t;

    const bool stands = state.status->state == ServoState::kConverged;
    if (stands && !converged) summary.time_to_converge = t;
    converged = stands;
    if (converged && t - summary.time_to_converge >= kAfterConvergence) {
      summary.converged = true;
      summary.end = "converged";
      break;
    }
    if (t >= scenario.time_limit) break;
  }
  if (stop.stopped()) summary.end = "stopped by the user";
  const Watcher::State last = watcher.Get();
  if (last.truth) {
    summary.true_error_mm = 1e3 * last.truth->worst_error;
    summary.limit_violations = last.truth->limit_violations;
  }
  summary.camera_moves = summary.observability.camera_moves;
  processes.Stop();
  if (recorder->lost() > 0) {
    console->Note(std::to_string(recorder->lost()) +
                  " messages could not be written to events.lcm");
  }
  recorder.reset();
  watcher.WriteLastPicture();
  return outcome;
}

}  // namespace vantage
