#pragma once

#include "vantage/active/active_camera.h"
#include "vantage/servo/servo.h"

namespace vantage {

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
  void SolveForGoal(const JointVector& q, bool anew);

  ServoTask task_;
  ActiveCamera camera_;
  std::vector<Eigen::Vector3d> p_EM_;  // markers on the end effector
  std::vector<Eigen::Vector3d> p_WG_;  // goal that q_goal_ was solved for
  JointVector q_goal_;                 // empty: out of reach
};

/// ∂ log w_c / ∂q at q, by central differences of the model's closed forms [1/rad or 1/m]. Not finite where
/// J_c is singular.
[[nodiscard]] JointVector LogCompositeGradient(const ViewModel& view, const JointVector& q,
                                               const Eigen::Isometry3d& X_WC);

}  // namespace vantage
