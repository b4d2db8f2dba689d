#pragma once

#include <string>
#include <vector>

namespace vantage {

/// One key of the configuration, as a reader asks for it: a row of the reference page.
struct SchemaEntry {
  std::string path;      ///< Dotted; list elements as "[]": "joints[].alpha_deg".
  std::string type;      ///< "number", "integer", "text", "list of 3 numbers", ...
  std::string unit;      ///< Empty: none.
  std::string range;     ///< "[0, 10]"; empty: none.
  std::string fallback;  ///< Default as written in a file; empty: the key is required.
  std::string help;      ///< One sentence.
};

/// Collects what readers ask for while they read, each path once and in order of first asking. A path
/// that is read in two forms keeps both types.
class SchemaRecorder {
 public:
  /// Notes a key; one that is known already stays, but for a type it has not yet.
  void Add(const SchemaEntry& entry);
  [[nodiscard]] const std::vector<SchemaEntry>& entries() const noexcept { return entries_; }

 private:
  std::vector<SchemaEntry> entries_;
};

}  // namespace vantage
