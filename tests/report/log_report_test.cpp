#include "vantage/report/log_report.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

#include "../../src/report/csv_export.h"
#include "../../src/report/figure.h"
#include "../../src/report/html_page.h"
#include "../../src/report/run_events.h"
#include "../replay/recorded_cell.h"
#include "contains.h"
#include "read_file.h"
#include "temporary_folder.h"
#include "vantage/math/error.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;
using test::Contains;
using test::ReadFile;

Time At(double seconds) {
  return Time(FromSeconds(seconds));
}

// --- What happened -------------------------------------------------------------------------------

ServoStatus Status(double t, ServoState state, HoldReason reason = HoldReason::kNone) {
  ServoStatus status;
  status.stamp = At(t);
  status.state = state;
  status.reason = reason;
  status.error_px = 10.0 - t;
  return status;
}

TEST(RunEvents, StopsAreThoseOfAServoThatHadMoved) {
  RunLog log;
  log.statuses = {Status(0.0, ServoState::kAcquiring, HoldReason::kNoFeatures),
                  Status(0.1, ServoState::kHolding, HoldReason::kTooFewFeatures),
                  Status(0.2, ServoState::kServoing),
                  Status(0.3, ServoState::kServoing),
                  Status(0.4, ServoState::kHolding, HoldReason::kStaleFeatures),
                  Status(0.5, ServoState::kHolding, HoldReason::kStaleFeatures),
                  Status(0.6, ServoState::kHolding, HoldReason::kStaleJointState),
                  Status(0.7, ServoState::kRepositioning),
                  Status(0.9, ServoState::kIdle, HoldReason::kOperator)};
  const auto states = StatesOf(log);
  ASSERT_EQ(states.size(), 7U);
  const auto stops = StopsOf(states);
  ASSERT_EQ(stops.size(), 3U);
  EXPECT_EQ(stops[0].reason, HoldReason::kStaleFeatures);
  EXPECT_DOUBLE_EQ(stops[0].begin, 0.4);
  EXPECT_NEAR(stops[0].duration(), 0.2, 1e-12);
  EXPECT_DOUBLE_EQ(stops[0].error_px, 9.6);
  EXPECT_EQ(stops[1].reason, HoldReason::kStaleJointState);
  EXPECT_EQ(stops[2].state, ServoState::kIdle);
}

TEST(RunEvents, CameraMovesHaveBeginEndAndWay) {
  RunLog log;
  for (int i = 0; i <= 10; ++i) {
    ObservabilityReport report;
    report.stamp = At(0.1 * i);
    report.active_state = i >= 3 && i < 7 ? ActiveState::kMoving : ActiveState::kWatching;
    report.active_reason = ActiveReason::kLowMeasure;
    report.trigger_value = 10.0 * i;
    report.threshold = 35.0;
    report.triggered = i < 4;
    log.observability.push_back(report);
    CameraPose pose{At(0.1 * i), Eigen::Isometry3d::Identity()};
    pose.X_WC.translation().x() = 0.5 * i;
    log.camera_poses.push_back(pose);
  }
  const auto moves = CameraMovesOf(log);
  ASSERT_EQ(moves.size(), 1U);
  EXPECT_NEAR(moves[0].begin, 0.3, 1e-12);
  EXPECT_NEAR(moves[0].end, 0.7, 1e-12);
  EXPECT_DOUBLE_EQ(moves[0].trigger_before, 30.0);
  EXPECT_DOUBLE_EQ(moves[0].trigger_after, 70.0);
  ASSERT_TRUE(moves[0].path.has_value());
  EXPECT_NEAR(*moves[0].path, 2.0, 1e-9);
  const auto triggers = TriggersOf(log);
  ASSERT_EQ(triggers.size(), 1U);
  EXPECT_NEAR(triggers[0].end, 0.4, 1e-12);
  EXPECT_DOUBLE_EQ(triggers[0].lowest, 0.0);
}

// --- Parts ---------------------------------------------------------------------------------------

TEST(Figure, IsDrawnWhereNothingIsFinite) {
  const test::TemporaryFolder folder;
  Figure figure("empty", 300, 200);
  const std::string data = figure.Data({{0.0, std::nan("")}, {1.0, INFINITY}});
  figure << "set xrange [0:1]"
         << "set logscale y"
         << "plot " + data + " using 1:2 with lines";
  figure.Draw(folder.path().string());
  EXPECT_FALSE(cv::imread((folder.path() / "empty.png").string()).empty());
  EXPECT_TRUE(Contains(ReadFile(folder.path() / "empty.svg"), "no finite value"));
}

TEST(Thinned, KeepsPeaksAndGaps) {
  std::vector<FigureRow> rows;
  for (int i = 0; i < 10000; ++i) rows.push_back({double(i), 0.0});
  rows[1234][1] = 5.0;
  rows[7000][1] = -3.0;
  rows[8000] = {};
  const auto thin = Thinned(rows, 100);
  EXPECT_LT(thin.size(), 310U);
  const auto has = [&](const FigureRow& row) {
    return std::find(thin.begin(), thin.end(), row) != thin.end();
  };
  EXPECT_TRUE(has({1234.0, 5.0}));
  EXPECT_TRUE(has({7000.0, -3.0}));
  EXPECT_TRUE(has({}));
  const std::vector<FigureRow> few{{1.0, 2.0}, {3.0, 4.0}};
  EXPECT_EQ(Thinned(few, 100), few);
}

TEST(Html, ShowsTextLetterByLetter) {
  EXPECT_EQ(Escaped("<b> & \"x\""), "&lt;b&gt; &amp; &quot;x&quot;");
  HtmlPage page("<script>");
  page.Section("a < b");
  page.Table({"x"}, {{"<img>"}});
  const test::TemporaryFolder folder;
  page.Write((folder.path() / "page.html").string());
  const std::string html = ReadFile(folder.path() / "page.html");
  EXPECT_FALSE(Contains(html, "<script>"));
  EXPECT_FALSE(Contains(html, "<img>"));
  EXPECT_TRUE(Contains(html, "a &lt; b"));
}

TEST(Html, EncodesVideosInBase64) {
  const test::TemporaryFolder folder;
  HtmlPage page("t");
  page.Section("v");
  page.Mp4(folder.Write("a.mp4", "Ma"), "");
  page.Mp4(folder.Write("b.mp4", "Man!"), "");
  page.Write((folder.path() / "page.html").string());
  const std::string html = ReadFile(folder.path() / "page.html");
  EXPECT_TRUE(Contains(html, "base64,TWE=\""));
  EXPECT_TRUE(Contains(html, "base64,TWFuIQ==\""));
  EXPECT_THROW(page.Mp4((folder.path() / "none").string(), ""), Error);
}

// --- Whole reports -------------------------------------------------------------------------------

LoggedEvent ImageEvent(const CameraImage& image) {
  LoggedEvent event{1'700'000'000'000'000 + ToMicroseconds(image.stamp), kCameraImageChannel, {}};
  Encode(image, &event.data);
  return event;
}

constexpr int kFrames = 8;

// Two seconds of a cell whose camera moves, with grey images among the messages.
std::vector<LoggedEvent> Recorded() {
  std::vector<LoggedEvent> events = test::RecordedCell("planar-grazing-view").Run(1000);
  for (int i = 0; i < kFrames; ++i) {
    CameraImage image;
    image.stamp = FromMicroseconds(5'100'000 + 200'000 * i);
    image.width = image.row_stride = 320;
    image.height = 240;
    image.data.assign(320 * 240, 90);
    events.push_back(ImageEvent(image));
  }
  std::stable_sort(events.begin(), events.end(),
                   [](const auto& a, const auto& b) { return a.utime < b.utime; });
  return events;
}

class LogReportTest : public ::testing::Test {
 protected:
  LogReport Report(const std::vector<LoggedEvent>& events, const LogReportOptions& options = {}) {
    log_ = (folder_.path() / "log").string();
    test::WriteLog(events, log_);
    return WriteLogReport(log_, Out().string(), options);
  }
  [[nodiscard]] fs::path Out() const { return folder_.path() / "out"; }

  test::TemporaryFolder folder_;
  std::string log_;
};

TEST_F(LogReportTest, IsOnePageThatNeedsNothingElse) {
  const LogReport report = Report(Recorded());
  EXPECT_TRUE(report.remarks.empty());
  for (const std::string& file : report.files) EXPECT_TRUE(fs::exists(Out() / file)) << file;
  const std::string html = ReadFile(Out() / "report.html");
  for (const char* section :
       {"Summary", "Camera view", "Error", "Observability", "Paths in the image", "Camera path",
        "Joints", "Timing", "Camera moves", "Stops and refusals", "Channels", "Setup"}) {
    EXPECT_TRUE(Contains(html, std::string("<h2>") + section + "</h2>")) << section;
  }
  EXPECT_TRUE(Contains(html, "planar-grazing-view, camera active"));
  // Nothing is fetched: what looks like an address names an XML dialect, or a place in the page.
  for (const char* key : {"src=\"", "href=\"", "href='", "url("}) {
    for (std::size_t at = html.find(key); at != std::string::npos; at = html.find(key, at + 1)) {
      const std::string target = html.substr(at + std::string(key).size(), 5);
      EXPECT_TRUE(target[0] == '#' || target == "data:") << html.substr(at, 60);
    }
  }
  EXPECT_FALSE(Contains(html, "<script"));
  EXPECT_FALSE(Contains(html, "<link"));
}

TEST_F(LogReportTest, PicturesAreDrawnAsPngAndSvg) {
  LogReportOptions options;
  options.csv = options.video = false;
  (void)Report(Recorded(), options);
  for (const char* name : {"error", "measures", "features", "camera", "joints", "timing"}) {
    const fs::path picture = Out() / "report" / (std::string(name) + ".png");
    const cv::Mat png = cv::imread(picture.string());
    ASSERT_FALSE(png.empty()) << name;
    // Something is drawn on it: it is not one colour.
    double least = 0.0, greatest = 0.0;
    cv::Mat grey;
    cv::cvtColor(png, grey, cv::COLOR_BGR2GRAY);
    cv::minMaxLoc(grey, &least, &greatest);
    EXPECT_LT(least, 120.0) << name;
    const std::string svg = ReadFile(Out() / "report" / (std::string(name) + ".svg"));
    EXPECT_TRUE(Contains(svg, "<svg") && Contains(svg, "</svg>")) << name;
  }
  EXPECT_FALSE(fs::exists(Out() / "csv"));
  EXPECT_FALSE(fs::exists(Out() / "camera.mp4"));
}

TEST_F(LogReportTest, TheVideoHoldsEveryImageWithItsOverlay) {
  LogReportOptions options;
  options.csv = false;
  (void)Report(Recorded(), options);
  cv::VideoCapture video((Out() / "camera.mp4").string());
  ASSERT_TRUE(video.isOpened());
  int frames = 0;
  for (cv::Mat frame; video.read(frame); ++frames) {
    EXPECT_EQ(frame.cols, 320);
    EXPECT_GT(frame.rows, 240);  // The strip of text is above the image.
    std::vector<cv::Mat> channels;
    cv::split(frame, channels);
    // On grey images all colour is the overlay's.
    cv::Mat difference;
    cv::absdiff(channels[0], channels[1], difference);
    EXPECT_GT(cv::countNonZero(difference > 30), 20);
  }
  EXPECT_EQ(frames, kFrames);
}

TEST_F(LogReportTest, CsvHoldsEveryNumberToTheLastBit) {
  const auto events = Recorded();
  (void)Report(events, {"", "", true, false});
  std::ifstream file(Out() / "csv" / "JOINT_COMMAND.csv");
  std::string line;
  std::getline(file, line);
  EXPECT_EQ(line, "log_time,utime,num_joints,velocity[0],velocity[1],position[0],position[1]");
  int lines = 0;
  for (const LoggedEvent& event : events) {
    if (event.channel != kJointCommandChannel) continue;
    ASSERT_TRUE(std::getline(file, line));
    ++lines;
    JointCommand command;
    ASSERT_EQ(Decode(event.data.data(), event.data.size(), &command), Refusal::kNone);
    std::istringstream cells(line);
    std::vector<double> numbers;
    for (std::string cell; std::getline(cells, cell, ',');) numbers.push_back(std::stod(cell));
    ASSERT_EQ(numbers.size(), 7U);
    EXPECT_EQ(numbers[1], static_cast<double>(ToMicroseconds(command.stamp)));
    EXPECT_EQ(numbers[3], command.qdot(0));
    EXPECT_EQ(numbers[6], command.q(1));
  }
  EXPECT_EQ(lines, 1000);
  EXPECT_FALSE(std::getline(file, line));
  // What each period took has a table of its own.
  std::ifstream periods(Out() / "csv" / "SERVO_INPUTS.periods.csv");
  lines = -1;
  while (std::getline(periods, line)) ++lines;
  EXPECT_EQ(lines, 1000);
}

TEST_F(LogReportTest, OfALogWithoutAServoShowsWhatThereIs) {
  std::vector<LoggedEvent> events;
  for (const LoggedEvent& event : test::RecordedCell("planar-good-view").Run(300)) {
    if (event.channel == kJointCommandChannel || event.channel == kObservabilityChannel) {
      events.push_back(event);
    }
  }
  LogReportOptions options;
  options.csv = false;
  const LogReport report = Report(events, options);
  ASSERT_EQ(report.remarks.size(), 1U);
  EXPECT_TRUE(Contains(report.remarks[0], "no scenario"));
  const std::string html = ReadFile(Out() / "report.html");
  EXPECT_TRUE(Contains(html, "Observability"));
  EXPECT_FALSE(Contains(html, "<h2>Joints"));
}

TEST_F(LogReportTest, CountsWhatIsRefused) {
  auto events = Recorded();
  for (LoggedEvent& event : events) {
    if (event.channel != kServoStatusChannel) continue;
    event.data.pop_back();
    break;
  }
  LogReportOptions options;
  options.csv = options.video = false;
  (void)Report(events, options);
  EXPECT_TRUE(Contains(ReadFile(Out() / "report.html"), "in this log: "));
}

TEST_F(LogReportTest, RefusesALogThatHoldsNothingOfOurs) {
  EXPECT_THROW(Report({{1, "OTHER", Bytes(10)}}), Error);
  EXPECT_THROW(WriteLogReport((folder_.path() / "none").string(), Out().string()), Error);
  EXPECT_FALSE(fs::exists(Out()));
}

}  // namespace
}  // namespace vantage
