#include "sim/suite/run_task.h"

#include <cmath>

#include "sim/lockstep.h"

namespace vantage::sim {

TaskResult RunTask(const Scenario& scenario, const JointVector& q_goal) {
  Lockstep lockstep(scenario);
  TaskResult result;
  Eigen::Vector3d p_WC = lockstep.world().X_WC().translation();
  int seen_before = 0;
  ServoStatus status;
  while (lockstep.time() < scenario.time_limit && !result.converged) {
    const ServoOutput& output = lockstep.Tick();
    status = output.status;
    if (status.markers_seen < seen_before) ++result.lost_events;
    seen_before = status.markers_seen;
    const Eigen::Vector3d p_WNow = lockstep.world().X_WC().translation();
    result.travel_m += (p_WNow - p_WC).norm();
    p_WC = p_WNow;
    result.mm_per_px = output.observability.mm_per_px;
    result.converged = status.state == ServoState::kConverged;
  }
  const GroundTruth truth = lockstep.world().truth();
  result.duration = lockstep.time();
  result.true_error_mm = 1e3 * truth.worst_error;
  result.joint_error_deg = (truth.q - q_goal).lpNorm<Eigen::Infinity>() * 180.0 / M_PI;
  result.error_px = status.error_px;
  result.moves = lockstep.active().moves;
  result.limit_violations = truth.limit_violations;
  result.success = result.converged && result.true_error_mm < kSuccessMillimetres;
  if (result.converged) {
    result.end = "converged";
  } else {
    result.end = Name(status.state);
    if (status.reason != HoldReason::kNone) result.end += std::string(" ") + Name(status.reason);
  }
  return result;
}

}  // namespace vantage::sim
