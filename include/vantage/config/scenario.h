#pragma once

#include <string>
#include <vector>

#include "vantage/active/active_camera.h"
#include "vantage/camera/camera_rig.h"
#include "vantage/config/config_text.h"
#include "vantage/config/loaders.h"
#include "vantage/config/schema.h"
#include "vantage/config/sim_options.h"
#include "vantage/servo/servo.h"
#include "vantage/servo/servo_options.h"
#include "vantage/vision/april_tag.h"
#include "vantage/vision/marker_tracker.h"

namespace vantage {

/// The scenario that runs when none is named.
inline constexpr char kDefaultScenario[] = "puma560-bad-view";

/// One task for one arm and one camera: all that the programs need to know.
struct Scenario {
  std::string name;         ///< Of the file, without folder and ending.
  std::string description;  ///< One line.
  ServoTask task;           ///< Arm, camera, features, markers, goal: what the controller knows.
  CameraRig rig;            ///< What carries the camera.
  RigVector q_c_start;      ///< Rig coordinates at the start.
  ServoOptions servo;       ///< Gains, limits and tolerances of the controller.
  ActiveOptions active;     ///< Of the active camera; enabled is false for one that stands.
  double time_limit{60.0};  ///< Of vantage-run [s].
  SimOptions sim;           ///< For the simulator alone.
  /// Where the markers of the end effector truly have to go [m]; for the simulator alone.
  std::vector<Eigen::Vector3d> p_WG_true;
  RobotRemarks remarks;   ///< Of the arm.
  TrackerOptions vision;  ///< Of whoever has the pixels.
  std::vector<Tag> tags;  ///< On the end effector; empty: the markers are dots.
};

/// The goal's markers where the task believes them to be, in the world: for whoever has the pixels.
[[nodiscard]] std::vector<Marker> BelievedGoalMarkers(const Scenario& scenario);

/// Loads a scenario: a YAML file, or a built-in one by its name.
///
/// @param recorder  Told of each key that is read (for the reference); may be null.
/// Throws ConfigError with file, line, key and bound.
[[nodiscard]] Scenario LoadScenario(const std::string& name_or_path,
                                    SchemaRecorder* recorder = nullptr);

/// The same from text; relative paths in it are relative to text.folder.
[[nodiscard]] Scenario ReadScenario(const ConfigText& text, const std::string& name,
                                    SchemaRecorder* recorder = nullptr);

/// The same from the text of a log's SERVO_SETUP; errors name log:NAME as their file.
[[nodiscard]] Scenario ReadRecordedScenario(const std::string& name, const std::string& text);

/// A scenario's text that can be read anywhere: the robot's description is in it, and paths of URDF files
/// are absolute (those files, and their meshes, stay where they are).
///
/// @param camera_start  As CameraStartText() writes it, in the place of the scenario's own; empty: its own stays.
/// Throws ConfigError as LoadScenario() does.
[[nodiscard]] ConfigText SelfContainedScenario(const std::string& name_or_path,
                                               const std::string& camera_start = "");

}  // namespace vantage
