#include "run_folder.h"

#include <ctime>

#include "app.h"
#include "vantage/math/error.h"

namespace vantage {

RunFolder::RunFolder(const std::string& parent, const std::string& scenario) {
  const std::time_t now = std::time(nullptr);
  std::tm local{};
  localtime_r(&now, &local);
  char stamp[32];
  std::strftime(stamp, sizeof stamp, "%Y%m%d-%H%M%S", &local);
  const std::filesystem::path base = std::filesystem::path(parent) / (scenario + "-" + stamp);
  MakeOutputFolder("--out", parent);
  std::error_code error;
  // Two runs may start in the same second: create_directory() says who was first.
  for (int i = 1; i < 1000 && !error; ++i) {
    path_ = i == 1 ? base.string() : base.string() + "-" + std::to_string(i);
    if (std::filesystem::create_directory(path_, error)) return;
  }
  throw ConfigError("", "--out", parent + ": " + error.message());
}

std::vector<std::string> RunFolder::Write(const RunSummary& summary,
                                          const std::vector<RunSample>& samples) const {
  WriteSamples(samples, File("samples.csv"));
  WriteSummary(summary, File("summary.json"));
  try {
    PlotRun(summary, samples, path_.string());
  } catch (const Error& error) {
    return {std::string("no picture: ") + error.what()};
  }
  return {};
}

std::string RunFolder::Contents() const {
  std::string files;
  for (const char* name : {"report.html", "camera.mp4", "events.lcm", "run.png", "first.png",
                           "last.png", "summary.json", "samples.csv", "scenario.yaml"}) {
    if (std::filesystem::exists(File(name)))
      files += (files.empty() ? "" : ", ") + std::string(name);
  }
  return path_.string() + "/: " + files;
}

}  // namespace vantage
