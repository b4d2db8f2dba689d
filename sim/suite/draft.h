#pragma once

#include <optional>
#include <random>
#include <string>
#include <vector>

#include "sim/suite/suite.h"

/// @file
/// Parts of the scenario generators: a cell for each set of arms, draws, and what a view shows by the nominal model.

namespace vantage::sim {

/// A task under construction: scenario without start, goal and camera start; then with them.
struct Draft {
  Scenario scenario;
  JointVector q_start, q_goal;
  std::vector<ArmSample> motion;           ///< Evenly in the joints from start to goal.
  std::vector<PlacedMarker> goal_markers;  ///< Of the scene.
};

using Random = std::mt19937_64;

/// Uniform in [lower, upper].
[[nodiscard]] double Uniform(Random* random, double lower, double upper);

/// Arm, markers, features, camera on a dome round the cell, and the errors of an ordinary cell.
/// @param housed  The arms with housings that can hide their markers.
[[nodiscard]] Scenario MakeCell(ArmSet arms, bool housed);

/// What sampling the arm's task may depend on.
struct MotionDemand {
  double least{0.35}, most{1.0};  ///< Largest joint step from start to goal [rad].
  bool goal_near_singularity{false};
  bool half_turn{false};  ///< The last joint turns by half a turn, the others by a little.
  JointVector q_start;    ///< Where it starts; empty: anywhere.
};

/// Draws start and goal joints, and puts the goal's markers into the scene. False: this draw is none
/// (arm near a singularity, in the floor or in itself).
[[nodiscard]] bool DrawMotion(ArmSet arms, const MotionDemand& demand, Random* random,
                              Draft* draft);

/// Draws a motion of the goal within the arm's reach, and what the servo is told of its speed. False: this
/// draw is none.
[[nodiscard]] bool DrawGoalMotion(Random* random, Draft* draft);

/// Every one of `markers` is seen from X_WC by the scenario's nominal model, the arm standing as in `arm` and the
/// goal's markers in the scene.
[[nodiscard]] bool AllSeen(const Scenario& scenario, const std::vector<PlacedMarker>& markers,
                           const ArmSample& arm, const std::vector<PlacedMarker>& goal_markers,
                           const Eigen::Isometry3d& X_WC);
/// Every marker of the end effector at motion[sample] is seen from X_WC.
[[nodiscard]] bool SeesArm(const Draft& draft, int sample, const Eigen::Isometry3d& X_WC);
/// Every marker of the goal is, the arm being at motion[sample].
[[nodiscard]] bool SeesGoal(const Draft& draft, int sample, const Eigen::Isometry3d& X_WC);

/// w_c^(1/s) at motion[sample] [px/rad].
[[nodiscard]] double Observability(const Draft& draft, int sample, const Eigen::Isometry3d& X_WC);

/// Rig coordinates drawn evenly inside the limits, the head aimed near the motion.
[[nodiscard]] RigVector DrawCamera(const Draft& draft, Random* random);

/// Some pose of the rig sees every marker of the arm all the way, the goal's at both ends, and
/// certifies the goal (mm/px).
[[nodiscard]] bool Feasible(const Draft& draft, Random* random);

}  // namespace vantage::sim
