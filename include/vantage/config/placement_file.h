#pragma once

#include <string>

#include "vantage/active/view.h"
#include "vantage/config/config_text.h"
#include "vantage/config/schema.h"
#include "vantage/plan/camera_path.h"
#include "vantage/plan/placement.h"

namespace vantage {

/// What vantage-plan works on.
struct PlacementSetup {
  std::string name;         ///< Of the file, without folder and ending.
  std::string description;  ///< One line.
  std::string scenario;     ///< Whose arm, camera and motion these are; empty: the file's own.
  bool pixels{true};        ///< Features in pixels; false: in the units of the focal length.
  ViewModel view;
  PlacementProblem problem;
  PlacementSearch search;
  bool camera_moves{false};  ///< Eq. 15 too: a path of the camera along with the arm.
  CameraPathSearch path_search;
};

/// A placement problem: a YAML file, or a built-in one by its name; a scenario stands for the problem of
/// placing its camera for its motion. Throws ConfigError with file, line, key and bound.
[[nodiscard]] PlacementSetup LoadPlacement(const std::string& name_or_path,
                                           SchemaRecorder* recorder = nullptr);

/// The same from text; relative paths in it are relative to text.folder.
[[nodiscard]] PlacementSetup ReadPlacement(const ConfigText& text, const std::string& name,
                                           SchemaRecorder* recorder = nullptr);

}  // namespace vantage
