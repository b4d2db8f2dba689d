#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "vantage/features/marker.h"
#include "vantage/math/sizes.h"

/// @file
/// What the simulator does beyond the nominal models: effects of a real arm, rig and camera. The
/// controller never sees any of it.

namespace vantage {

/// Effects of a real arm.
struct ArmEffects {
  double lag{0.02};           ///< Time constant of the velocity loop [s]; 0: none.
  double encoder_noise{0.0};  ///< Standard deviation of a joint reading [rad or m].
  double encoder_bias{0.0};   ///< Standard deviation of each joint's constant bias [rad or m].
  double watchdog{0.1};       ///< The arm brakes when no command came for this long [s]; > 0.
};

/// Effects of a real camera and its rig.
struct CameraEffects {
  double rate{60.0};       ///< Images [1/s]; > 0.
  double noise_grey{1.0};  ///< Standard deviation of a pixel [grey levels of 255].
  /// True: markers are projected by the model, with noise, instead of drawn and detected.
  bool kinematic{false};
  double noise_px{0.3};   ///< Standard deviation of a projected marker's coordinate [px].
  double blur{0.0};       ///< Standard deviation of a Gaussian blur [px]; in [0, 10].
  double gain_step{0.0};  ///< Exposure jumps: the log of the gain is uniform in ± this; in [0, 1].
  double gain_period{1.0};  ///< Mean time between two jumps [s]; > 0.
  int latency_frames{1};    ///< Features arrive this many images after the exposure; >= 0.
  double drop_rate{0.0};    ///< Share of images that are lost; in [0, 1).
  double position_error{
      0.0};  ///< Standard deviation of each axis of the pose's constant error [m].
  double rotation_error{0.0};  ///< The same of its rotation vector [rad].
  double focal_error{0.0};     ///< Standard deviation of the true focal length, relative [-].
};

/// How the goal's markers move: by a (1 - cos ωt) / 2 + b (1 - cos 2ωt) / 2, from rest.
struct GoalMotion {
  Eigen::Vector3d a{Eigen::Vector3d::Zero()};  ///< In world axes [m].
  Eigen::Vector3d b{Eigen::Vector3d::Zero()};  ///< The same [m].
  double period{20.0};                         ///< 2π / ω [s]; > 0.
};

/// What the simulated images are drawn with.
enum class RendererBackend {
  kAuto,    ///< OSMesa, or EGL where that is not installed.
  kOsmesa,  ///< Mesa's software renderer in the process.
  kEgl,     ///< EGL without a surface: a GPU where there is one.
};

/// Options of the simulator.
struct SimOptions {
  JointVector q_start;               ///< True joints at the start [rad or m].
  std::vector<Marker> goal_markers;  ///< Markers in the scene, in the world; may be empty.
  GoalMotion goal_motion;            ///< Of all goal markers together; by default they stand.
  ArmEffects arm;                    ///< Lag, noise and watchdog of the simulated arm.
  CameraEffects camera;              ///< Rate, delay, noise and errors of the simulated camera.
  /// Not used where CameraEffects::kinematic is true.
  RendererBackend renderer{RendererBackend::kAuto};
  double step{0.001};     ///< Of the plants [s]; > 0.
  std::uint64_t seed{1};  ///< Of every random number.
};

}  // namespace vantage
