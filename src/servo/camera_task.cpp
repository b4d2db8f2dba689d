#include "vantage/servo/camera_task.h"

#include <algorithm>
#include <limits>

namespace vantage {
namespace {

// The goal's joints are solved for anew when a goal point has moved by more than this [m].
constexpr double kGoalMoved = 1e-3;
// A solution nearer than this to every goal point is one; estimated points never fit exactly [m].
constexpr double kSolved = 3e-3;
// After a goal has moved by more than this, the branch taken for the last one means nothing [m].
constexpr double kGoalElsewhere = 0.03;
// A goal further from what the arm can reach than this is no prediction [m].
constexpr double kReachable = 0.05;

}  // namespace

CameraTask::CameraTask(const ServoTask& task, const CameraRig& rig, const RigVector& q_c_start,
                       const ActiveOptions& options)
    : task_(task), camera_(task.view, rig, q_c_start, options) {
  for (const Marker& marker : task_.view.markers) p_EM_.push_back(marker.p);
}

// Joints at the goal: from the last solution, so that the branch stays; at first, and when there is none
// near it, from the joints now, so that the nearest branch is taken.
void CameraTask::SolveForGoal(const JointVector& q, bool anew) {
  if (!anew && q_goal_.size() > 0) {
    const auto near = SolveForPoints(task_.view.arm, p_EM_, p_WG_, q_goal_, kSolved);
    if (near.converged) {
      q_goal_ = near.q;
      return;
    }
  }
  const auto solution = SolveForPoints(task_.view.arm, p_EM_, p_WG_, q, kSolved);
  q_goal_ = solution.rms_error < kReachable ? solution.q : JointVector();
}

ActiveOutput CameraTask::Step(const ServoSnapshot& snapshot) {
  ActiveInputs inputs = snapshot.active;
  double moved = p_WG_.empty() ? std::numeric_limits<double>::infinity() : 0.0;
  for (std::size_t i = 0; i < p_WG_.size(); ++i) {
    moved = std::max(moved, (snapshot.p_WG[i] - p_WG_[i]).norm());
  }
  if (moved > kGoalMoved) {
    p_WG_.assign(snapshot.p_WG.begin(), snapshot.p_WG.begin() + snapshot.goal_count);
    SolveForGoal(inputs.q, moved > kGoalElsewhere);
  }
  inputs.q_goal = q_goal_.size() > 0 ? q_goal_ : inputs.q;
  inputs.goal_markers.clear();
  for (std::size_t i = 0; i < task_.goal.marker_ids.size(); ++i) {
    inputs.goal_markers.push_back(
        {snapshot.p_marker[i], task_.goal.normals[i], task_.goal.marker_radius});
  }
  ActiveOutput output = camera_.Step(inputs);
  output.q_goal = q_goal_;
  // Of use only where the features leave the joints freedom.
  const auto rows = static_cast<int>(task_.view.features.features().size());
  if (std::min(rows, kTaskDimension) < task_.view.arm.size()) {
    output.log_w_gradient = LogCompositeGradient(task_.view, inputs.q, inputs.X_WC);
  }
  return output;
}

JointVector LogCompositeGradient(const ViewModel& view, const JointVector& q,
                                 const Eigen::Isometry3d& X_WC) {
  constexpr double kStep = 1e-4;  // [rad or m]
  const auto log_w = [&](const JointVector& at) {
    return MeasureOf(CompositeJacobian(view, SampleArm(view, at), X_WC)).log_w;
  };
  JointVector gradient(q.size());
  for (int i = 0; i < q.size(); ++i) {
    JointVector more = q;
    JointVector less = q;
    more(i) += kStep;
    less(i) -= kStep;
    gradient(i) = (log_w(more) - log_w(less)) / (2.0 * kStep);
  }
  return gradient;
}

}  // namespace vantage
