// vantage-servo SCENARIO: closes the visual servo loop over LCM until SIGINT or SIGTERM.
// vantage-servo --replay LOG: does the same on recorded inputs and compares what comes out.
//
// Four threads: control (absolute deadlines), the link's own (receives), the active camera's, and one that
// only publishes what the control thread has put into a mailbox, so that no system call of the network
// lies in the control period.

#include <atomic>
#include <iostream>
#include <optional>
#include <thread>

#include <semaphore.h>

#include "app.h"
#include "servo_recorder.h"
#include "servo_replay.h"
#include "vantage/config/scenario.h"
#include "vantage/messaging/lcm_link.h"
#include "vantage/messaging/transport.h"
#include "vantage/runtime/latest_value.h"
#include "vantage/runtime/periodic_loop.h"
#include "vantage/runtime/realtime.h"
#include "vantage/runtime/signal_stop.h"
#include "vantage/servo/camera_task.h"
#include "vantage/servo/servo.h"
#include "vantage/servo/servo_record.h"

namespace vantage {
namespace {

constexpr Duration kReportPeriod = std::chrono::milliseconds(20);

struct Arguments {
  std::string scenario = kDefaultScenario;
  std::string camera = "active";
  std::string prefix;
  int priority = 80;
  std::vector<int> cpus;
  std::optional<bool> rehearse;  // By default where SCHED_FIFO is granted.
  std::string replay;
  double tolerance = ReplayOptions{}.tolerance;
};

/// A semaphore that a real-time thread can raise without waiting.
class Wake {
 public:
  Wake() { sem_init(&semaphore_, 0, 0); }
  ~Wake() { sem_destroy(&semaphore_); }
  Wake(const Wake&) = delete;
  Wake& operator=(const Wake&) = delete;
  void Raise() noexcept { sem_post(&semaphore_); }
  void Wait() noexcept {
    while (sem_wait(&semaphore_) != 0) {
    }
    // Wakes that piled up are one.
    while (sem_trywait(&semaphore_) == 0) {
    }
  }

 private:
  sem_t semaphore_{};
};

/// What the active camera hands to the control thread.
struct CameraStep {
  std::int64_t step{0};  ///< 1, 2, 3, ...
  ActiveOutput output;
};

/// What the control thread hands to the publisher.
struct Outbox {
  JointCommand command;
  ServoStatus status;
  ObservabilityReport observability;
  FeatureJacobian J_v{0, 6};
  ArmJacobian J_r{6, 0};
  bool arm_heard{false};  ///< Of an arm that has said nothing yet no joints are known to command.
};

class ServoProgram {
 public:
  ServoProgram(const Arguments& arguments, const Scenario& scenario)
      : arguments_(arguments),
        scenario_(scenario),
        servo_(scenario.task, scenario.servo, scenario.active.trigger),
        camera_task_(scenario.task, scenario.rig, scenario.q_c_start, scenario.active),
        transport_(JoinTransport()),
        link_({transport_.url, arguments.prefix}),
        recorder_(Setup(arguments, scenario), &link_) {}

  int Run() {
    if (!transport_.explanation.empty()) std::cerr << transport_.explanation << '\n';
    link_.Subscribe<JointState>(kJointStateChannel, [this](const auto& v) { joints_.Publish(v); });
    link_.Subscribe<CameraPose>(kCameraPoseChannel, [this](const auto& v) { pose_.Publish(v); });
    link_.Subscribe<ImageFeatures>(kImageFeaturesChannel,
                                   [this](const auto& v) { features_.Publish(v); });
    link_.Start();

    // Threads that do I/O start before the control thread asks for the real-time scheduler.
    std::thread publisher([this] { PublishLoop(); });
    std::thread camera([this] { CameraLoop(); });
    std::thread control([this] { ControlLoop(); });
    control.join();
    camera.join();
    publisher.join();

    std::cerr << "vantage-servo: " << report_.cycles << " periods, " << report_.deadline_misses
              << " late, longest " << report_.worst_cycle.count() / 1000 << " us, last state "
              << Name(last_status_.state) << '\n';
    if (!last_status_.calibration.none()) {
      std::cerr << "calibration found: " << Describe(last_status_.calibration) << '\n';
    }
    return kExitOk;
  }

 private:
  static ServoSetup Setup(const Arguments& arguments, const Scenario& scenario) {
    ServoSetup setup;
    setup.start = FromMicroseconds(ToMicroseconds(Clock::now()));
    setup.program = std::string("vantage-servo ") + Version();
    setup.scenario_name = scenario.name;
    setup.scenario = SelfContainedScenario(arguments.scenario).text;
    setup.active_camera = scenario.active.enabled;
    return setup;
  }

  void TakeInputs(const LoopCycle& cycle) {
    PeriodInputs& inputs = period_.inputs;
    inputs.now = Clock::now();
    inputs.enabled = !stop_.stopped();
    inputs.has_joints = joints_.Take(&inputs.joints);
    inputs.has_pose = pose_.Take(&inputs.pose);
    inputs.has_features = features_.Take(&inputs.features);
    inputs.has_active = active_.Take(&camera_step_);
    if (inputs.has_active) inputs.active = camera_step_.output;
    period_.camera_step = inputs.has_active ? camera_step_.step : 0;
    period_.lateness = cycle.begin - cycle.deadline;
    period_.execution = cycle.report.last_cycle;
  }

  void ControlLoop() {
    RealtimeOptions options;
    options.priority = arguments_.priority;
    options.cpus = arguments_.cpus;
    const RealtimeReport granted = EnterRealtime(options);
    if (!granted.complete()) std::cerr << "vantage-servo: " << granted.message << '\n';

    const auto period = [this](const LoopCycle& cycle) {
      TakeInputs(cycle);
      const ServoOutput& output = RunPeriod(&servo_, period_.inputs);
      period_.seq = output.status.seq;
      recorder_.Note(period_);
      outbox_value_.command = output.command;
      outbox_value_.observability = output.observability;
      outbox_value_.J_v = output.J_v;
      outbox_value_.J_r = output.J_r;
      outbox_value_.status = output.status;
      // Told to stop, the servo names that as its reason, heard from the arm or not.
      if (period_.inputs.enabled && output.status.reason != HoldReason::kNoJointState) {
        outbox_value_.arm_heard = true;
      }
      ReportPeriods(cycle.report, &outbox_value_.status);
      outbox_value_.status.dropped_messages =
          joints_.dropped() + pose_.dropped() + features_.dropped();
      outbox_.Publish(outbox_value_);
      snapshot_.Publish(servo_.snapshot());
      // Told to stop: leaves when the arm has been commanded to rest.
      if (!period_.inputs.enabled && output.command.qdot.isZero(0.0)) done_ = true;
      wake_.Raise();
    };
    // On a copy of the servo, which keeps its storage from one rehearsal to the next.
    Servo understudy = servo_;
    const auto rehearse = [this, &understudy](Time deadline) {
      understudy = servo_;
      understudy.Rehearse(deadline);
    };
    const bool rehearses = arguments_.rehearse.value_or(granted.fifo);
    const Duration lead = rehearses ? kRehearsalLead : Duration::zero();
    report_ = RunPeriodic(FromSeconds(scenario_.servo.period), done_, period,
                          Rehearsal<decltype(rehearse)>{lead, rehearse});
    done_ = true;
    wake_.Raise();
  }

  void ReportPeriods(const LoopReport& loop, ServoStatus* status) {
    const auto us = [](Duration d) { return 1e6 * ToSeconds(d); };
    // Each percentile is a walk over a histogram: not more often than it is published.
    if (loop.cycles >= next_percentiles_) {
      next_percentiles_ = loop.cycles + kReportPeriod / FromSeconds(scenario_.servo.period);
      percentiles_.loop_time_p50_us = us(loop.execution.Percentile(0.5));
      percentiles_.loop_time_p99_us = us(loop.execution.Percentile(0.99));
      percentiles_.loop_time_p999_us = us(loop.execution.Percentile(0.999));
      percentiles_.lateness_p999_us = us(loop.lateness.Percentile(0.999));
    }
    status->loop_time_us = us(loop.last_cycle);
    status->loop_time_max_us = us(loop.worst_cycle);
    status->loop_time_p50_us = percentiles_.loop_time_p50_us;
    status->loop_time_p99_us = percentiles_.loop_time_p99_us;
    status->loop_time_p999_us = percentiles_.loop_time_p999_us;
    status->lateness_p999_us = percentiles_.lateness_p999_us;
    status->lateness_max_us = us(loop.worst_lateness);
    status->deadline_misses = loop.deadline_misses;
  }

  void PublishLoop() {
    Outbox outbox;
    Time next_report{};
    while (!done_) {
      wake_.Wait();
      recorder_.Publish(Clock::now());
      if (!outbox_.Take(&outbox)) continue;
      if (outbox.arm_heard) link_.Publish(kJointCommandChannel, outbox.command);
      if (outbox.status.stamp < next_report) continue;
      next_report = outbox.status.stamp + kReportPeriod;
      PublishReports(&outbox);
    }
    if (outbox_.Take(&outbox) && outbox.arm_heard) {
      link_.Publish(kJointCommandChannel, outbox.command);
    }
    PublishReports(&outbox);
    recorder_.Publish(Clock::now(), true);
    last_status_ = outbox.status;
  }

  void PublishReports(Outbox* outbox) {
    const LinkStats stats = link_.stats();
    ServoStatus status = outbox->status;
    for (int i = 0; i < kNumRefusals; ++i) {
      status.CountRefused(FaultOf(static_cast<Refusal>(i)),
                          stats.refused[static_cast<std::size_t>(i)]);
    }
    status.dropped_messages += stats.dropped;
    CompleteReport(outbox->J_v, outbox->J_r, &outbox->observability);
    link_.Publish(kServoStatusChannel, status);
    link_.Publish(kObservabilityChannel, outbox->observability);
  }

  void CameraLoop() {
    ServoSnapshot snapshot;
    CameraStep step;
    RunPeriodic(kCameraTaskPeriod, done_, [&] {
      if (!snapshot_.Take(&snapshot) || !snapshot.valid) return;
      step.output = camera_task_.Step(snapshot);
      ++step.step;
      const bool commands = step.output.state != ActiveState::kDisabled;
      const CameraPose command{Clock::now(), step.output.X_WC};
      recorder_.Note({step.step, snapshot.active.now, commands ? command.stamp : Time{}});
      active_.Publish(step);
      if (commands) link_.Publish(kCameraPoseCommandChannel, command);
    });
  }

  Arguments arguments_;
  Scenario scenario_;
  SignalStop stop_;
  Servo servo_;
  CameraTask camera_task_;
  Transport transport_;
  LcmLink link_;
  ServoRecorder recorder_;
  std::atomic<bool> done_{false};
  Wake wake_;
  LoopReport report_;
  ServoStatus percentiles_;  // its percentiles alone, of the last time they were taken
  std::int64_t next_percentiles_{0};
  ServoStatus last_status_;

  // Mailboxes, and what the control thread has taken out of them.
  LatestValue<JointState> joints_;
  LatestValue<CameraPose> pose_;
  LatestValue<ImageFeatures> features_;
  LatestValue<CameraStep> active_;
  LatestValue<Outbox> outbox_;
  LatestValue<ServoSnapshot> snapshot_;
  PeriodRecord period_;
  CameraStep camera_step_;
  Outbox outbox_value_;
};

}  // namespace
}  // namespace vantage

int main(int argc, char** argv) {
  vantage::Arguments arguments;
  CLI::App app("Image-based visual servo over LCM, with live observability and an active camera",
               "vantage-servo");
  app.add_option("scenario", arguments.scenario, "Built-in scenario or a YAML file")
      ->capture_default_str();
  app.add_option("--camera", arguments.camera, "active: moves to better views; fixed: stays")
      ->check(CLI::IsMember({"active", "fixed"}))
      ->capture_default_str();
  app.add_option("--prefix", arguments.prefix, "Before every channel name");
  app.add_option("--priority", arguments.priority,
                 "SCHED_FIFO priority of the control thread; 0: none")
      ->check(CLI::Range(0, 99))
      ->capture_default_str();
  app.add_option("--cpus", arguments.cpus, "Cores of the control thread: 1 or 2,3")
      ->type_name("LIST")
      ->allow_extra_args(false)
      ->delimiter(',');
  app.add_flag(
      "--rehearse,!--no-rehearse", arguments.rehearse,
      "Goes through each period on a copy until it is due, which keeps caches warm, for 0.2 ms "
      "of processor time each; by default where SCHED_FIFO is granted");
  app.add_option("--replay", arguments.replay,
                 "Replays the servo that this event log holds, and compares commands and measures; "
                 "exit code 0 only if it reproduces them")
      ->type_name("LOG");
  app.add_option("--tolerance", arguments.tolerance,
                 "Of --replay: |logged - replayed| <= this, times |logged| where that is above 1")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  return vantage::RunApp(&app, argc, argv, "a replay that is not reproduced", [&] {
    if (!arguments.replay.empty()) {
      return vantage::PrintReplay(arguments.replay, {arguments.prefix, arguments.tolerance});
    }
    vantage::Scenario scenario = vantage::LoadScenario(arguments.scenario);
    if (arguments.camera == "fixed") scenario.active.enabled = false;
    return vantage::ServoProgram(arguments, scenario).Run();
  });
}
