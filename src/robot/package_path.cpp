#include "package_path.h"

#include <cstdlib>
#include <filesystem>
#include <system_error>

#include <tinyxml2.h>

#include "vantage/robot/urdf.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

bool IsFile(const fs::path& path) {
  std::error_code error;
  return fs::is_regular_file(path, error);
}

// The name in a package's own manifest; folders are often called otherwise.
bool IsPackage(const fs::path& folder, const std::string& name) {
  if (folder.filename() == name) return true;
  const fs::path manifest = folder / "package.xml";
  if (!IsFile(manifest)) return false;
  tinyxml2::XMLDocument xml;
  if (xml.LoadFile(manifest.c_str()) != tinyxml2::XML_SUCCESS) return false;
  const tinyxml2::XMLElement* root = xml.RootElement();
  const tinyxml2::XMLElement* found = root == nullptr ? nullptr : root->FirstChildElement("name");
  return found != nullptr && found->GetText() != nullptr && found->GetText() == name;
}

// `rest` below the package `name`, when `folder` is the package or holds it.
fs::path BelowPackage(const fs::path& folder, const std::string& name, const fs::path& rest) {
  if (IsFile(folder / name / rest)) return folder / name / rest;
  if (IsFile(folder / rest) && IsPackage(folder, name)) return folder / rest;
  return {};
}

// The folder of a file and those above it.
std::vector<fs::path> FoldersAbove(const fs::path& file) {
  std::vector<fs::path> folders;
  std::error_code error;
  fs::path folder = fs::absolute(file, error).lexically_normal().parent_path();
  while (!error) {
    folders.push_back(folder);
    if (folder == folder.parent_path()) break;
    folder = folder.parent_path();
  }
  return folders;
}

fs::path FindInPackage(const std::string& name, const fs::path& rest, const fs::path& urdf,
                       const std::vector<std::string>& package_folders) {
  std::vector<fs::path> folders;
  for (const std::string& folder : package_folders) {
    folders.push_back(fs::path(folder).lexically_normal());
  }
  const std::vector<fs::path> above = FoldersAbove(urdf);
  folders.insert(folders.end(), above.begin(), above.end());
  for (const fs::path& folder : folders) {
    const fs::path found = BelowPackage(folder, name, rest);
    if (!found.empty()) return found;
  }
  // A robot copied out of its package: the same file below another folder.
  for (const fs::path& folder : folders) {
    if (IsFile(folder / rest)) return folder / rest;
  }
  return {};
}

std::vector<std::string> SplitPath(const char* text) {
  std::vector<std::string> parts;
  std::string rest = text == nullptr ? "" : text;
  while (!rest.empty()) {
    const std::size_t colon = rest.find(':');
    if (colon != 0) parts.push_back(rest.substr(0, colon));
    rest.erase(0, colon == std::string::npos ? colon : colon + 1);
  }
  return parts;
}

}  // namespace

MeshLocation FindMesh(const std::string& file_name, const std::string& urdf_path,
                      const std::vector<std::string>& package_folders) {
  for (const std::string scheme : {"package://", "model://"}) {
    if (file_name.compare(0, scheme.size(), scheme) != 0) continue;
    const std::string below = file_name.substr(scheme.size());
    const std::size_t slash = below.find('/');
    const std::string name = below.substr(0, slash);
    const std::string rest = slash == std::string::npos ? "" : below.substr(slash + 1);
    if (name.empty() || rest.empty()) return {"", "mesh '" + file_name + "' names no file", ""};
    const fs::path found = FindInPackage(name, rest, urdf_path, package_folders);
    if (!found.empty()) return {found.string(), "", ""};
    return {"",
            "mesh '" + file_name + "' not found among the package folders or above the URDF file",
            name};
  }
  fs::path path = file_name;
  const std::string file_scheme = "file://";
  if (file_name.compare(0, file_scheme.size(), file_scheme) == 0) {
    path = file_name.substr(file_scheme.size());
  } else if (file_name.find("://") != std::string::npos) {
    return {"", "mesh '" + file_name + "': only package://, model:// and file:// are known", ""};
  }
  if (path.is_relative()) path = (fs::path(urdf_path).parent_path() / path).lexically_normal();
  if (!IsFile(path)) {
    return {"", "mesh '" + file_name + "' not found: no file " + path.string(), ""};
  }
  return {path.string(), "", ""};
}

std::vector<std::string> RosPackageFolders() {
  std::vector<std::string> folders = SplitPath(std::getenv("ROS_PACKAGE_PATH"));
  for (const std::string& prefix : SplitPath(std::getenv("AMENT_PREFIX_PATH"))) {
    folders.push_back(prefix + "/share");
  }
  return folders;
}

}  // namespace vantage
