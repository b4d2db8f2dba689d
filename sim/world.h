#pragma once

#include <memory>
#include <optional>

#include "sim/arm_plant.h"
#include "sim/camera_driver.h"
#include "sim/rig_plant.h"
#include "vantage/config/scenario.h"

/// @file
/// The simulated cell: arm, camera rig, camera. The same code runs on the wall clock (vantage-sim) and
/// in lockstep on simulated time (tests, benchmarks); deterministic for a scenario and its seed.

namespace vantage::sim {

/// What only a simulator can know. For reports and tests; never for the controller.
struct Truth {
  Time stamp{};
  JointVector q;                                             ///< [rad or m].
  Eigen::Isometry3d X_WC{Eigen::Isometry3d::Identity()};
  double worst_error{0.0};   ///< Largest distance of a marker to its goal point [m].
  double rms_error{0.0};     ///< Root mean square of the same [m].
  LimitViolations violations;
};

class World {
 public:
  /// Throws ConfigError or RenderError when the scenario does not fit.
  explicit World(const Scenario& scenario);

  /// Commands received at `now`.
  void Accept(const JointCommand& command, Time now) { arm_.Accept(command, now); }
  void Accept(const CameraPose& command) { rig_.Accept(command); }

  /// Lets time pass up to `now`, in steps of the scenario's sim.step; images are taken on the way.
  void Advance(Time now);

  /// What the drivers publish.
  [[nodiscard]] JointState ReadJoints() { return arm_.Read(now_); }
  [[nodiscard]] CameraPose ReadCameraPose() const;
  [[nodiscard]] std::optional<ImageFeatures> ReadFeatures() { return camera_.Deliver(now_); }

  [[nodiscard]] Truth truth() const;
  [[nodiscard]] Time now() const noexcept { return now_; }
  [[nodiscard]] CameraDriver& camera() noexcept { return camera_; }
  /// The view as it is now, in colour.
  void RenderColour(ColourImage* image);

 private:
  [[nodiscard]] SceneState Scene() const;
  [[nodiscard]] Eigen::Isometry3d MeasuredPose() const;

  Scenario scenario_;
  ArmPlant arm_;
  RigPlant rig_;
  Eigen::Isometry3d X_error_;   // of the camera's measured pose, in C
  CameraDriver camera_;
  Time now_{};
};

}  // namespace vantage::sim
