#pragma once

#include <string>

#include "vantage/report/run_record.h"

namespace vantage {

/// Live progress of a run on a terminal: a table whose last line is kept up to date, and a new line
/// twice a second; plain lines once a second where the output is no terminal.
class RunConsole {
 public:
  explicit RunConsole(bool quiet);

  /// The column titles come with the first sample.
  void Show(const RunSample& sample, const ObservabilityReport& observability,
            const ServoStatus& status);
  /// A line of its own, above the table or among its lines.
  void Note(const std::string& text);
  /// How it ended.
  void End(const RunSummary& summary, const std::string& folder);

 private:
  void Line(const std::string& text, bool keep);
  void Titles(TriggerMeasure measure);

  bool quiet_;
  bool terminal_;
  bool open_line_{false};
  bool titled_{false};
  double next_line_{0.0};
};

}  // namespace vantage
