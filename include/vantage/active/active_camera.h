#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include "vantage/active/rig_motion.h"
#include "vantage/active/trigger.h"
#include "vantage/active/view.h"
#include "vantage/active/view_planner.h"
#include "vantage/camera/camera_rig.h"
#include "vantage/math/spatial.h"
#include "vantage/math/time.h"
#include "vantage/observability/measures.h"

/// @file
/// The active camera: watches a measure of observability, and moves the camera to a better view when
/// it falls below a threshold (docs/active-camera.md). A pure function of (state, inputs, time).

namespace vantage {

/// How the camera is moved.
enum class ActiveMode : int {
  kTrigger = 0,  ///< To a better view chosen by the planner, when the trigger asks for it.
  kGradient,     ///< Always up the gradient of the measure, for comparison.
};

/// Settings of an active camera.
struct ActiveOptions {
  ActiveMode mode{ActiveMode::kTrigger};  ///< How the camera is moved: see ActiveMode.
  bool enabled{true};                     ///< False: measure and trigger, but never move.
  TriggerOptions trigger;                 ///< When the view counts as too poor.
  PlannerOptions planner;       ///< How a better view is sought, and what every view must keep.
  double replan_interval{0.5};  ///< Least time between two plans [s]; > 0.
  double look_ahead{0.6};  ///< A marker predicted to be lost within this time fires too [s]; >= 0.
};

/// Throws ConfigError (key "active...") when an option is out of bounds.
void Validate(const ActiveOptions& options);

/// Where the active camera is in its cycle.
enum class ActiveState : int {
  kWatching = 0,  ///< The view is good, or no better one is known.
  kMoving = 1,    ///< On its way to a better view.
  kDisabled = 2,
};

/// Why the camera was last asked to move.
enum class ActiveReason : int {
  kNone = 0,
  kLowMeasure,    ///< The trigger's measure fell below its threshold.
  kMarkerLost,    ///< A marker is not seen.
  kMarkerAtRisk,  ///< A marker is predicted to be lost.
  kStalled,       ///< The servo does not get nearer.
};

/// Why the camera does not move though it is asked to.
enum class ActiveRefusal : int {
  kNone = 0,       ///< It moves, or is not asked to.
  kArm,            ///< The arm is near a singularity: no view can help.
  kNoBetterView,   ///< No view is better by enough.
  kNoView,         ///< No view of the rig's sees every marker.
  kNoPath,         ///< Every way to a better view loses a marker.
  kRigCannotMove,  ///< The rig is fixed, or every axis is locked.
  kGuard,          ///< Going on would lose a marker that is seen now: the camera waits.
  kBadInputs,      ///< Joints or pose of the wrong size, or not finite.
};

/// What the active camera knows at one instant: measured, nothing from a simulator.
struct ActiveInputs {
  Time now{};          ///< Of the control period that all the rest belongs to.
  JointVector q;       ///< Measured joints.
  JointVector qdot;    ///< Commanded joint velocity [rad/s or m/s].
  JointVector q_goal;  ///< Joints the task is predicted to end at; q when unknown.
  std::vector<PlacedMarker>
      goal_markers;  ///< Markers in the scene that must stay seen; may be empty.
  Eigen::Isometry3d X_WC{Eigen::Isometry3d::Identity()};  ///< Measured camera pose.
  Measure composite;                ///< Of J_c, as the control period computed it.
  LowCause cause{LowCause::kNone};  ///< Why w_c is low, as the control period judged it.
  int markers_lost{0};      ///< Markers the features need that the last image does not show.
  bool stalled{false};      ///< The servo's error has stopped falling above the tolerance.
  bool uncertified{false};  ///< It is at its goal by the image, in a view that hides too much.
  double error_px{0.0};     ///< Root mean square error of the feature rows [px].
  double mm_per_px{0.0};    ///< Worst motion of a marker that one pixel may hide [mm/px].
};

/// What one step of the active camera decides.
struct ActiveOutput {
  ActiveState state{ActiveState::kWatching};    ///< Where in its cycle it is after the step.
  ActiveReason reason{ActiveReason::kNone};     ///< Why it was last asked to move.
  ActiveRefusal refusal{ActiveRefusal::kNone};  ///< Why it does not move though asked to.
  RigVector q_c;                                ///< Commanded rig coordinates.
  Eigen::Isometry3d X_WC{Eigen::Isometry3d::Identity()};  ///< Commanded camera pose.
  JointVector q_goal;         ///< Joints the task is predicted to end at; empty: unknown.
  double trigger_value{0.0};  ///< The trigger's measure now.
  bool triggered{false};      ///< Below the threshold, hysteresis included.
  double gain{0.0};           ///< Relative gain of the measure that the last move promised.
  std::int64_t plans{0};      ///< Plans made so far.
  std::int64_t moves{0};      ///< Moves begun so far.
  std::int64_t fruitless{0};  ///< Plans that found no better view.
  /// ∂ log w_c / ∂q for the arm's own motions: the camera task's to fill in; no rows: not known [1/rad].
  JointVector log_w_gradient{};
};

/// State machine trigger -> plan -> move. Call Step() at a steady rate (20-200 Hz); a step that plans
/// takes milliseconds, so it belongs in a thread of its own.
class ActiveCamera {
 public:
  /// Throws ConfigError when an option is out of bounds, the model or the rig does not validate, or
  /// q_c_start is not of the rig's size or not within its limits.
  ActiveCamera(ViewModel model, CameraRig rig, const RigVector& q_c_start,
               const ActiveOptions& options);

  /// One step. Deterministic: the same inputs in the same order give the same outputs. Time that runs
  /// backwards counts as standing; a pause longer than a tenth of a second counts as that long, so that
  /// the command never leaps.
  [[nodiscard]] ActiveOutput Step(const ActiveInputs& inputs);

 private:
  [[nodiscard]] bool UsableInputs(const ActiveInputs& inputs) const;
  void FollowRig(const ActiveInputs& inputs);
  void Move(double dt, const ActiveInputs& inputs);
  void ClimbGradient(double dt);
  [[nodiscard]] bool WouldLoseMarker(const ActiveInputs& inputs, double dt) const;
  [[nodiscard]] bool MarkerAtRisk(const ActiveInputs& inputs);
  [[nodiscard]] ActiveReason Demand(const ActiveInputs& inputs);
  void Plan(const ActiveInputs& inputs, ActiveReason reason);
  void PlanOnTheWay(const ActiveInputs& inputs);
  void RememberSpoiled(const ActiveInputs& inputs);
  [[nodiscard]] PlanRequest RequestFrom(const ActiveInputs& inputs, const RigVector& q_c) const;
  void Begin(const RigPath& path, double gain, bool may_lose);
  const ActiveOutput& Publish(const ActiveInputs& inputs);

  ViewModel model_;
  CameraRig rig_;
  ActiveOptions options_;

  TriggerState trigger_;
  RigMotion motion_;
  bool moving_{false};
  std::optional<RigPath> next_;  // to take once at rest
  double next_gain_{0.0};
  bool next_loses_{false};
  bool may_lose_{false};  // on this way, by plan
  bool started_{false};
  Time last_step_{};
  std::optional<Time> last_plan_;
  std::optional<Time> held_since_;    // by the guard
  double held_at_{0.0};               // where on the path, by the guard
  std::optional<Time> astray_since_;  // the rig stands elsewhere than commanded
  struct SpoiledView {
    Eigen::Isometry3d X_WC;
    JointVector q;  // where the arm was
  };
  std::vector<SpoiledView> spoiled_;  // views that did not show what the model sees
  int spare_markers_{0};              // any so many of the arm's may be missing
  int lost_count_{0};                 // steps in a row with a marker lost
  int fruitless_in_a_row_{0};
  ArmSample sample_, soon_;  // of this step
  JointVector q_soon_;       // where a marker is at risk; empty: none is
  ActiveOutput output_;
};

/// Joints after `ahead` seconds at the commanded velocity, not past the goal. @pre sizes agree.
[[nodiscard]] JointVector PredictJoints(const JointVector& q, const JointVector& qdot,
                                        const JointVector& q_goal, double ahead) noexcept;

/// Names as printed and logged: "WATCHING", "LOW_MEASURE", "NO_BETTER_VIEW", ...
[[nodiscard]] const char* Name(ActiveState state) noexcept;
[[nodiscard]] const char* Name(ActiveReason reason) noexcept;
[[nodiscard]] const char* Name(ActiveRefusal refusal) noexcept;

}  // namespace vantage
