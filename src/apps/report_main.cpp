// vantage-report LOG: a report on an event log, for people.

#include <filesystem>
#include <iostream>

#include "app.h"
#include "vantage/report/log_report.h"

namespace vantage {
namespace {

struct Arguments {
  std::string log;
  std::string out;
  LogReportOptions options;
  bool no_csv = false;
  bool no_video = false;
};

int Run(const Arguments& arguments) {
  LogReportOptions options = arguments.options;
  options.csv = !arguments.no_csv;
  options.video = !arguments.no_video;
  std::string folder = arguments.out;
  if (folder.empty()) folder = std::filesystem::path(arguments.log).parent_path().string();
  if (folder.empty()) folder = ".";
  const LogReport report = WriteLogReport(arguments.log, folder, options);
  for (const std::string& remark : report.remarks)
    std::cerr << "vantage-report: " << remark << '\n';
  for (const std::string& file : report.files) std::cout << folder << '/' << file << '\n';
  return kExitOk;
}

}  // namespace
}  // namespace vantage

int main(int argc, char** argv) {
  vantage::Arguments arguments;
  CLI::App app(
      "Report on an LCM event log: one HTML page that needs nothing else, its pictures as PNG and "
      "SVG, the camera's view as a video, every channel as CSV",
      "vantage-report");
  app.add_option("log", arguments.log, "Event log, of vantage-run or lcm-logger")->required();
  app.add_option("--out", arguments.out, "Folder for the report; default: the log's");
  app.add_option("--prefix", arguments.options.prefix, "Before every channel name");
  app.add_option("--scenario", arguments.options.scenario,
                 "Built-in scenario or a YAML file, for limits and goal, instead of the log's own");
  app.add_flag("--no-csv", arguments.no_csv, "No tables");
  app.add_flag("--no-video", arguments.no_video, "No video");
  return vantage::RunApp(&app, argc, argv, "", [&] { return vantage::Run(arguments); });
}
