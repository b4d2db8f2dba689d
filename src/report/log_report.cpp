#include "vantage/report/log_report.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "camera_video.h"
#include "csv_export.h"
#include "html_page.h"
#include "run_events.h"
#include "run_figures.h"
#include "run_log.h"
#include "vantage/math/error.h"
#include "vantage/math/format.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostRows = 200;  // Of a table of events.

std::string Number(double value, const char* format = "%.4g") {
  if (std::isnan(value)) return "-";
  if (std::isinf(value)) return value > 0 ? "∞" : "-∞";
  return Format(format, value);
}

std::string Seconds(double value) {
  return Number(value, "%.2f");
}

std::string Words(const char* name) {
  std::string words = name;
  for (char& c : words) c = c == '_' ? ' ' : static_cast<char>(std::tolower(c));
  return words;
}

void AddSummary(const RunLog& log, HtmlPage* page) {
  const bool named = log.scenario.has_value();
  page->Section("Summary", named ? log.scenario->description : "");
  std::vector<HtmlPage::Tile> tiles;
  tiles.push_back({"recorded", Seconds(log.At(log.end)) + " s"});
  if (!log.statuses.empty()) {
    const ServoStatus& last = log.statuses.back();
    const auto converged =
        std::find_if(log.statuses.begin(), log.statuses.end(),
                     [](const ServoStatus& s) { return s.state == ServoState::kConverged; });
    const bool reached = converged != log.statuses.end();
    tiles.push_back({reached ? "converged after" : "outcome",
                     reached ? Seconds(log.At(converged->stamp)) + " s" : "not converged",
                     !reached});
    const auto measured =
        std::find_if(log.statuses.rbegin(), log.statuses.rend(),
                     [](const ServoStatus& s) { return s.reason == HoldReason::kNone; });
    if (measured != log.statuses.rend()) {
      tiles.push_back({"last image error", Number(measured->error_px, "%.3g") + " px"});
    }
    // Each run that ends in order ends by the operator.
    const auto unasked =
        last.stops - last.stops_by[static_cast<std::size_t>(HoldReason::kOperator)];
    tiles.push_back({"stops not asked for", std::to_string(unasked), unasked > 0});
    tiles.push_back({"control periods", std::to_string(last.seq)});
    tiles.push_back({"begun late", std::to_string(last.deadline_misses), last.deadline_misses > 0});
    tiles.push_back(
        {"messages refused", std::to_string(last.refused_messages), last.refused_messages > 0});
  }
  if (!log.truths.empty()) {
    tiles.push_back({"last true error (simulator)",
                     Number(1e3 * log.truths.back().worst_error, "%.3g") + " mm"});
    tiles.push_back({"limit violations", std::to_string(log.truths.back().limit_violations),
                     log.truths.back().limit_violations > 0});
  }
  if (!log.observability.empty()) {
    const ObservabilityReport& last = log.observability.back();
    tiles.push_back({"camera moves", std::to_string(last.camera_moves)});
    double lowest = std::numeric_limits<double>::infinity();
    for (const ObservabilityReport& report : log.observability) {
      if (report.k > 0) lowest = std::min(lowest, report.trigger_value);
    }
    tiles.push_back({"lowest trigger value", Number(lowest)});
    tiles.push_back({"threshold", Number(last.threshold)});
    tiles.push_back({"one pixel may hide (last)", Number(last.mm_per_px, "%.3g") + " mm"});
  }
  page->Tiles(tiles);
}

void AddStops(const RunLog& log, HtmlPage* page) {
  const std::vector<StateInterval> states = StatesOf(log);
  const std::vector<StateInterval> stops = StopsOf(states);
  page->Section("Stops and refusals", stops.empty()
                                          ? "The servo did not stop once it had begun to move."
                                          : "When the servo held or was stopped, and why.");
  std::vector<std::vector<std::string>> rows;
  for (const StateInterval& stop : stops) {
    if (rows.size() == kMostRows) break;
    rows.push_back({Seconds(stop.begin), Seconds(stop.duration()), Name(stop.state),
                    Words(Name(stop.reason)), Number(stop.error_px, "%.3g")});
  }
  if (!rows.empty()) page->Table({"t [s]", "for [s]", "state", "reason", "error [px]"}, rows);
  if (stops.size() > kMostRows) {
    page->Table({"and " + std::to_string(stops.size() - kMostRows) + " more"}, {});
  }

  rows.clear();
  if (!log.statuses.empty()) {
    const ServoStatus& last = log.statuses.back();
    rows.push_back({"stops", DescribeStops(last)});
    rows.push_back({"messages the servo refused", DescribeRefused(last)});
    rows.push_back(
        {"messages overwritten by newer ones before use", std::to_string(last.dropped_messages)});
    rows.push_back({"periods that began late", std::to_string(last.deadline_misses)});
    if (!last.calibration.none()) {
      rows.push_back({"calibration found", Describe(last.calibration)});
    }
  }
  for (int i = 1; i < kNumRefusals; ++i) {
    const std::int64_t count = log.refused[static_cast<std::size_t>(i)];
    if (count == 0) continue;
    rows.push_back(
        {std::string("in this log: ") + Name(static_cast<Refusal>(i)), std::to_string(count)});
  }
  if (!rows.empty()) page->Table({"over the whole log", ""}, rows);

  // Where the time went.
  std::vector<std::pair<std::string, double>> times;
  for (const StateInterval& interval : states) {
    const std::string name =
        std::string(Name(interval.state)) +
        (interval.reason == HoldReason::kNone ? "" : ", " + Words(Name(interval.reason)));
    const auto known = std::find_if(times.begin(), times.end(),
                                    [&](const auto& entry) { return entry.first == name; });
    if (known == times.end()) {
      times.emplace_back(name, interval.duration());
    } else {
      known->second += interval.duration();
    }
  }
  rows.clear();
  for (const auto& [name, time] : times) rows.push_back({name, Seconds(time)});
  if (!rows.empty()) page->Table({"state", "in it [s]"}, rows);
}

void AddCameraMoves(const RunLog& log, HtmlPage* page) {
  const std::vector<CameraMove> moves = CameraMovesOf(log);
  if (moves.empty()) return;
  page->Section("Camera moves", "Why the camera moved, and what it gained.");
  std::vector<std::vector<std::string>> rows;
  for (const CameraMove& move : moves) {
    if (rows.size() == kMostRows) break;
    rows.push_back({Seconds(move.begin), Seconds(move.end - move.begin), Words(Name(move.reason)),
                    Words(Name(move.cause)), Number(move.trigger_before),
                    Number(move.trigger_after), Number(move.mm_per_px_before, "%.3g"),
                    Number(move.mm_per_px_after, "%.3g"),
                    move.path ? Number(*move.path, "%.3f") : "-"});
  }
  page->Table({"t [s]", "for [s]", "reason", "cause of a low w_c", "trigger value before", "after",
               "mm/px before", "after", "way [m]"},
              rows);
}

void AddChannels(const RunLog& log, HtmlPage* page) {
  page->Section("Channels", "As the logger saw them.");
  std::vector<std::vector<std::string>> rows;
  for (const auto& [name, traffic] : log.channels) {
    rows.push_back({name, traffic.type, std::to_string(traffic.messages),
                    Number(traffic.rate(), "%.1f"), Number(1e3 * traffic.longest_gap, "%.1f"),
                    Number(static_cast<double>(traffic.bytes) / 1024.0, "%.0f"),
                    std::to_string(traffic.refused)});
  }
  page->Table({"channel", "type", "messages", "per second", "longest gap [ms]", "KiB", "refused"},
              rows);
}

void AddSetup(const RunLog& log, HtmlPage* page) {
  if (log.starts.empty()) return;
  page->Section("Setup", log.starts.size() > 1
                             ? "The log holds " + std::to_string(log.starts.size()) +
                                   " starts of a servo; limits and goal are those of the first."
                             : "");
  std::vector<std::vector<std::string>> rows;
  for (const ServoSetup& setup : log.starts) {
    rows.push_back({Seconds(log.At(setup.start)), setup.scenario_name, setup.program,
                    setup.active_camera ? "active" : "fixed"});
  }
  page->Table({"t [s]", "scenario", "program", "camera"}, rows);
  page->Folded("The scenario", log.starts.front().scenario);
}

std::string Title(const std::string& log_path, const RunLog& log) {
  if (!log.scenario) return fs::path(log_path).filename().string();
  const bool known = !log.starts.empty();
  return log.scenario->name +
         (known ? (log.starts.front().active_camera ? ", camera active" : ", camera fixed") : "");
}

}  // namespace

LogReport WriteLogReport(const std::string& log_path, const std::string& folder,
                         const LogReportOptions& options) {
  const RunLog log = ReadRunLog(log_path, options.prefix, options.scenario);
  const std::string pictures = folder + "/report";
  std::error_code error;
  fs::create_directories(pictures, error);
  if (error) throw ConfigError(folder, "", "cannot be written into: " + error.message());
  LogReport report;
  report.files.emplace_back("report.html");
  if (log.damaged_bytes > 0) {
    report.remarks.push_back(
        "the log was cut off or damaged: " + std::to_string(log.damaged_bytes) +
        " bytes of it belong to no whole message and are left out");
  }
  if (!log.scenario) {
    report.remarks.emplace_back(
        "the log holds no scenario (SERVO_SETUP): no limits and no goal are shown; name one");
  }

  HtmlPage page(Title(log_path, log));
  AddSummary(log, &page);
  const std::string video = folder + "/camera.mp4";
  if (options.video && log.images > 0) {
    if (WriteCameraVideo(log_path, options.prefix, log, video)) {
      page.Section("Camera view");
      page.Mp4(video,
               "Green: markers seen, with their paths of the last two seconds; red: not seen, at "
               "their last place; orange: the goal's. The bar is the trigger's measure, its mark "
               "the threshold.");
      report.files.emplace_back("camera.mp4");
    } else {
      report.remarks.emplace_back(
          "no video: OpenCV cannot write MP4 here (FFmpeg missing from it, or the folder is full)");
    }
  }
  for (const DrawnFigure& figure : DrawFigures(log, pictures)) {
    page.Section(figure.title);
    page.Svg(pictures + "/" + figure.name + ".svg", figure.caption);
    for (const char* ending : {".png", ".svg", ".gp"}) {
      report.files.push_back("report/" + figure.name + ending);
    }
  }
  AddCameraMoves(log, &page);
  AddStops(log, &page);
  AddChannels(log, &page);
  AddSetup(log, &page);
  if (options.csv) {
    for (const std::string& path : ExportCsv(log_path, folder + "/csv")) {
      report.files.push_back(fs::path(path).lexically_relative(folder).string());
    }
  }
  page.Write(folder + "/report.html");
  return report;
}

}  // namespace vantage
