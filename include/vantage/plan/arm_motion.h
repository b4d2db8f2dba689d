#pragma once

#include <vector>

#include <Eigen/Geometry>

#include "vantage/active/view.h"

/// @file
/// The arm's motion that a camera is placed for, as a list of samples with integration weights.

namespace vantage {

/// A motion, sampled. Every list has one entry a sample.
struct ArmMotion {
  std::vector<ArmSample> samples;  ///< The arm at each instant.
  std::vector<double> time;        ///< [s], ascending from 0.
  std::vector<double> weight;      ///< Of the trapezoid rule over time [s].

  [[nodiscard]] int size() const noexcept { return static_cast<int>(samples.size()); }
};

/// Straight lines in joint space through the waypoints, each line taking its share of the greatest joint
/// travel.
///
/// @param duration  [s]; > 0.
/// @param count     Samples; >= 2, or 1 for a single waypoint.
/// Throws ConfigError (key "motion...") when sizes do not agree or a waypoint is outside the limits.
[[nodiscard]] ArmMotion MoveThroughJoints(const ViewModel& view,
                                          const std::vector<JointVector>& waypoints,
                                          double duration, int count);

/// What a motion in space asks of the end effector.
enum class PathFrame {
  kPosition,  ///< E's origin alone.
  kPose,      ///< Position and orientation.
};

/// Straight lines in space through poses of the end effector, orientations turning at a steady rate, each
/// line taking its share of the length travelled (of the angle, where nothing travels).
///
/// @param q_near  Joints near those of the first pose: the arm stays on that branch.
/// Throws ConfigError (key "motion...") where the arm does not reach a sample to 1e-6 m; the message says
/// which and by how much.
[[nodiscard]] ArmMotion MoveThroughPoses(const ViewModel& view,
                                         const std::vector<Eigen::Isometry3d>& poses,
                                         PathFrame frame, const JointVector& q_near,
                                         double duration, int count);

}  // namespace vantage
