#pragma once

#include <vector>

#include "vantage/active/rig_motion.h"
#include "vantage/active/trigger.h"
#include "vantage/active/view.h"
#include "vantage/camera/camera_rig.h"
#include "vantage/math/sizes.h"

/// @file
/// Chooses a better view of the motion that is still to come, and a way there (docs/active-camera.md).
/// A pure function: the same request gives the same plan.

namespace vantage {

/// Settings of the view planner.
struct PlannerOptions {
  int candidates{192};  ///< Camera positions tried per plan; >= 8.
  int path_samples{5};  ///< Configurations between now and the goal each one is scored at; 1-16.
  double travel_cost{0.03};  ///< Cost per metre or radian of camera travel, in units of log w / s.
  double cap{4.0};           ///< Measures above cap * threshold count as good enough; > 1.
  double min_gain{0.15};     ///< Relative gain of w_c^(1/s) that a move must promise; >= 0.
  /// A view of the motion's end in which one pixel may hide more than this is worth less by the ratio of
  /// the two [mm/px]; > 0.
  double max_mm_per_px{8.0};
  ViewLimits limits;  ///< What every view chosen must keep.
};

/// Throws ConfigError (key "active.planner...") when an option is out of bounds.
void Validate(const PlannerOptions& options);

/// Most configurations a view is scored at.
inline constexpr int kMaxPathSamples = 16;

/// What to plan for.
struct PlanRequest {
  JointVector q;       ///< Joints now.
  JointVector q_goal;  ///< Joints the motion is predicted to end at.
  JointVector q_soon;  ///< Joints shortly, where every marker must be seen too; may be empty.
  double progress_rate{0.0};  ///< The arm is at q + (1 - exp(-rate t)) (q_goal - q) after t [1/s].
  std::vector<PlacedMarker>
      goal_markers;    ///< Markers in the scene that must be seen; may be empty.
  RigVector q_c;       ///< Where the camera starts from, at rest.
  RigVector q_c_stay;  ///< The view that a plan must better: q_c, or where the camera is going.
  bool stay_is_spoiled{false};  ///< Something the model does not know of spoils that view.
  /// The arm is at its goal by the image: what counts is a view that certifies it.
  bool certify{false};
  /// Views where markers were lost that the model sees: no view near one of them is chosen.
  std::vector<Eigen::Isometry3d> X_WSpoiled;
  /// So many of the arm's markers may be missing: the features that are left are enough to go on with.
  int spare_markers{0};
  /// The goal's markers need not be seen: of a goal at rest it is known where it was seen.
  bool goal_optional{false};
  /// Markers may go out of sight on the way: the arm waits until they are seen again. Ways that lose
  /// fewer are still preferred.
  bool may_lose{false};
};

/// Outcome of a plan.
enum class PlanVerdict : int {
  kMove = 0,       ///< Go along `path`.
  kNoGain,         ///< No view is better by enough.
  kNoView,         ///< No view sees every marker even now.
  kNoPath,         ///< Better views are there, but every way there loses a marker.
  kRigCannotMove,  ///< Every axis is locked, or there is none.
};

/// A view's worth along the motion to come.
struct ViewScore {
  double score{0.0};  ///< Mean over the samples of log of the measure, see ScoreView().
  int seen{0};        ///< Samples up to the first at which a marker is not seen.
  ViewFault fault{ViewFault::kNone};  ///< Why not, there.
};

/// A plan for the camera, and the view it has without one.
struct ViewPlan {
  PlanVerdict verdict{PlanVerdict::kNoGain};  ///< Whether to go, or why not.
  RigPath path;          ///< From the request's q_c to the new view; of kMove alone.
  double duration{0.0};  ///< Of the move [s].
  bool loses{false};     ///< Markers go out of sight on the way.
  ViewScore stay;        ///< The view that a plan must better: of q_c_stay.
  ViewScore move;        ///< The view chosen.
  double gain{0.0};      ///< Promised ratio of the measure to that of staying, less 1.
  int views_scored{0};   ///< Views compared, for the record.
};

/// The arm's motion to come as the planner samples it: `samples` configurations from q to q_goal, evenly
/// spaced in the joints, one when the two are equal.
[[nodiscard]] std::vector<ArmSample> SampleMotion(const ViewModel& model, const JointVector& q,
                                                  const JointVector& q_goal, int samples);

/// The logarithm of the trigger's measure (of w_c^(1/s) for w_c itself) along `motion` seen from X_WC:
/// mean over the samples, each bounded from above by the cap and from below by a thousandth of the
/// threshold. From the first sample on where a marker is not seen it counts as that thousandth. Where
/// det J_c changes its sign from one sample to the next (k = n), w_c is 0 in between: that stretch
/// counts as worse by a factor e. A view that does not certify the motion's end (options.max_mm_per_px)
/// counts as worse by as many times as it hides too much.
[[nodiscard]] ViewScore ScoreView(const ViewModel& model, const TriggerOptions& trigger,
                                  const PlannerOptions& options,
                                  const std::vector<ArmSample>& motion,
                                  const std::vector<PlacedMarker>& goal_markers,
                                  const Eigen::Isometry3d& X_WC);

/// True when some view of the rig sees every marker all along `motion`, and the goal's.
/// @param q_c  Where the camera is: tried first.
[[nodiscard]] bool CanWatch(const ViewModel& model, const CameraRig& rig,
                            const PlannerOptions& options, const std::vector<ArmSample>& motion,
                            const std::vector<PlacedMarker>& goal_markers, const RigVector& q_c);

/// Plans. Takes milliseconds and allocates: not for the control period.
/// @pre sizes fit the model and the rig; q_c is within the rig's limits.
[[nodiscard]] ViewPlan PlanView(const ViewModel& model, const CameraRig& rig,
                                const TriggerOptions& trigger, const PlannerOptions& options,
                                const PlanRequest& request);

}  // namespace vantage
