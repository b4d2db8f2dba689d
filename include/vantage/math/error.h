#pragma once

#include <stdexcept>
#include <string>

/// @file
/// Errors of the set-up phase. Nothing that runs inside the control period throws; it reports a
/// status instead (see vantage/control/servo_law.h).

namespace vantage {

/// Base of every exception this library throws on purpose.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A configuration value is missing, of the wrong type or out of range, or a file is not readable.
class ConfigError : public Error {
 public:
  /// @param where   File and line, e.g. "scenarios/planar.yaml:12"; empty when not from a file.
  /// @param key     Dotted path of the value, e.g. "camera.focal_px"; empty when the file itself is
  ///   at fault.
  /// @param reason  What is required, with the unit and the value found.
  ConfigError(const std::string& where, const std::string& key, const std::string& reason)
      : Error((where.empty() ? "" : where + ": ") + (key.empty() ? "" : key + ": ") + reason),
        key_(key) {}

  [[nodiscard]] const std::string& key() const { return key_; }

 private:
  std::string key_;
};

/// A file cannot be written, or not to its end.
class WriteError : public Error {
 public:
  /// @param path  Of the file.
  explicit WriteError(const std::string& path)
      : Error("cannot write " + path + ": no permission, no such folder, or the disk is full") {}
};

}  // namespace vantage
