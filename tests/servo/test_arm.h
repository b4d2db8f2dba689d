#pragma once

#include <algorithm>
#include <initializer_list>
#include <vector>

#include <Eigen/Geometry>

#include "vantage/active/view.h"
#include "vantage/math/angles.h"

/// @file
/// The small arm that the tests of the servo move, and what a camera looks at on it.

namespace vantage::test {

inline constexpr double kPeriod = 0.002;  ///< Of the control loop [s].

inline JointVector Joints(std::initializer_list<double> values) {
  JointVector q(static_cast<Eigen::Index>(values.size()));
  std::copy(values.begin(), values.end(), q.data());
  return q;
}

/// Camera at p, looking at `target`, image up along Wz.
inline Eigen::Isometry3d LookFrom(const Eigen::Vector3d& p,
                                  const Eigen::Vector3d& target = {0.5, 0.0, 0.5}) {
  const Eigen::Vector3d z = (target - p).normalized();
  const Eigen::Vector3d x = z.cross(Eigen::Vector3d::UnitZ()).normalized();
  Eigen::Isometry3d X_WC = Eigen::Isometry3d::Identity();
  X_WC.linear() << x, z.cross(x), z;
  X_WC.translation() = p;
  return X_WC;
}

/// Arm of the PUMA type: three joints, or five with a bend and a turn more; links of 0.4 m.
inline ArmModel PumaArm(int joints = 3) {
  const double right = kPi / 2.0;
  std::vector<DhRow> rows{{JointKind::kRevolute, 0.0, 0.4, 0.0, right, 0.0},
                          {JointKind::kRevolute, 0.0, 0.0, 0.4, 0.0, 0.0},
                          {JointKind::kRevolute, 0.0, 0.0, 0.4, 0.0, 0.0},
                          {JointKind::kRevolute, 0.0, 0.0, 0.15, right, 0.0},
                          {JointKind::kRevolute, 0.0, 0.1, 0.1, 0.0, 0.0}};
  rows.resize(static_cast<std::size_t>(joints));
  JointLimits limit;
  limit.velocity = 1.5;
  limit.acceleration = 8.0;
  return ArmModel("test", DhConvention::kStandard, rows,
                  std::vector<JointLimits>(static_cast<std::size_t>(joints), limit),
                  Eigen::Isometry3d::Identity(), Eigen::Isometry3d::Identity());
}

/// x and y of a dot at the tip and x of one beside it: three features.
inline ViewModel PumaView(int joints = 3) {
  std::vector<Marker> markers(2);
  markers[1].id = 1;
  markers[1].p = {0.0, 0.0, 0.15};
  return {
      PumaArm(joints), CameraModel(),
      FeatureSet(
          {{FeatureKind::kPointX, {0}}, {FeatureKind::kPointY, {0}}, {FeatureKind::kPointX, {1}}},
          2),
      markers};
}

inline std::vector<Eigen::Vector3d> MarkersAt(const ViewModel& view, const JointVector& q) {
  std::vector<Eigen::Vector3d> points;
  for (const Marker& m : view.markers) points.push_back(EndEffectorPose(view.arm, q) * m.p);
  return points;
}

}  // namespace vantage::test
