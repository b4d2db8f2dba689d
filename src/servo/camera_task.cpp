#include "vantage/servo/camera_task.h"

namespace vantage {
namespace {

// The goal's joints are solved for anew when a goal point has moved by more than this [m].
constexpr double kGoalMoved = 1e-3;
// A goal further from what the arm can reach than this is no prediction [m].
constexpr double kReachable = 0.05;

}  // namespace

CameraTask::CameraTask(const ServoTask& task, const CameraRig& rig, const RigVector& q_c_start,
                       const ActiveOptions& options)
    : task_(task), camera_(task.view, rig, q_c_start, options) {
  for (const Marker& marker : task_.view.markers) p_EM_.push_back(marker.p);
}

ActiveOutput CameraTask::Step(const ServoSnapshot& snapshot) {
  ActiveInputs inputs = snapshot.active;
  bool moved = p_WG_.empty();
  for (std::size_t i = 0; i < p_WG_.size(); ++i) {
    moved = moved || (snapshot.p_WG[i] - p_WG_[i]).norm() > kGoalMoved;
  }
  if (moved) {
    p_WG_.assign(snapshot.p_WG.begin(), snapshot.p_WG.begin() + snapshot.goal_count);
    // From the joints now, so that the branch the arm will take is the one predicted.
    const PointGoalSolution solution = SolveForPoints(task_.view.arm, p_EM_, p_WG_, inputs.q);
    q_goal_ = solution.rms_error < kReachable ? solution.q : inputs.q;
  }
  inputs.q_goal = q_goal_;
  inputs.goal_markers.clear();
  for (std::size_t i = 0; i < task_.goal.marker_ids.size(); ++i) {
    inputs.goal_markers.push_back(
        {snapshot.p_marker[i], task_.goal.normals[i], task_.goal.marker_radius});
  }
  ActiveOutput output = camera_.Step(inputs);
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
