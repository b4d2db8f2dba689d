#include "vantage/config/config_text.h"

#include <cctype>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>
#include <system_error>

#include "embedded.h"
#include "vantage/math/error.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

const char* FolderOf(ConfigKind kind) {
  switch (kind) {
    case ConfigKind::kRobot:
      return "robots";
    case ConfigKind::kScenario:
      return "scenarios";
    case ConfigKind::kMeasure:
      return "measure";
    case ConfigKind::kRecipe:
      return "recipes";
    case ConfigKind::kProblem:
      return "problems";
  }
  return "";
}

const char* NounOf(ConfigKind kind) {
  switch (kind) {
    case ConfigKind::kRobot:
      return "robot";
    case ConfigKind::kScenario:
      return "scenario";
    case ConfigKind::kMeasure:
      return "measurement";
    case ConfigKind::kRecipe:
      return "recipe";
    case ConfigKind::kProblem:
      return "problem";
  }
  return "";
}

bool IsFile(const fs::path& path) {
  std::error_code error;
  return fs::exists(path, error) && !fs::is_directory(path, error);
}

// A name is looked up among the built-in files; whatever looks like a path is meant to be one.
bool LooksLikePath(const std::string& text) {
  return text.find('/') != std::string::npos || fs::path(text).extension() == ".yaml" ||
         fs::path(text).extension() == ".yml";
}

}  // namespace

ConfigText ReadConfigFile(const std::string& path) {
  std::error_code error;
  if (fs::is_directory(path, error)) throw ConfigError(path, "", "is a directory");
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"),
                                                             &std::fclose);
  if (file == nullptr) {
    throw ConfigError(path, "", std::string("cannot be opened: ") + std::strerror(errno));
  }
  std::string text(kMaxConfigBytes + 1, '\0');
  errno = 0;
  text.resize(std::fread(text.data(), 1, text.size(), file.get()));
  if (std::ferror(file.get()) != 0) {
    throw ConfigError(path, "", std::string("cannot be read: ") + std::strerror(errno));
  }
  if (text.size() > kMaxConfigBytes) {
    throw ConfigError(path, "", "is larger than " + std::to_string(kMaxConfigBytes) + " bytes");
  }
  return {path, fs::path(path).parent_path().string(), text};
}

std::vector<std::string> BuiltInConfigs(ConfigKind kind) {
  std::vector<std::string> names;
  for (const EmbeddedConfig& config : EmbeddedConfigs()) {
    if (std::strcmp(config.folder, FolderOf(kind)) == 0) names.emplace_back(config.name);
  }
  return names;
}

ConfigText FindConfigText(ConfigKind kind, const std::string& name_or_path,
                          const std::string& folder) {
  if (!folder.empty() && fs::path(name_or_path).is_relative()) {
    const fs::path beside = fs::path(folder) / name_or_path;
    if (IsFile(beside)) return ReadConfigFile(beside.string());
  }
  if (IsFile(name_or_path)) return ReadConfigFile(name_or_path);
  for (const EmbeddedConfig& config : EmbeddedConfigs()) {
    if (std::strcmp(config.folder, FolderOf(kind)) == 0 && name_or_path == config.name) {
      return {std::string("built-in:") + config.folder + "/" + config.name + ".yaml", "",
              config.text};
    }
  }
  std::error_code error;
  if (LooksLikePath(name_or_path) || fs::is_directory(name_or_path, error)) {
    return ReadConfigFile(name_or_path);  // Throws, with the system's reason.
  }
  std::string known;
  for (const std::string& name : BuiltInConfigs(kind)) known += (known.empty() ? "" : ", ") + name;
  throw ConfigError(
      "", NounOf(kind),
      "'" + name_or_path + "' is neither a file nor built in (built in: " + known + ")");
}

std::string PathBeside(const std::string& folder, const std::string& path) {
  const fs::path beside = fs::path(folder) / path;
  std::error_code error;
  return !folder.empty() && fs::exists(beside, error) ? beside.string() : path;
}

bool IsUrdfPath(const std::string& path) {
  std::string extension = fs::path(path).extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension == ".urdf" || extension == ".xacro";
}

}  // namespace vantage
