#include "vantage/active/rig_on_arm.h"

#include "vantage/robot/kinematics.h"

namespace vantage {

using Eigen::Vector3d;

CameraRig RigOnArm(const ArmModel& arm, const Eigen::Isometry3d& X_EC, double max_linear_speed) {
  CameraRig rig;
  rig.kind = RigKind::kArm;
  rig.max_linear_speed = max_linear_speed;
  const Kinematics zero = ComputeKinematics(arm, JointVector::Zero(arm.size()));
  rig.X_WC_fixed = zero.X_WE * X_EC;
  for (int i = 0; i < arm.size(); ++i) {
    const Vector3d v = zero.J_WE_W.col(i).head<3>();
    const Vector3d omega = zero.J_WE_W.col(i).tail<3>();
    RigJoint joint;
    joint.prismatic = arm.joint_kinds()[i] == JointKind::kPrismatic;
    joint.axis_W = (joint.prismatic ? v : omega).normalized();
    // v = omega x (p_WE - point), with the point of the axis that is nearest to E.
    if (!joint.prismatic) joint.point_W = zero.X_WE.translation() - v.cross(omega);
    rig.joints.push_back(joint);
    const JointLimits& limits = arm.limits()[i];
    rig.axes.push_back(
        {arm.joint_names()[i], limits.lower, limits.upper, limits.velocity, limits.acceleration});
  }
  Validate(rig);
  return rig;
}

}  // namespace vantage
