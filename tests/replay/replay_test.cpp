#include "vantage/replay/replay.h"

#include <algorithm>
#include <functional>

#include <gtest/gtest.h>

#include "recorded_cell.h"
#include "temporary_folder.h"
#include "vantage/math/error.h"

namespace vantage {
namespace {

using Events = std::vector<LoggedEvent>;

constexpr int kPeriods = 1000;

// Recorded once: the camera moves in it (the view is grazing), and the arm.
const Events& Recorded() {
  static const Events events = test::RecordedCell("planar-grazing-view").Run(kPeriods);
  return events;
}

std::vector<ReplayReport> ReplayOf(const Events& events, const ReplayOptions& options = {}) {
  const test::TemporaryFolder folder;
  const std::string path = (folder.path() / "log").string();
  test::WriteLog(events, path);
  return Replay(path, options);
}

ReplayReport OneReplayOf(const Events& events, const ReplayOptions& options = {}) {
  const std::vector<ReplayReport> reports = ReplayOf(events, options);
  EXPECT_EQ(reports.size(), 1U);
  return reports.at(0);
}

const ChannelComparison& Channel(const ReplayReport& report, const std::string& name) {
  const auto found = std::find_if(report.channels.begin(), report.channels.end(),
                                  [&](const auto& channel) { return channel.channel == name; });
  EXPECT_NE(found, report.channels.end()) << name;
  return *found;
}

// Index of the n-th event of a channel.
std::size_t Find(const Events& events, const std::string& channel, int n) {
  for (std::size_t i = 0; i < events.size(); ++i) {
    if (events[i].channel == channel && n-- == 0) return i;
  }
  ADD_FAILURE() << "no such event on " << channel;
  return 0;
}

template <typename Value>
void Change(LoggedEvent* event, const std::function<void(Value*)>& change) {
  Value value;
  ASSERT_EQ(Decode(event->data.data(), event->data.size(), &value), Refusal::kNone);
  change(&value);
  Encode(value, &event->data);
}

TEST(Replay, ReproducesEveryOutputBitForBit) {
  const ReplayReport report = OneReplayOf(Recorded());
  EXPECT_TRUE(report.reproduced()) << report.cut_short;
  EXPECT_EQ(report.periods, kPeriods);
  EXPECT_EQ(report.camera_steps, kPeriods / 10);
  EXPECT_NEAR(report.duration, 2.0, 1e-3);
  EXPECT_EQ(report.scenario_name, "planar-grazing-view");
  EXPECT_EQ(Channel(report, kJointCommandChannel).compared, kPeriods);
  EXPECT_EQ(Channel(report, kCameraPoseCommandChannel).compared, kPeriods / 10);
  EXPECT_EQ(Channel(report, kObservabilityChannel).compared, kPeriods / 10);
  EXPECT_EQ(Channel(report, kServoStatusChannel).compared, kPeriods / 10);
  for (const ChannelComparison& channel : report.channels) {
    EXPECT_EQ(channel.worst, 0.0) << channel.channel;
    EXPECT_EQ(channel.unmatched, 0) << channel.channel;
  }
}

// The log is worth replaying: arm and camera move in it.
TEST(Replay, OfSomethingThatHappens) {
  ObservabilityReport last;
  JointCommand command;
  double fastest = 0.0;
  for (const LoggedEvent& event : Recorded()) {
    if (event.channel == kObservabilityChannel) {
      ASSERT_EQ(Decode(event.data.data(), event.data.size(), &last), Refusal::kNone);
    } else if (event.channel == kJointCommandChannel) {
      ASSERT_EQ(Decode(event.data.data(), event.data.size(), &command), Refusal::kNone);
      fastest = std::max(fastest, command.qdot.cwiseAbs().maxCoeff());
    }
  }
  EXPECT_GT(last.camera_moves, 0);
  EXPECT_GT(fastest, 0.1);
}

TEST(Replay, NamesTheFirstDifferenceByTimeChannelAndField) {
  Events events = Recorded();
  // Two differences: the later one comes first in no other way than by its place in the list of channels.
  Change<JointCommand>(&events[Find(events, kJointCommandChannel, 700)],
                       [](JointCommand* c) { c->qdot(1) += 1e-6; });
  Change<ObservabilityReport>(&events[Find(events, kObservabilityChannel, 50)],
                              [](ObservabilityReport* o) { o->w_v *= 1.0 + 1e-8; });
  const ReplayReport report = OneReplayOf(events);
  EXPECT_FALSE(report.reproduced());
  ASSERT_TRUE(report.first_difference.has_value());
  EXPECT_EQ(report.first_difference->channel, kObservabilityChannel);
  EXPECT_EQ(report.first_difference->field, "w_v");
  EXPECT_NEAR(report.first_difference->t, 1.02, 1e-3);
  EXPECT_EQ(Channel(report, kJointCommandChannel).different, 1);
  EXPECT_NEAR(Channel(report, kJointCommandChannel).worst, 1e-6, 1e-9);
}

TEST(Replay, ToleranceIsRelativeAboveOne) {
  Events events = Recorded();
  Change<ObservabilityReport>(&events[Find(events, kObservabilityChannel, 50)],
                              [](ObservabilityReport* o) { o->w_v *= 1.0 + 1e-10; });
  EXPECT_TRUE(OneReplayOf(events).reproduced());
  EXPECT_FALSE(OneReplayOf(events, {"", 1e-11}).reproduced());
}

// An input changed by one part in a million shows up in what comes out.
TEST(Replay, NoticesAnInputThatWasNotTheOne) {
  Events events = Recorded();
  Change<ServoRecord>(&events[Find(events, kServoInputsChannel, 20)], [](ServoRecord* record) {
    for (PeriodRecord& period : record->periods) {
      if (period.inputs.has_features) period.inputs.features.markers[0].pixel.x() += 1e-3;
    }
  });
  const ReplayReport report = OneReplayOf(events);
  ASSERT_TRUE(report.first_difference.has_value());
  EXPECT_EQ(report.first_difference->channel, kJointCommandChannel);
  EXPECT_GE(report.first_difference->t, 0.4);
  EXPECT_LT(report.first_difference->t, 0.43);
}

TEST(Replay, SaysWhereTheRecordHasAHole) {
  Events events = Recorded();
  events.erase(events.begin() + static_cast<std::ptrdiff_t>(Find(events, kServoInputsChannel, 30)));
  const ReplayReport report = OneReplayOf(events);
  EXPECT_FALSE(report.reproduced());
  EXPECT_EQ(report.periods, 300);
  EXPECT_EQ(report.cut_short, "periods 301 to 310 are missing in the log");
  EXPECT_FALSE(report.first_difference.has_value());
}

TEST(Replay, SaysThatTheLoggerWasStartedTooLate) {
  Events events = Recorded();
  events.erase(events.begin() + static_cast<std::ptrdiff_t>(Find(events, kServoInputsChannel, 0)));
  const ReplayReport report = OneReplayOf(events);
  EXPECT_EQ(report.periods, 0);
  EXPECT_NE(report.cut_short.find("begins at period 11"), std::string::npos) << report.cut_short;
}

TEST(Replay, SaysThatACameraStepIsMissing) {
  Events events = Recorded();
  Change<ServoRecord>(&events[Find(events, kServoInputsChannel, 10)],
                      [](ServoRecord* record) { record->camera_steps.clear(); });
  const ReplayReport report = OneReplayOf(events);
  EXPECT_NE(report.cut_short.find("step 11 of the active camera"), std::string::npos)
      << report.cut_short;
}

// Outputs that no period gave are not passed over in silence.
TEST(Replay, CountsMessagesThatBelongToNoPeriod) {
  Events events = Recorded();
  Change<JointCommand>(&events[Find(events, kJointCommandChannel, 100)],
                       [](JointCommand* c) { c->stamp += std::chrono::microseconds(300); });
  EXPECT_EQ(Channel(OneReplayOf(events), kJointCommandChannel).unmatched, 1);
}

TEST(Replay, ReplaysEachStartOfARestartedServo) {
  Events events = Recorded();
  const Events second =
      test::RecordedCell("planar-good-view", FromMicroseconds(60'000'000)).Run(200);
  events.insert(events.end(), second.begin(), second.end());
  const std::vector<ReplayReport> reports = ReplayOf(events);
  ASSERT_EQ(reports.size(), 2U);
  EXPECT_TRUE(reports[0].reproduced());
  EXPECT_TRUE(reports[1].reproduced());
  EXPECT_EQ(reports[1].scenario_name, "planar-good-view");
  EXPECT_EQ(reports[1].periods, 200);
}

TEST(Replay, KnowsPrefixes) {
  Events events = Recorded();
  for (LoggedEvent& event : events) event.channel = "LEFT_" + event.channel;
  EXPECT_TRUE(OneReplayOf(events, {"LEFT_", 1e-9}).reproduced());
  EXPECT_THROW((void)ReplayOf(events), Error);
}

TEST(Replay, RefusesWhatIsNoLogOfAServo) {
  const test::TemporaryFolder folder;
  EXPECT_THROW((void)Replay((folder.path() / "none").string()), Error);
  EXPECT_THROW((void)Replay(folder.Write("text", "no log at all")), Error);
  EXPECT_THROW((void)Replay(folder.Write("empty", "")), Error);
  EXPECT_THROW((void)Replay(folder.path().string()), Error);
}

}  // namespace
}  // namespace vantage
