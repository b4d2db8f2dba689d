#pragma once

#include <string>

#include "vantage/config/loaders.h"

/// @file
/// A scenario for any arm: markers, start, goal and camera chosen from the arm itself.

namespace vantage {

/// What is known of a task before a scenario for it is written.
struct RobotTask {
  std::string robot;        ///< Built-in robot, or a robot file (YAML or URDF).
  std::string base_link;    ///< Of a URDF file; empty: its root.
  std::string tip_link;     ///< Of a URDF file; empty: the end of its longest chain.
  std::string marker_file;  ///< YAML file with a list `markers`, as in scenarios; empty: chosen.
  int marker_count{0};      ///< Of chosen markers; 0: by the number of joints. In [0, kMaxPoints].
};

/// Writes a scenario: dots before the end effector, where the arm's own body leaves them free; a start
/// and a goal apart by some of the arm's reach, away from singularities, limits, the floor and the arm
/// itself; a camera that sees every dot all the way along. The same task gives the same text.
///
/// @param remarks  What there is to say of the arm; may be null.
/// Throws ConfigError when the arm or the markers cannot be read, or no such task is found.
[[nodiscard]] std::string WriteScenarioFor(const RobotTask& task, RobotRemarks* remarks = nullptr);

}  // namespace vantage
