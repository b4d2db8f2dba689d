#include <filesystem>

#include <yaml-cpp/yaml.h>

#include "vantage/config/scenario.h"
#include "vantage/math/error.h"

namespace vantage {
namespace {

YAML::Node Parse(const ConfigText& text) {
  try {
    return YAML::Load(text.text);
  } catch (const YAML::Exception& error) {
    throw ConfigError(text.source, "", "not valid YAML: " + error.msg);
  }
}

void MakeAbsolute(YAML::Node robot, const char* key, const std::string& folder) {
  if (!robot[key] || !robot[key].IsScalar()) return;
  robot[key] = std::filesystem::absolute(PathBeside(folder, robot[key].Scalar())).string();
}

// The robot's description as a mapping, whatever form the file gives it in.
YAML::Node RobotMapping(const YAML::Node& robot, const std::string& folder) {
  YAML::Node mapping;
  std::string robot_folder = folder;
  if (robot.IsMap()) {
    mapping = robot;
  } else if (IsUrdfPath(robot.Scalar())) {
    mapping["urdf"] = robot.Scalar();
  } else {
    const ConfigText text = FindConfigText(ConfigKind::kRobot, robot.Scalar(), folder);
    mapping = Parse(text);
    robot_folder = text.folder;
  }
  MakeAbsolute(mapping, "urdf", robot_folder);
  MakeAbsolute(mapping, "package_folder", robot_folder);
  return mapping;
}

}  // namespace

ConfigText SelfContainedScenario(const std::string& name_or_path, const std::string& camera_start) {
  const ConfigText text = FindConfigText(ConfigKind::kScenario, name_or_path);
  YAML::Node root = Parse(text);
  if (!root.IsMap() || !root["robot"]) throw ConfigError(text.source, "robot", "is missing");
  root["robot"] = RobotMapping(root["robot"], text.folder);
  if (root["camera"] && root["camera"].IsMap()) {
    MakeAbsolute(root["camera"], "calibration", text.folder);
  }
  if (!camera_start.empty()) root.remove("camera_start");
  return {text.source, "", YAML::Dump(root) + "\n" + camera_start};
}

}  // namespace vantage
