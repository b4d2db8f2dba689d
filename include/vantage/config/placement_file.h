#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "vantage/active/view.h"
#include "vantage/config/config_text.h"
#include "vantage/config/schema.h"
#include "vantage/plan/camera_path.h"
#include "vantage/plan/placement.h"

namespace vantage {

/// Where the arm's base stands in one item of a sweep, from where the robot's file puts it.
struct BaseShift {
  Eigen::Vector3d shift{Eigen::Vector3d::Zero()};  ///< In the world [m].
  double yaw{0.0};                                 ///< Turn about the world's z axis [rad].
};

/// One of the cells that a sweep compares: another robot, camera, rig, motion or whatever else differs.
struct PlacementCase {
  std::string name;          ///< As tables and pictures of the sweep call it.
  ViewModel view;            ///< Its arm, camera, features and markers.
  PlacementProblem problem;  ///< Its camera to place, the arm where the robot's file puts it.
};

/// Items of a sweep: every case with every place of the arm's base, the base fastest.
struct PlacementSweep {
  std::vector<PlacementCase> cases;  ///< At least one, unless there is no sweep.
  std::vector<BaseShift> bases;      ///< The same.

  [[nodiscard]] int size() const noexcept { return static_cast<int>(cases.size() * bases.size()); }
  /// The cell that item `item` is about. @pre 0 <= item < size().
  [[nodiscard]] const PlacementCase& CaseOf(int item) const { return cases[item / bases.size()]; }
  /// Where the arm of item `item` stands. @pre 0 <= item < size().
  [[nodiscard]] const BaseShift& BaseOf(int item) const { return bases[item % bases.size()]; }
};

/// What vantage-plan works on.
struct PlacementSetup {
  std::string name;              ///< Of the file, without folder and ending.
  std::string description;       ///< One line.
  std::string scenario;          ///< Whose arm, camera and motion these are; empty: the file's own.
  bool pixels{true};             ///< Features in pixels; false: in the units of the focal length.
  ViewModel view;                ///< Arm, camera, features and markers.
  PlacementProblem problem;      ///< The camera to place, and what it is to see.
  PlacementSearch search;        ///< Effort for a camera that stands still.
  bool camera_moves{false};      ///< Eq. 15 too: a path of the camera along with the arm.
  CameraPathSearch path_search;  ///< Effort for the path; where camera_moves is true.
  PlacementSweep sweep;  ///< Empty: none. Of a sweep with cases `problem` is the first case's.
  std::uint64_t fingerprint{
      0};  ///< Of the file's text: tables of one problem know each other by it.
};

/// The problem of item `item`: its case's joints from its base.
/// @pre 0 <= item < sweep.size().
[[nodiscard]] PlacementProblem ProblemAt(const PlacementSweep& sweep, int item);

/// A placement problem: a YAML file, or a built-in one by its name; a scenario (either) stands for the problem of
/// placing its camera for its motion. Throws ConfigError with file, line, key and bound.
[[nodiscard]] PlacementSetup LoadPlacement(const std::string& name_or_path,
                                           SchemaRecorder* recorder = nullptr);

/// The same from text; relative paths in it are relative to text.folder.
[[nodiscard]] PlacementSetup ReadPlacement(const ConfigText& text, const std::string& name,
                                           SchemaRecorder* recorder = nullptr);

}  // namespace vantage
