#pragma once

#include <map>
#include <string>
#include <vector>

#include <urdf_model/model.h>

/// @file
/// Private to the module: a parsed URDF file that knows where its elements stand.

namespace vantage {

class UrdfDocument {
 public:
  /// Throws ConfigError when the file is missing, too large, no valid XML or no valid URDF, or its links
  /// are no tree.
  explicit UrdfDocument(const std::string& path);

  [[nodiscard]] const std::string& path() const noexcept { return path_; }
  [[nodiscard]] const urdf::ModelInterface& model() const noexcept { return *model_; }
  /// What urdfdom complained of without giving up.
  [[nodiscard]] const std::vector<std::string>& complaints() const noexcept { return complaints_; }

  /// "file:line: link 'name'", as warnings begin.
  [[nodiscard]] std::string Link(const std::string& name) const;
  [[nodiscard]] std::string Joint(const std::string& name) const;

  /// Throws ConfigError about an element.
  [[noreturn]] void FailLink(const std::string& name, const std::string& reason) const;
  [[noreturn]] void FailJoint(const std::string& name, const std::string& reason) const;
  /// Throws ConfigError about the file.
  [[noreturn]] void Fail(const std::string& reason) const;

 private:
  using Lines = std::map<std::string, int>;
  void Locate(const std::string& text);
  void Parse(const std::string& text);
  void RequireTree() const;
  [[nodiscard]] int LineOfElementIn(const std::vector<std::string>& messages) const;
  [[nodiscard]] std::string Where(const Lines& lines, const std::string& name) const;

  std::string path_;
  std::shared_ptr<urdf::ModelInterface> model_;
  std::vector<std::string> complaints_;
  Lines link_lines_, joint_lines_;
};

}  // namespace vantage
