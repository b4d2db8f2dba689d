#pragma once

#include <functional>
#include <vector>

#include "sim/world.h"
#include "vantage/config/scenario.h"
#include "vantage/report/run_record.h"
#include "vantage/servo/camera_task.h"
#include "vantage/servo/servo.h"
#include "vantage/servo/servo_record.h"

namespace vantage::sim {

/// Servo, active camera and simulated cell in lockstep on simulated time: the code of the programs
/// without clock, threads and transport. The same scenario and seed give the same numbers.
class Lockstep {
 public:
  /// Throws ConfigError or RenderError.
  explicit Lockstep(const Scenario& scenario);

  /// Has its way with what a period takes in, as faults on the way to a servo do.
  using Spoil = std::function<void(PeriodInputs*)>;

  /// One control period.
  const ServoOutput& Tick(const Spoil& spoil = {});

  [[nodiscard]] World& world() noexcept { return world_; }
  [[nodiscard]] const ActiveOutput& active() const noexcept { return inputs_.active; }
  [[nodiscard]] double time() const noexcept { return ToSeconds(world_.now() - Time{}); }  ///< [s].

 private:
  World world_;
  Servo servo_;
  CameraTask camera_task_;
  PeriodInputs inputs_;  // `active` is what the camera task last said
  Duration period_;
  Time next_camera_{};
};

/// Outcome of a whole run.
struct LockstepRun {
  RunSummary summary;
  std::vector<RunSample> samples;  ///< 50 per simulated second.
  GroundTruth truth;               ///< At the end.
  RigVector q_c;  ///< Where the active camera was at the end; empty: it never moved.
};

/// Told of each sample as it is made; the world is the one it was made of.
using SampleListener =
    std::function<void(const RunSample& sample, const ObservabilityReport& observability,
                       const ServoStatus& status, World& world)>;

/// When a run ends.
enum class RunUntil {
  kConverged,  ///< Or at the scenario's time limit.
  kTimeLimit,  ///< As a goal that moves asks for.
};

/// Runs the servo until it has converged, or for the scenario's time limit.
[[nodiscard]] LockstepRun RunLockstep(const Scenario& scenario, const SampleListener& listener = {},
                                      RunUntil until = RunUntil::kConverged);

}  // namespace vantage::sim
