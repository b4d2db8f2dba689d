#pragma once

#include <vector>

namespace vantage {

/// One file of config/, compiled in.
struct EmbeddedConfig {
  const char* folder;  ///< "robots"
  const char* name;    ///< "puma560"
  const char* text;
};

/// Sorted by folder, then by name.
[[nodiscard]] const std::vector<EmbeddedConfig>& EmbeddedConfigs();

}  // namespace vantage
