#include "vantage/servo/camera_task.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "vantage/features/feature_gradient.h"
#include "vantage/servo/branch_choice.h"

namespace vantage {
namespace {

// The goal's joints are solved for anew when a goal point has moved by more than this [m].
constexpr double kGoalMoved = 1e-3;
// A solution nearer than this to every goal point is one; estimated points never fit exactly [m].
constexpr double kSolved = 3e-3;
// After a goal has moved by more than this, the branch taken for the last one means nothing [m].
constexpr double kGoalElsewhere = 0.03;
// A servo that stalls with a larger error than this [px], for so many steps, is stuck.
constexpr double kStuckError = 3.0;
constexpr int kStuckSteps = 200;

}  // namespace

CameraTask::CameraTask(const ServoTask& task, const CameraRig& rig, const RigVector& q_c_start,
                       const ActiveOptions& options)
    : task_(task),
      rig_(rig),
      planner_(options.planner),
      camera_(task.view, rig, q_c_start, options),
      q_c_(q_c_start) {
  for (const Marker& marker : task_.view.markers) p_EM_.push_back(marker.p);
}

// Joints at the goal: from the last solution, so that the branch stays; at first, and when there is none
// near it, the branch is chosen anew.
void CameraTask::SolveForGoal(const ActiveInputs& inputs, bool anew) {
  if (!anew && q_goal_.size() > 0) {
    const double fit = std::max(kSolved, kFitSlack * fit_);
    const auto near = SolveForPoints(task_.view.arm, p_EM_, p_WG_, q_goal_, fit);
    if (near.converged) {
      q_goal_ = near.q;
      return;
    }
  }
  q_goal_ = ChooseBranch(inputs);
}

JointVector CameraTask::ChooseBranch(const ActiveInputs& inputs) {
  const BranchRequest request{inputs.q, p_EM_, p_WG_, inputs.goal_markers, q_c_, failed_};
  const Branch branch = vantage::ChooseBranch(task_.view, rig_, planner_, request, kSolved);
  fit_ = branch.fit;
  return branch.q;
}

// A servo that stands before a goal it does not reach is on the wrong branch, if there is another one.
void CameraTask::EscapeStall(const ActiveInputs& inputs) {
  const bool stuck = inputs.stalled && !inputs.uncertified && inputs.error_px > kStuckError;
  stalled_steps_ = std::max(0, stalled_steps_ + (stuck ? 2 : -1));
  if (stalled_steps_ < kStuckSteps || q_goal_.size() == 0) return;
  stalled_steps_ = 0;
  failed_.push_back(q_goal_);
  JointVector other = ChooseBranch(inputs);
  if (other.size() == 0) {
    failed_.clear();
    other = ChooseBranch(inputs);
  }
  q_goal_ = other;
}

ActiveOutput CameraTask::Step(const ServoSnapshot& snapshot) {
  ActiveInputs inputs = snapshot.active;
  inputs.goal_markers.clear();
  for (std::size_t i = 0; i < task_.goal.marker_ids.size(); ++i) {
    inputs.goal_markers.push_back(
        {snapshot.p_marker[i], task_.goal.normals[i], task_.goal.marker_radius});
  }
  double moved = p_WG_.empty() ? std::numeric_limits<double>::infinity() : 0.0;
  for (std::size_t i = 0; i < p_WG_.size(); ++i) {
    moved = std::max(moved, (snapshot.p_WG[i] - p_WG_[i]).norm());
  }
  if (moved > kGoalMoved) {
    p_WG_.assign(snapshot.p_WG.begin(), snapshot.p_WG.begin() + snapshot.goal_count);
    SolveForGoal(inputs, moved > kGoalElsewhere);
  }
  EscapeStall(inputs);
  inputs.q_goal = q_goal_.size() > 0 ? q_goal_ : inputs.q;
  ActiveOutput output = camera_.Step(inputs);
  output.q_goal = q_goal_;
  // Of use only where the features leave the joints freedom.
  const auto rows = static_cast<int>(task_.view.features.features().size());
  if (std::min(rows, kTaskDimension) < task_.view.arm.size()) {
    output.log_w_gradient = LogCompositeGradient(task_.view, inputs.q, inputs.X_WC);
  }
  q_c_ = output.q_c;
  return output;
}

JointVector LogCompositeGradient(const ViewModel& view, const JointVector& q,
                                 const Eigen::Isometry3d& X_WC) {
  const Kinematics kinematics = ComputeKinematics(view.arm, q);
  const Eigen::Isometry3d X_CE = X_WC.inverse() * kinematics.X_WE;
  PointViews points;
  for (const Marker& marker : view.markers) points.push_back(ViewOf(X_CE * marker.p, true));
  FeatureRows rows;
  view.features.Evaluate(view.camera, points, &rows, InteractionSource::kClosedForm);
  const Eigen::Vector3d p_WE = kinematics.X_WE.translation();
  const TaskJacobian J_c = ImageJacobian(rows.L_body, X_WC, p_WE).lazyProduct(kinematics.J_WE_W);
  const LogGradient log_w = GradientOfLog(Decompose(J_c));
  if (log_w.status != GradientStatus::kOk) {
    return JointVector::Constant(q.size(), std::numeric_limits<double>::quiet_NaN());
  }
  return GradientThroughComposite(view.features, view.camera, points, rows,
                                  {X_WC, p_WE, kinematics.J_WE_W}, log_w.by_J)
      .joints;
}

}  // namespace vantage
