#include "vantage/robot/kinematics.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "arm_data.h"
#include "vantage/math/segment.h"

namespace vantage {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

// As 4×4 matrices: aligned, two lanes at a time.
Isometry3d Times(const Isometry3d& X_AB, const Isometry3d& X_BC) noexcept {
  Isometry3d X_AC;
  X_AC.matrix().noalias() = X_AB.matrix() * X_BC.matrix();
  return X_AC;
}

// X times the joint's motion: a turn about z or a shift along it.
void Move(JointKind kind, double q, Isometry3d* X) noexcept {
  auto& matrix = X->matrix();
  if (kind == JointKind::kPrismatic) {
    matrix.col(3) += q * matrix.col(2);
    return;
  }
  const double c = std::cos(q);
  const double s = std::sin(q);
  const Eigen::Vector4d x = matrix.col(0);
  matrix.col(0) = c * x + s * matrix.col(1);
  matrix.col(1) = c * matrix.col(1) - s * x;
}

}  // namespace

Kinematics ComputeKinematics(const ArmModel& arm, const JointVector& q) noexcept {
  assert(q.size() == arm.size());
  const ArmModel::Data& data = arm.data();
  const int n = data.size();
  Kinematics result;
  result.J_WE_W.resize(6, n);
  // First a point on each axis and its direction; the arms of the levers once E is known.
  Isometry3d X = data.chain[0];
  for (int i = 0; i < n; ++i) {
    result.J_WE_W.col(i).head<3>() = X.translation();
    result.J_WE_W.col(i).tail<3>() = X.linear().col(2);
    Move(data.joint_kinds[i], q(i), &X);
    X = Times(X, data.chain[i + 1]);
  }
  result.X_WE = X;
  for (int i = 0; i < n; ++i) {
    const Vector3d axis = result.J_WE_W.col(i).tail<3>();
    if (data.joint_kinds[i] == JointKind::kRevolute) {
      const Vector3d lever = X.translation() - result.J_WE_W.col(i).head<3>();
      result.J_WE_W.col(i).head<3>() = axis.cross(lever);
    } else {
      result.J_WE_W.col(i).head<3>() = axis;
      result.J_WE_W.col(i).tail<3>().setZero();
    }
  }
  return result;
}

Eigen::Isometry3d EndEffectorPose(const ArmModel& arm, const JointVector& q) noexcept {
  assert(q.size() == arm.size());
  const ArmModel::Data& data = arm.data();
  Isometry3d X = data.chain[0];
  for (int i = 0; i < data.size(); ++i) {
    Move(data.joint_kinds[i], q(i), &X);
    X = Times(X, data.chain[i + 1]);
  }
  return X;
}

LinkPoses ComputeLinkPoses(const ArmModel& arm, const JointVector& q) noexcept {
  assert(q.size() == arm.size());
  const ArmModel::Data& data = arm.data();
  LinkPoses poses;
  poses.fill(Isometry3d::Identity());
  Isometry3d X = data.X_WBase;
  for (int i = 0; i < data.size(); ++i) {
    const ArmJoint& joint = data.joints[i];
    if (joint.has_before) X = Times(X, joint.X_before);
    Move(data.joint_kinds[i], q(i), &X);
    X = Times(X, joint.X_after);
    poses[i] = X;
  }
  return poses;
}

void PlaceCapsules(const ArmModel& arm, const JointVector& q, std::vector<PlacedCapsule>* out) {
  const LinkPoses poses = ComputeLinkPoses(arm, q);
  out->clear();
  for (const Capsule& capsule : arm.capsules()) {
    const Eigen::Isometry3d& X_WL = capsule.link < 0 ? arm.X_WBase() : poses[capsule.link];
    out->push_back({X_WL * capsule.p_LA, X_WL * capsule.p_LB, capsule.radius, capsule.link});
  }
}

bool SegmentHitsCapsule(const Eigen::Vector3d& p_WA, const Eigen::Vector3d& p_WB,
                        const PlacedCapsule& capsule) noexcept {
  // The squared distance of two points, one on each segment, is a convex quadratic of their two
  // parameters in the unit square. Its least value is at the stationary point when that lies
  // inside, else on the border, where one point is an end. Each candidate is a true distance, so
  // nearly parallel segments, whose stationary point is ill defined, do no harm.
  const Eigen::Vector3d u = p_WB - p_WA;
  const Eigen::Vector3d v = capsule.p_WB - capsule.p_WA;
  const Eigen::Vector3d d = p_WA - capsule.p_WA;
  double least = std::min({SquaredDistanceToSegment(p_WA, capsule.p_WA, v),
                           SquaredDistanceToSegment(p_WB, capsule.p_WA, v),
                           SquaredDistanceToSegment(capsule.p_WA, p_WA, u),
                           SquaredDistanceToSegment(capsule.p_WB, p_WA, u)});
  const double uu = u.squaredNorm();
  const double vv = v.squaredNorm();
  const double uv = u.dot(v);
  const double determinant = uu * vv - uv * uv;
  if (determinant > 0.0) {
    const double s = (uv * v.dot(d) - vv * u.dot(d)) / determinant;
    const double t = (uu * v.dot(d) - uv * u.dot(d)) / determinant;
    if (s >= 0.0 && s <= 1.0 && t >= 0.0 && t <= 1.0) {
      least = std::min(least, (d + s * u - t * v).squaredNorm());
    }
  }
  return least < capsule.radius * capsule.radius;
}

}  // namespace vantage
