#include "sim/lockstep.h"

#include <algorithm>
#include <limits>

namespace vantage::sim {
namespace {

constexpr int kSamplesPerSecond = 50;

}  // namespace

Lockstep::Lockstep(const Scenario& scenario)
    : world_(scenario, Time{}),
      servo_(scenario.task, scenario.servo, scenario.active.trigger),
      camera_task_(scenario.task, scenario.rig, scenario.q_c_start, scenario.active),
      period_(FromSeconds(scenario.servo.period)) {}

const ServoOutput& Lockstep::Tick(const Spoil& spoil) {
  const Time now = world_.now() + period_;
  world_.Advance(now);
  inputs_.now = now;
  inputs_.has_joints = inputs_.has_pose = true;
  inputs_.joints = world_.ReadJoints();
  inputs_.pose = world_.ReadCameraPose();
  const auto features = world_.ReadFeatures();
  inputs_.has_features = features.has_value();
  if (features) inputs_.features = *features;
  if (spoil) spoil(&inputs_);
  const ServoOutput& output = RunPeriod(&servo_, inputs_);
  inputs_.has_active = false;
  world_.Accept(output.command, now);
  if (servo_.snapshot().valid && now >= next_camera_) {
    next_camera_ = now + kCameraTaskPeriod;
    inputs_.active = camera_task_.Step(servo_.snapshot());
    inputs_.has_active = true;
    if (active().state != ActiveState::kDisabled) world_.Accept(CameraPose{now, active().X_WC});
  }
  return output;
}

LockstepRun RunLockstep(const Scenario& scenario, const SampleListener& listener, RunUntil until) {
  Lockstep lockstep(scenario);
  LockstepRun run;
  run.summary.scenario = scenario.name;
  run.summary.camera = scenario.active.enabled ? "active" : "fixed";
  run.summary.end = "time limit";
  run.summary.lowest_trigger_value = std::numeric_limits<double>::infinity();
  double next_sample = 0.0;
  while (lockstep.time() < scenario.time_limit) {
    const ServoOutput& output = lockstep.Tick();
    run.truth = lockstep.world().truth();
    if (output.observability.k > 0) {
      run.summary.lowest_trigger_value =
          std::min(run.summary.lowest_trigger_value, output.observability.trigger_value);
    }
    if (output.observability.k > 0 && lockstep.time() >= next_sample) {
      next_sample = lockstep.time() + 1.0 / kSamplesPerSecond;
      run.samples.push_back(MakeSample(lockstep.time(), output.status, output.observability));
      run.samples.back().true_error_mm = 1e3 * run.truth.worst_error;
      if (listener) {
        listener(run.samples.back(), output.observability, output.status, lockstep.world());
      }
    }
    run.summary.status = output.status;
    run.summary.observability = output.observability;
    if (output.status.state == ServoState::kConverged && !run.summary.converged) {
      run.summary.converged = true;
      run.summary.time_to_converge = lockstep.time();
      if (until == RunUntil::kConverged) {
        run.summary.end = "converged";
        break;
      }
    }
  }
  run.summary.duration = lockstep.time();
  if (!run.summary.converged) run.summary.time_to_converge = run.summary.duration;
  run.q_c = lockstep.active().q_c;
  run.summary.true_error_mm = 1e3 * run.truth.worst_error;
  run.summary.camera_moves = lockstep.active().moves;
  run.summary.limit_violations = run.truth.limit_violations;
  return run;
}

}  // namespace vantage::sim
