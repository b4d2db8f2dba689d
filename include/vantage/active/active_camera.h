#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "vantage/active/view.h"
#include "vantage/camera/camera_rig.h"
#include "vantage/math/time.h"
#include "vantage/observability/measures.h"

/// @file
/// The active camera: watches a measure of observability, and moves the camera to a better view when
/// it falls below a threshold (docs/active-camera.md). A pure function of (state, inputs, time).

namespace vantage {

/// Which measure the trigger compares with its threshold.
enum class TriggerMeasure : int {
  kGeometricMean = 0,  ///< w_c^(1/s), the geometric mean singular value of J_c [px/rad].
  kCompositeW,         ///< w_c itself [px^s/rad^s].
  kSigmaMin,           ///< σ_min of J_c [px/rad].
  kInverseCondition,   ///< σ_min / σ_max of J_c [-].
};

struct TriggerOptions {
  TriggerMeasure measure{TriggerMeasure::kGeometricMean};
  double threshold{120.0};   ///< The camera moves below it, in the measure's unit; > 0.
  double hysteresis{1.2};    ///< Re-armed above hysteresis * threshold; >= 1.
  int debounce{3};           ///< Consecutive evaluations below the threshold that fire; >= 1.
};

struct PlannerOptions {
  int candidates{192};          ///< Camera positions tried per plan; >= 8.
  int path_samples{5};          ///< Configurations between now and the goal each one is scored at.
  double travel_cost{0.03};     ///< Cost per metre or radian of camera travel, in units of log w / s.
  double cap{4.0};              ///< Measures above cap * threshold count as good enough; > 1.
  double min_gain{0.15};        ///< Relative gain of w_c^(1/s) that a move must promise.
  ViewLimits limits;
};

struct ActiveOptions {
  bool enabled{true};           ///< False: measure and trigger, but never move.
  TriggerOptions trigger;
  PlannerOptions planner;
  double replan_interval{0.5};  ///< Least time between two plans [s].
  double look_ahead{0.6};       ///< A marker predicted to be lost within this time fires too [s].
};

/// Where the active camera is in its cycle.
enum class ActiveState : int {
  kWatching = 0,   ///< The view is good, or no better one is known.
  kMoving = 1,     ///< On its way to a better view.
  kDisabled = 2,
};

/// Why the camera was last asked to move.
enum class ActiveReason : int {
  kNone = 0,
  kLowMeasure,     ///< The trigger's measure fell below its threshold.
  kMarkerLost,     ///< A marker is not seen.
  kMarkerAtRisk,   ///< A marker is predicted to be lost.
  kStalled,        ///< The servo does not get nearer.
};

/// What the active camera knows at one instant: measured, nothing from a simulator.
struct ActiveInputs {
  Time now{};
  JointVector q;                 ///< Measured joints.
  JointVector qdot;              ///< Commanded joint velocity [rad/s or m/s].
  JointVector q_goal;            ///< Joints the task is predicted to end at; q when unknown.
  std::vector<PlacedMarker> goal_markers;  ///< Markers in the scene that must stay seen; may be empty.
  Eigen::Isometry3d X_WC{Eigen::Isometry3d::Identity()};  ///< Measured camera pose.
  Measure composite;             ///< Of J_c, as the control period computed it.
  LowCause cause{LowCause::kNone};
  int markers_lost{0};           ///< Markers the features need that the last image does not show.
  bool stalled{false};           ///< The servo's error has stopped falling above the tolerance.
  double error_px{0.0};          ///< Norm of the image error [px].
};

struct ActiveOutput {
  ActiveState state{ActiveState::kWatching};
  ActiveReason reason{ActiveReason::kNone};
  RigVector q_c;                                             ///< Commanded rig coordinates.
  Eigen::Isometry3d X_WC{Eigen::Isometry3d::Identity()};     ///< Commanded camera pose.
  double trigger_value{0.0};     ///< The trigger's measure now.
  bool triggered{false};         ///< Below the threshold, hysteresis included.
  std::int64_t plans{0};         ///< Plans made so far.
  std::int64_t moves{0};         ///< Moves begun so far.
  std::int64_t fruitless{0};     ///< Plans that found no better view.
};

/// The measure a trigger compares, from the composite Jacobian's singular values.
[[nodiscard]] double TriggerValue(TriggerMeasure measure, const Measure& composite) noexcept;

/// State machine trigger -> plan -> move. Call Step() at a steady rate (20-200 Hz); a step that plans
/// takes milliseconds, so it belongs in a thread of its own.
class ActiveCamera {
 public:
  /// Throws ConfigError when an option is out of bounds or the rig does not validate.
  ActiveCamera(ViewModel model, CameraRig rig, const RigVector& q_c_start,
               const ActiveOptions& options);

  [[nodiscard]] ActiveOutput Step(const ActiveInputs& inputs);

 private:
  ViewModel model_;
  CameraRig rig_;
  ActiveOptions options_;
  // The rest is the implementation's.
};

}  // namespace vantage
