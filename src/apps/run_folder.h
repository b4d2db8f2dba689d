#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "vantage/report/run_record.h"

namespace vantage {

/// The folder a run leaves behind.
class RunFolder {
 public:
  /// Makes `parent`/<scenario>-<local time>, with a number behind it when there is one already.
  /// Throws ConfigError (--out) when it cannot be made.
  RunFolder(const std::string& parent, const std::string& scenario);

  [[nodiscard]] std::string File(const std::string& name) const { return (path_ / name).string(); }
  [[nodiscard]] const std::filesystem::path& path() const noexcept { return path_; }

  /// samples.csv, summary.json, run.png. A picture that cannot be drawn is a message in the return
  /// value, not an error: the numbers are there.
  std::vector<std::string> Write(const RunSummary& summary,
                                 const std::vector<RunSample>& samples) const;

  /// Where it is and which of a run's results it holds, for people.
  [[nodiscard]] std::string Contents() const;

 private:
  std::filesystem::path path_;
};

}  // namespace vantage
