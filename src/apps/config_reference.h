#pragma once

#include <string>
#include <vector>

/// @file
/// The page that lists every key of the configuration files, made from the readers themselves.

namespace vantage {

/// The reference in Markdown: for each kind of file a table of key, type, unit, range, default and meaning.
/// Keys are those that the readers ask for while they read the built-in files and `examples`.
///
/// @param examples  Scenario files that use what no built-in one does.
/// Throws ConfigError when an example is wrong.
[[nodiscard]] std::string ConfigReference(const std::vector<std::string>& examples);

/// Reads one file as the programs would. Throws ConfigError when it is wrong.
/// @param kind  "scenario", "robot", "measure", "recipe" or "problem".
/// @return what there is to say of it: one line each.
[[nodiscard]] std::vector<std::string> CheckConfig(const std::string& kind,
                                                   const std::string& name_or_path);

/// Names of the built-in files of a kind. Throws ConfigError for a kind that there is none of.
[[nodiscard]] std::vector<std::string> ListConfigs(const std::string& kind);

/// Text of a built-in file, or of any file: what a file of one's own begins with. Throws ConfigError when there is
/// none of that name.
[[nodiscard]] std::string ShowConfig(const std::string& kind, const std::string& name_or_path);

/// The kinds that CheckConfig() knows.
[[nodiscard]] const std::vector<std::string>& ConfigKindNames();

}  // namespace vantage
