#include "sim/suite/run_task.h"

#include <algorithm>
#include <memory>

#include "sim/lockstep.h"
#include "sim/suite/quantile.h"
#include "vantage/math/angles.h"

namespace vantage::sim {
namespace {

// One goal; the lockstep is left as it ended.
TaskResult PlayGoal(const Scenario& scenario, const JointVector& q_goal, Lockstep* lockstep) {
  const bool follows = Follows(scenario);
  TaskResult result;
  Eigen::Vector3d p_WC = lockstep->world().X_WC().translation();
  int seen_before = 0;
  std::int64_t periods = 0, low = 0;
  std::vector<double> errors;  // of a goal that moves
  ServoStatus status;
  while (lockstep->time() < scenario.time_limit && (follows || !result.converged)) {
    const ServoOutput& output = lockstep->Tick();
    status = output.status;
    if (status.markers_seen < seen_before) ++result.lost_events;
    seen_before = status.markers_seen;
    const Eigen::Vector3d p_WNow = lockstep->world().X_WC().translation();
    result.travel_m += (p_WNow - p_WC).norm();
    p_WC = p_WNow;
    result.mm_per_px = output.observability.mm_per_px;
    result.converged = status.state == ServoState::kConverged;
    ++periods;
    if (output.observability.trigger_value < output.observability.threshold) ++low;
    if (follows && lockstep->time() >= kFollowFrom) {
      errors.push_back(1e3 * lockstep->world().truth().worst_error);
    }
  }
  const GroundTruth truth = lockstep->world().truth();
  result.duration = lockstep->time();
  result.true_error_mm = follows ? Quantile(errors, 0.95) : 1e3 * truth.worst_error;
  result.joint_error_deg = (truth.q - q_goal).lpNorm<Eigen::Infinity>() * 180.0 / kPi;
  result.error_px = status.error_px;
  result.moves = lockstep->active().moves;
  result.limit_violations = truth.limit_violations;
  result.low_share =
      static_cast<double>(low) / static_cast<double>(std::max<std::int64_t>(1, periods));
  result.success = follows ? result.true_error_mm < kFollowMillimetres
                           : result.converged && result.true_error_mm < kSuccessMillimetres;
  result.goals_reached = result.success ? 1 : 0;
  if (result.converged) {
    result.end = "converged";
  } else {
    result.end = Name(status.state);
    if (status.reason != HoldReason::kNone) result.end += std::string(" ") + Name(status.reason);
  }
  return result;
}

// Adds what came after; the last goal's verdict is the whole's.
void Append(const TaskResult& after, TaskResult* all) {
  const double time = all->duration + after.duration;
  const double low = all->low_share * all->duration + after.low_share * after.duration;
  TaskResult sum = after;
  sum.duration = time;
  sum.low_share = time > 0.0 ? low / time : 0.0;
  sum.true_error_mm = std::max(all->true_error_mm, after.true_error_mm);
  sum.joint_error_deg = std::max(all->joint_error_deg, after.joint_error_deg);
  sum.lost_events += all->lost_events;
  sum.travel_m += all->travel_m;
  sum.moves += all->moves;
  sum.limit_violations += all->limit_violations;
  sum.goals_reached += all->goals_reached;
  *all = sum;
}

}  // namespace

Scenario NextStage(const Scenario& before, const GoalStage& next, const JointVector& q,
                   const RigVector& q_c) {
  Scenario stage = before;
  stage.task.goal = next.goal;
  stage.sim.goal_markers = next.goal_markers;
  stage.p_WG_true = next.p_WG_true;
  stage.sim.q_start = q;
  if (stage.active.enabled) stage.q_c_start = q_c;
  return stage;
}

TaskResult RunTask(const Scenario& scenario, const SuiteTask& task) {
  Scenario stage = scenario;
  auto lockstep = std::make_unique<Lockstep>(stage);
  TaskResult result = PlayGoal(stage, task.q_goal, lockstep.get());
  for (const GoalStage& next : task.next) {
    if (!result.success) break;
    stage = NextStage(stage, next, lockstep->world().truth().q, lockstep->active().q_c);
    lockstep = std::make_unique<Lockstep>(stage);
    Append(PlayGoal(stage, next.q_goal, lockstep.get()), &result);
  }
  return result;
}

}  // namespace vantage::sim
