#pragma once

#include <string>
#include <vector>

/// @file
/// Where configuration comes from: files, and the defaults compiled into the library from config/, so
/// that programs run from anywhere.

namespace vantage {

/// The text of one configuration file.
struct ConfigText {
  std::string source;  ///< As errors name it: the path, or "built-in:robots/puma560.yaml".
  std::string folder;  ///< Of the file; empty when built in.
  std::string text;    ///< The whole content, not parsed yet.
};

/// Kinds of files, by the folder of the built-in ones.
enum class ConfigKind {
  kRobot,     ///< config/robots
  kScenario,  ///< config/scenarios
  kMeasure,   ///< config/measure: one configuration to measure
  kRecipe,    ///< config/recipes: maps of measures
  kProblem,   ///< config/problems: cameras to place
};

/// Largest file that is read [bytes].
inline constexpr std::size_t kMaxConfigBytes = 1 << 20;

/// Reads a file. Throws ConfigError when it is missing, a directory, not readable or too large.
[[nodiscard]] ConfigText ReadConfigFile(const std::string& path);

/// Names of the built-in files of a kind ("puma560"), sorted.
[[nodiscard]] std::vector<std::string> BuiltInConfigs(ConfigKind kind);

/// The file at `name_or_path` where there is one (relative paths: first below `folder`, when given,
/// then below the working directory), else the built-in file of that name.
/// Throws ConfigError, naming the built-in ones, when there is neither.
[[nodiscard]] ConfigText FindConfigText(ConfigKind kind, const std::string& name_or_path,
                                        const std::string& folder = "");

/// Folder of the built-in files on disk, for what is not text (meshes): the one that VANTAGE_CONFIG in the
/// environment names, else that of the installation the program belongs to, else the source tree's.
/// Empty when there is none.
[[nodiscard]] std::string BuiltInFolder();

/// `path`, found below `folder` if it is there, else as it is; a name that is nowhere is looked up among
/// the built-in robots' files.
[[nodiscard]] std::string PathBeside(const std::string& folder, const std::string& path);

/// Whether a path names a URDF or xacro file, by its ending.
[[nodiscard]] bool IsUrdfPath(const std::string& path);

}  // namespace vantage
