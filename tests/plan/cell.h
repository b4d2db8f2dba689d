#pragma once

#include "vantage/active/view.h"
#include "vantage/math/angles.h"
#include "vantage/plan/placement.h"

/// @file
/// A PUMA 560 with four dots, or its first three joints with two, and a camera on a sphere about its work: for
/// the tests of placement and for bench_plan and bench_placement.

namespace vantage::test {

inline ArmModel Puma(int joints) {
  const double right = kPi / 2.0;
  std::vector<DhRow> rows{{JointKind::kRevolute, 0, 0.67183, 0, right, 0},
                          {JointKind::kRevolute, 0, 0, 0.4318, 0, 0},
                          {JointKind::kRevolute, 0, 0.15005, 0.0203, -right, 0},
                          {JointKind::kRevolute, 0, 0.4318, 0, right, 0},
                          {JointKind::kRevolute, 0, 0, 0, -right, 0},
                          {JointKind::kRevolute, 0, 0, 0, 0, 0}};
  rows.resize(joints);
  Eigen::Isometry3d tool = Eigen::Isometry3d::Identity();
  if (joints == 3) tool.translation().z() = 0.4318;
  return ArmModel("puma", DhConvention::kStandard, rows,
                  std::vector<JointLimits>(joints, {-3.0, 3.0, 1.0, 10.0}),
                  Eigen::Isometry3d::Identity(), tool,
                  {{0, {0, 0, 0}, {0, -0.4, 0}, 0.1},
                   {1, {-0.4318, 0, 0.1}, {0, 0, 0.1}, 0.08},
                   {2, {0, 0, 0}, {0, 0, 0.35}, 0.06}});
}

inline Marker MarkerAt(int id, const Eigen::Vector3d& p) {
  Marker marker;
  marker.id = id;
  marker.p = p;
  return marker;
}

inline ViewModel PumaView(int joints) {
  std::vector<Marker> markers{MarkerAt(0, {0.05, 0.05, 0.1}), MarkerAt(1, {-0.05, 0.05, 0.1})};
  if (joints == 6) {
    markers.push_back(MarkerAt(2, {-0.05, -0.05, 0.1}));
    markers.push_back(MarkerAt(3, {0.05, -0.05, 0.1}));
  }
  return {Puma(joints), CameraModel(), FeatureSet::AllPoints(static_cast<int>(markers.size())),
          markers};
}

inline std::vector<BatchRow> PumaRows(int joints) {
  return joints == 3 ? std::vector<BatchRow>{{0, 0}, {0, 1}, {1, 0}} : std::vector<BatchRow>{};
}

/// Joints from 0.3 and up, each a little farther than the one before.
inline ArmMotion PumaMotion(const ViewModel& view, int samples = 32) {
  JointVector from(view.arm.size()), to(view.arm.size());
  for (int j = 0; j < view.arm.size(); ++j) {
    from(j) = -0.2 + 0.2 * j;
    to(j) = from(j) + 0.7 + 0.1 * j;
  }
  return MoveThroughJoints(view, {from, to}, 2.0, samples);
}

inline PlacementProblem PumaProblem(int joints, int samples = 32) {
  const ViewModel view = PumaView(joints);
  PlacementProblem problem;
  problem.rig.kind = RigKind::kSpherical;
  problem.rig.target_W = {0.3, 0.2, 1.0};
  problem.rig.axes = {{"R", 0.6, 3.0, 1.0, 1.0},
                      {"theta", 0.1, 1.5, 1.0, 1.0},
                      {"phi", -kPi, kPi, 1.0, 1.0},
                      {"roll", -kPi, kPi, 1.0, 1.0}};
  problem.q_c_start.resize(4);
  problem.q_c_start << 2.0, 1.0, -1.0, 0.0;
  problem.lens = BatchLens::FromCamera(view.camera, 20.0);
  problem.motion = PumaMotion(view, samples);
  problem.rows = PumaRows(joints);
  problem.limits.depth = {0.3, 5.0};
  problem.limits.max_incidence = 1.4;
  return problem;
}

}  // namespace vantage::test
