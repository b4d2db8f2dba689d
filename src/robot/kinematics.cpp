#include "vantage/robot/kinematics.h"

#include <algorithm>
#include <array>
#include <cassert>

#include "arm_data.h"

namespace vantage {
namespace {

// Pose of link i from that of link i-1.
KDL::Frame NextLink(const ArmJoint& joint, const KDL::Frame& X_WPrevious, double q) {
  const KDL::Frame X_segment = joint.segment.pose(q);
  return joint.has_before ? X_WPrevious * joint.X_before * X_segment : X_WPrevious * X_segment;
}

// Squared distance of the point p from the segment a + s u, s in [0, 1].
double SquaredDistance(const Eigen::Vector3d& p, const Eigen::Vector3d& a,
                       const Eigen::Vector3d& u) noexcept {
  const double uu = u.squaredNorm();
  const double s = uu > 0.0 ? std::clamp(u.dot(p - a) / uu, 0.0, 1.0) : 0.0;
  return (p - a - s * u).squaredNorm();
}

}  // namespace

Kinematics ComputeKinematics(const ArmModel& arm, const JointVector& q) noexcept {
  assert(q.size() == arm.size());
  const ArmModel::Data& data = arm.data();
  const int n = data.size();
  std::array<KDL::Vector, kMaxJoints> origin;  // A point on each joint's axis, in W.
  std::array<KDL::Vector, kMaxJoints> axis;    // The axis' direction, in W.
  KDL::Frame X = data.base;
  for (int i = 0; i < n; ++i) {
    const ArmJoint& joint = data.joints[i];
    if (joint.has_before) X = X * joint.X_before;
    origin[i] = X.p;
    axis[i] = X.M.UnitZ();
    X = X * joint.segment.pose(q(i));
  }
  X = X * data.tool;

  Kinematics result;
  result.X_WE = FromKdl(X);
  result.J_WE_W.resize(6, n);
  for (int i = 0; i < n; ++i) {
    if (data.joint_kinds[i] == JointKind::kRevolute) {
      result.J_WE_W.col(i).head<3>() = FromKdl(axis[i] * (X.p - origin[i]));  // Cross product.
      result.J_WE_W.col(i).tail<3>() = FromKdl(axis[i]);
    } else {
      result.J_WE_W.col(i).head<3>() = FromKdl(axis[i]);
      result.J_WE_W.col(i).tail<3>().setZero();
    }
  }
  return result;
}

Eigen::Isometry3d EndEffectorPose(const ArmModel& arm, const JointVector& q) noexcept {
  assert(q.size() == arm.size());
  const ArmModel::Data& data = arm.data();
  KDL::Frame X = data.base;
  for (int i = 0; i < data.size(); ++i) X = NextLink(data.joints[i], X, q(i));
  return FromKdl(X * data.tool);
}

LinkPoses ComputeLinkPoses(const ArmModel& arm, const JointVector& q) noexcept {
  assert(q.size() == arm.size());
  const ArmModel::Data& data = arm.data();
  LinkPoses poses;
  poses.fill(Eigen::Isometry3d::Identity());
  KDL::Frame X = data.base;
  for (int i = 0; i < data.size(); ++i) {
    X = NextLink(data.joints[i], X, q(i));
    poses[i] = FromKdl(X);
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
  double least =
      std::min({SquaredDistance(p_WA, capsule.p_WA, v), SquaredDistance(p_WB, capsule.p_WA, v),
                SquaredDistance(capsule.p_WA, p_WA, u), SquaredDistance(capsule.p_WB, p_WA, u)});
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
