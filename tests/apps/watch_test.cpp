// What vantage-watch shows, as text; and the program itself on a hub.

#include <cmath>

#include <gtest/gtest.h>

#include "../messaging/samples.h"
#include "any_port.h"
#include "contains.h"
#include "program.h"
#include "vantage/messaging/tcp_hub.h"
#include "vantage/runtime/child_process.h"
#include "watch_view.h"

namespace vantage {
namespace {

using test::Contains;

constexpr Time kNow = Time(std::chrono::seconds(100));

template <typename Value>
void Give(WatchCollector* collector, const std::string& channel, const Value& value,
          Time now = kNow) {
  const Bytes bytes = test::Encoded(value);
  collector->OnMessage(channel, bytes.data(), bytes.size(), now);
}

std::string Text(const std::vector<TextLine>& lines) {
  std::string text;
  for (const TextLine& line : lines) {
    for (const TextSpan& span : line) text += span.text;
    text += '\n';
  }
  return text;
}

// A servo that has said everything it can say.
WatchState Full() {
  WatchCollector collector("");
  ServoStatus status = test::SampleServoStatus();
  status.stamp = kNow;
  ObservabilityReport report = test::SampleObservability();
  report.stamp = kNow;
  ServoSetup setup = test::SampleServoSetup();
  setup.scenario = SelfContainedScenario("puma560-bad-view").text;
  Give(&collector, "SERVO_SETUP", setup);
  Give(&collector, "SERVO_STATUS", status);
  Give(&collector, "OBSERVABILITY", report);
  Give(&collector, "JOINT_STATE", test::SampleJointState());
  Give(&collector, "SIM_TRUTH", test::SampleGroundTruth());
  collector.Tick(kNow);
  return collector.Get();
}

const WatchHeader kHeader{"udpm://x", true, false};

TEST(WatchView, ShowsStateReasonMeasuresJointsAndTraffic) {
  const std::string text = Text(RenderWatch(Full(), kHeader, kNow, 120, 100));
  for (const char* part : {"some-scenario",
                           "udpm://x",
                           "HOLDING",
                           "STALE_FEATURES",
                           "markers 3/4",
                           "camera MOVING MARKER_AT_RISK, 4 moves",
                           "low: VIEW",
                           "true error 20.0 mm",
                           "sigma_min",
                           "200.0",
                           "/ 120.0",
                           "7.500",
                           "1.50e+17",
                           "rank 3/3",
                           "condition 4.000",
                           "wrist_roll",
                           "deg/s",
                           "took 6.2 us",
                           "late 1",
                           "stops 2 STALE_JOINT_STATE, 3 TOO_FEW_FEATURES",
                           "calibration found: camera off by 3.1 mm and 0.42 deg",
                           "refused 1 MALFORMED",
                           "OBSERVABILITY",
                           "servo_status_t",
                           "What happened"}) {
    EXPECT_TRUE(Contains(text, part)) << part << "\n" << text;
  }
}

TEST(WatchView, NeverLeavesTheTerminal) {
  const WatchState state = Full();
  for (const int columns : {1, 20, 79, 80, 133, 300}) {
    for (const int rows : {1, 5, 24, 200}) {
      const auto lines = RenderWatch(state, kHeader, kNow, columns, rows);
      EXPECT_LE(static_cast<int>(lines.size()), rows);
      for (const TextLine& line : lines) {
        int cells = 0;
        for (const TextSpan& span : line) cells += CellsOf(span.text);
        EXPECT_LE(cells, columns);
      }
    }
  }
}

TEST(WatchView, SaysWhatIsNotThere) {
  WatchCollector collector("");
  const std::string text =
      Text(RenderWatch(collector.Get(), {"udpm://x", false, true}, kNow, 100, 50));
  EXPECT_TRUE(Contains(text, "no servo heard yet"));
  EXPECT_TRUE(Contains(text, "nothing heard"));
  EXPECT_TRUE(Contains(text, "NOT CONNECTED"));
  EXPECT_TRUE(Contains(text, "PAUSED"));
}

TEST(WatchView, SaysThatAServoIsSilent) {
  const std::string text =
      Text(RenderWatch(Full(), kHeader, kNow + std::chrono::milliseconds(4200), 160, 100));
  EXPECT_TRUE(Contains(text, "SILENT for 4.2 s")) << text;
  EXPECT_TRUE(Contains(text, "silent"));
}

// What comes from outside must not steer the terminal.
TEST(WatchView, ShowsNoControlCharactersFromOutside) {
  WatchCollector collector("");
  ServoSetup setup = test::SampleServoSetup();
  setup.scenario_name = "evil\x1b[2Jname";
  Give(&collector, "SERVO_SETUP", setup);
  Give(&collector, "CHANNEL\x1b]0;x\x07", test::SampleJointState());
  const std::string text = Text(RenderWatch(collector.Get(), kHeader, kNow, 120, 50));
  EXPECT_EQ(text.find('\x1b'), std::string::npos);
  EXPECT_EQ(text.find('\x07'), std::string::npos);
  EXPECT_TRUE(Contains(text, "evil?[2Jname"));
}

TEST(WatchCollector, CountsRatesRefusalsAndHoles) {
  WatchCollector collector("");
  for (int i = 0; i < 20; ++i) {
    Give(&collector, "JOINT_STATE", test::SampleJointState(),
         kNow - std::chrono::milliseconds(50 * i));
  }
  collector.OnMessage("JOINT_STATE", "garbage", 7, kNow);
  Give(&collector, "OTHER", test::SampleServoStatus());
  ServoRecord record = test::SampleServoRecord();
  Give(&collector, "SERVO_INPUTS", record);
  record.periods[0].seq = 50;
  record.periods[1].seq = 51;
  Give(&collector, "SERVO_INPUTS", record);
  collector.Tick(kNow);
  const WatchState state = collector.Get();
  EXPECT_NEAR(state.channels.at("JOINT_STATE").rate, 10.5, 0.01);  // Over two seconds.
  EXPECT_EQ(state.channels.at("JOINT_STATE").refused, 1);
  EXPECT_EQ(state.channels.at("OTHER").messages, 1);
  EXPECT_EQ(state.lost_periods, 7);
  // What was heard a while ago is no rate now.
  collector.Tick(kNow + std::chrono::seconds(10));
  EXPECT_EQ(collector.Get().channels.at("JOINT_STATE").rate, 0.0);
}

TEST(WatchCollector, TakesOnlyItsPrefixForTheServo) {
  WatchCollector collector("LEFT_");
  Give(&collector, "SERVO_STATUS", test::SampleServoStatus());
  EXPECT_FALSE(collector.Get().status.has_value());
  Give(&collector, "LEFT_SERVO_STATUS", test::SampleServoStatus());
  EXPECT_TRUE(collector.Get().status.has_value());
  EXPECT_EQ(collector.Get().channels.size(), 2U);
}

TEST(Sparkline, GoesFromLeastToGreatest) {
  EXPECT_EQ(Sparkline({0.0, 3.5, 7.0}, 3, false), "▁▅█");
  EXPECT_EQ(Sparkline({1.0, 2.0}, 4, false), "  ▁█");
  EXPECT_EQ(Sparkline({1.0, std::nan(""), 2.0}, 3, false), "▁ █");
  EXPECT_EQ(Sparkline({5.0, 5.0, 5.01}, 3, false), "▃▃▃");
  EXPECT_EQ(Sparkline({1.0, 1e7, 1e14}, 3, true), "▁▅█");
  EXPECT_EQ(Sparkline({-1.0, 1.0}, 2, true), " ▃");
  EXPECT_EQ(Sparkline({1.0, 2.0, 3.0}, 2, false), "▁█");
}

// The program, told where to listen, prints one view of what others publish.
TEST(WatchProgram, PrintsOneViewOfAHub) {
  const TcpHub hub(test::AnyPort());
  ChildOptions publisher_options;
  publisher_options.arguments = {VANTAGE_PUBLISH_SAMPLES, "600", hub.url()};
  publisher_options.output = "/dev/null";
  const ChildProcess publisher(publisher_options);
  const auto run =
      test::RunProgram("LCM_DEFAULT_URL='" + hub.url() + "' " VANTAGE_WATCH " --once --wait 1.5");
  EXPECT_EQ(run.exit_code, 0) << run.output;
  EXPECT_TRUE(Contains(run.output, "JOINT_STATE")) << run.output;
  EXPECT_TRUE(Contains(run.output, hub.url())) << run.output;
}

TEST(WatchProgram, SaysThatItHeardNothing) {
  const TcpHub hub(test::AnyPort());
  const auto run =
      test::RunProgram("LCM_DEFAULT_URL='" + hub.url() + "' " VANTAGE_WATCH " --once --wait 0.2");
  EXPECT_EQ(run.exit_code, 1) << run.output;
  EXPECT_TRUE(Contains(run.output, "no servo heard yet")) << run.output;
}

}  // namespace
}  // namespace vantage
