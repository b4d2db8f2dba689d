#pragma once

#include <string>
#include <vector>

/// @file
/// A report on an event log, for people: one HTML file that needs nothing else, and its parts beside it.

namespace vantage {

/// What goes into a report.
struct LogReportOptions {
  std::string prefix;  ///< Of the channels in the log.
  std::string
      scenario;      ///< Name or path, instead of what the log says of itself; empty: the log's.
  bool csv{true};    ///< Tables of every channel.
  bool video{true};  ///< The camera's view, when the log holds images.
};

/// What a report wrote, and could not.
struct LogReport {
  std::vector<std::string> files;    ///< Relative to the folder, the page first.
  std::vector<std::string> remarks;  ///< What could not be done, and why.
};

/// Writes folder/report.html, the pictures in it as folder/report/*.png, *.svg and *.gp (gnuplot), the video
/// as folder/camera.mp4 and the tables as folder/csv/*.csv. The folder is made.
///
/// Throws ConfigError when the log cannot be read, holds nothing of ours, the scenario does not load or the
/// folder cannot be made; WriteError when a file cannot be written, Error when a picture cannot be drawn.
LogReport WriteLogReport(const std::string& log_path, const std::string& folder,
                         const LogReportOptions& options = {});

}  // namespace vantage
