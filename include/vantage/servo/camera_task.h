#pragma once

#include "vantage/active/active_camera.h"
#include "vantage/servo/servo.h"

namespace vantage {

/// Time between two steps of a CameraTask, in vantage-servo and in lockstep.
inline constexpr Duration kCameraTaskPeriod = std::chrono::milliseconds(20);

/// The slow half of a servo: predicts where the task will end and lets the active camera decide. Runs
/// beside the control period, on its snapshots.
class CameraTask {
 public:
  /// Throws ConfigError when the options or the rig do not validate.
  CameraTask(const ServoTask& task, const CameraRig& rig, const RigVector& q_c_start,
             const ActiveOptions& options);

  /// One step on the newest snapshot. May take milliseconds when it plans.
  /// @pre snapshot.valid.
  [[nodiscard]] ActiveOutput Step(const ServoSnapshot& snapshot);

 private:
  void SolveForGoal(const ActiveInputs& inputs, bool anew);
  [[nodiscard]] JointVector ChooseBranch(const ActiveInputs& inputs);
  void EscapeStall(const ActiveInputs& inputs);

  ServoTask task_;
  CameraRig rig_;
  PlannerOptions planner_;
  ActiveCamera camera_;
  std::vector<Eigen::Vector3d> p_EM_;  // markers on the end effector
  std::vector<Eigen::Vector3d> p_WG_;  // goal that q_goal_ was solved for
  JointVector q_goal_;                 // empty: out of reach
  double fit_{0.0};                    // rms distance that q_goal_ leaves [m]
  RigVector q_c_;                      // where the camera is
  int stalled_steps_{0};
  std::vector<JointVector> failed_;  // branches on which the servo stalled
};

/// ∂ log w_c / ∂q at q, by the model and in closed form [1/rad or 1/m]. Not finite where J_c is singular.
[[nodiscard]] JointVector LogCompositeGradient(const ViewModel& view, const JointVector& q,
                                               const Eigen::Isometry3d& X_WC);

}  // namespace vantage
