#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "vantage/config/scenario.h"

/// @file
/// The scenarios S1-S12 of docs/does-it-help.md as seeded generators: random starts, goals and cameras,
/// each task feasible from some pose of its camera's rig. And two long tasks: a goal that moves ("follow"),
/// and ten goals one after the other ("sequence").

namespace vantage::sim {

/// Arms with their markers and features.
enum class ArmSet : int {
  kPlanar2 = 0,  ///< Planar 2-joint arm, one point.
  kPuma3Xyx,     ///< PUMA-type 3-joint arm, the paper's x1, y1, x2.
  kPuma3Points,  ///< The same, two points.
  kPuma560,      ///< Six joints, four points.
};

/// One row of the table.
struct SuiteEntry {
  std::string scenario;  ///< "S1" to "S12", "S8a", "S8b", "follow", "sequence".
  ArmSet arms{ArmSet::kPlanar2};
};

/// "S1/puma560", ...
[[nodiscard]] std::string Name(const SuiteEntry& entry);

/// The rows of a suite: bad-starts, all (S1-S12), quick, follow, sequence, or one scenario ("S4") or row
/// ("S4/planar2").
/// Throws ConfigError (key "suite") for any other name.
[[nodiscard]] std::vector<SuiteEntry> SuiteEntries(const std::string& suite);

/// A goal of a sequence.
struct GoalStage {
  ServoGoal goal;
  std::vector<Marker> goal_markers;        ///< As SimOptions::goal_markers.
  std::vector<Eigen::Vector3d> p_WG_true;  ///< As Scenario::p_WG_true.
  JointVector q_goal;                      ///< As SuiteTask::q_goal.
};

/// One generated task.
struct SuiteTask {
  Scenario scenario;
  JointVector q_goal;  ///< Joints at which every marker is on its goal point; for judging alone.
  std::vector<GoalStage> next;  ///< Goals to go on to from where the one before ended.
};

/// True for tasks that last for the whole time limit: the goal moves.
[[nodiscard]] bool Follows(const Scenario& scenario);

/// The task of (entry, seed): a pure function.
/// Throws Error when no task is found, which no seed of the suites in the tests does.
[[nodiscard]] SuiteTask MakeSuiteTask(const SuiteEntry& entry, std::uint64_t seed);

}  // namespace vantage::sim
