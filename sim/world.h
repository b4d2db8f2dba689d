#pragma once

#include <memory>
#include <optional>

#include "sim/arm_plant.h"
#include "sim/camera_driver.h"
#include "sim/render/renderer.h"
#include "sim/rig_plant.h"
#include "vantage/config/scenario.h"
#include "vantage/servo/ground_truth.h"

/// @file
/// The simulated cell: arm, camera rig, camera. The same code runs on the wall clock (vantage-sim) and
/// in lockstep on simulated time (tests, benchmarks); deterministic for a scenario and its seed.

namespace vantage::sim {

/// What a picture of the cell needs: cheap to copy between threads.
struct WorldView {
  Time stamp{};
  Eigen::Isometry3d X_WC{Eigen::Isometry3d::Identity()};
  SceneState scene;
};

/// A renderer of the scenario's scene through its true camera.
/// @param warnings  Told of each mesh that cannot be read; may be null.
[[nodiscard]] Renderer MakeRenderer(const Scenario& scenario,
                                    std::vector<std::string>* warnings = nullptr);

class World {
 public:
  /// Throws ConfigError or RenderError when the scenario does not fit.
  World(const Scenario& scenario, Time start);

  /// Commands received at `now`.
  void Accept(const JointCommand& command, Time now) { arm_.Accept(command, now); }
  void Accept(const CameraPose& command) { rig_.Accept(command); }
  /// Where an arm outside this simulation stands.
  void Follow(const JointState& state) { arm_.Follow(state); }

  /// Lets time pass up to `now`, in steps of the scenario's sim.step; images are taken on the way.
  void Advance(Time now);
  /// Moves the clock on without simulating: for a machine that is too slow for the wall clock.
  void SkipTo(Time now);

  /// What the drivers publish.
  [[nodiscard]] JointState ReadJoints() { return arm_.Read(now_); }
  [[nodiscard]] CameraPose ReadCameraPose() const;
  [[nodiscard]] std::optional<ImageFeatures> ReadFeatures() { return camera_.Deliver(now_); }

  [[nodiscard]] GroundTruth truth() const;
  [[nodiscard]] WorldView view() const;
  /// Where the camera truly is.
  [[nodiscard]] Eigen::Isometry3d X_WC() const { return rig_.X_WC(); }
  [[nodiscard]] Time now() const noexcept { return now_; }

 private:
  [[nodiscard]] SceneState Scene() const;
  [[nodiscard]] Eigen::Isometry3d X_WG() const;
  [[nodiscard]] Eigen::Isometry3d MeasuredPose() const;

  Scenario scenario_;
  ArmPlant arm_;
  RigPlant rig_;
  Eigen::Isometry3d X_error_;  // of the camera's measured pose, in C
  CameraDriver camera_;
  Time start_{};
  Time now_{};
};

}  // namespace vantage::sim
