#include "vantage/messaging/event_log.h"

#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "any_port.h"
#include "samples.h"
#include "temporary_folder.h"
#include "vantage/math/error.h"
#include "vantage/messaging/event_recorder.h"
#include "vantage/messaging/lcm_link.h"
#include "vantage/messaging/tcp_hub.h"

namespace vantage {
namespace {

std::vector<LoggedEvent> ReadAll(const std::string& path) {
  std::vector<LoggedEvent> events;
  EventLogReader log(path);
  for (LoggedEvent event; log.Next(&event);) events.push_back(event);
  return events;
}

TEST(EventLog, GivesBackWhatWasWritten) {
  const test::TemporaryFolder folder;
  const std::string path = folder.path() / "log";
  {
    EventLogWriter log(path);
    log.Write({1'700'000'000'000'001, "A", test::Encoded(test::SampleJointState())});
    log.Write({1'700'000'000'000'002, "B", {}});
  }
  const auto events = ReadAll(path);
  ASSERT_EQ(events.size(), 2U);
  EXPECT_EQ(events[0].utime, 1'700'000'000'000'001);
  EXPECT_EQ(events[0].channel, "A");
  EXPECT_EQ(events[0].data, test::Encoded(test::SampleJointState()));
  EXPECT_EQ(events[1].channel, "B");
  EXPECT_TRUE(events[1].data.empty());
}

// The power went while it was written: what came before is there.
TEST(EventLog, EndsWhereItWasCutOff) {
  const test::TemporaryFolder folder;
  const std::string path = folder.path() / "log";
  {
    EventLogWriter log(path);
    for (int i = 0; i < 3; ++i) log.Write({i, "A", Bytes(100)});
  }
  {
    EventLogReader whole(path);
    for (LoggedEvent event; whole.Next(&event);) {
    }
    EXPECT_EQ(whole.damaged_bytes(), 0);
  }
  std::filesystem::resize_file(path, std::filesystem::file_size(path) - 50);
  EXPECT_EQ(ReadAll(path).size(), 2U);
  EventLogReader cut(path);
  for (LoggedEvent event; cut.Next(&event);) {
  }
  EXPECT_EQ(cut.damaged_bytes(), 28 + 1 + 100 - 50);
}

TEST(EventLog, SaysWhatCannotBeReadOrWritten) {
  const test::TemporaryFolder folder;
  EXPECT_THROW(EventLogReader((folder.path() / "none").string()), ConfigError);
  EXPECT_THROW(EventLogReader(folder.path().string()), ConfigError);
  EXPECT_THROW(EventLogReader(folder.Write("text", "hello, this is text")), ConfigError);
  EXPECT_THROW(EventLogWriter((folder.path() / "none" / "log").string()), WriteError);
}

TEST(EventRecorder, MissesNothingFromItsConstructionOn) {
  const test::TemporaryFolder folder;
  const std::string path = folder.path() / "log";
  const TcpHub hub(test::AnyPort());
  LcmLink link({hub.url(), ""});
  link.Start();
  constexpr int kMessages = 500;
  {
    const EventRecorder recorder(hub.url(), path);
    JointState state = test::SampleJointState();
    for (int i = 0; i < kMessages; ++i) {
      state.q(0) = i;
      ASSERT_TRUE(link.Publish("ANY_PREFIX_" + std::to_string(i % 3), state));
    }
    EXPECT_EQ(recorder.lost(), 0);
  }
  const auto events = ReadAll(path);
  ASSERT_EQ(events.size(), static_cast<std::size_t>(kMessages));
  for (int i = 0; i < kMessages; ++i) {
    JointState state;
    ASSERT_EQ(Decode(events[i].data.data(), events[i].data.size(), &state), Refusal::kNone);
    EXPECT_EQ(state.q(0), i);
  }
}

}  // namespace
}  // namespace vantage
