// The messages are LCM's: Python's bindings read and write them byte for byte, and the stock lcm-logger
// and lcm-logplayer record and replay them through the hub.

#include <csignal>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

#include <gtest/gtest.h>
#include <lcm/lcm-cpp.hpp>

#include "any_port.h"
#include "raw_client.h"
#include "samples.h"
#include "temporary_folder.h"
#include "vantage/math/error.h"
#include "vantage/messaging/lcm_link.h"
#include "vantage/messaging/tcp_hub.h"
#include "vantage/runtime/child_process.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;
using test::BecomesTrue;

Bytes ReadFile(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return Bytes(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
}

void WriteFile(const fs::path& path, const Bytes& bytes) {
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
}

std::string RunToEnd(const std::vector<std::string>& arguments,
                     const test::TemporaryFolder& folder) {
  ChildOptions options;
  options.arguments = arguments;
  options.output = folder.path() / "output";
  try {
    const auto status = ChildProcess(options).WaitFor(test::kPatience);
    const Bytes output = ReadFile(options.output);
    const std::string text(output.begin(), output.end());
    if (!status) return "does not end: " + text;
    return status->success() ? "" : status->ToString() + ": " + text;
  } catch (const Error& error) {
    return error.what();
  }
}

TEST(Python, ReadsAndWritesTheSameBytes) {
  const std::map<std::string, Bytes> samples{
      {"vantage_msgs.joint_state_t", test::Encoded(test::SampleJointState())},
      {"vantage_msgs.joint_command_t", test::Encoded(test::SampleJointCommand())},
      {"vantage_msgs.image_features_t", test::Encoded(test::SampleImageFeatures())},
      {"vantage_msgs.observability_t", test::Encoded(test::SampleObservability())},
      {"vantage_msgs.servo_status_t", test::Encoded(test::SampleServoStatus())},
      {"vantage_msgs.servo_inputs_t", test::Encoded(test::SampleServoRecord())},
      {"vantage_msgs.servo_setup_t", test::Encoded(test::SampleServoSetup())},
      {"vantage_msgs.sim_truth_t", test::Encoded(test::SampleGroundTruth())},
      {"drake.lcmt_panda_status", test::Encoded(test::SamplePandaStatus())},
      {"bot_core.rigid_transform_t", test::Encoded(test::SampleCameraPose())},
      {"bot_core.image_t", test::Encoded(test::SampleCameraImage())},
  };
  const test::TemporaryFolder folder;
  for (const auto& [type, bytes] : samples) WriteFile(folder.path() / (type + ".in"), bytes);
  std::vector<std::string> generate{"lcm-gen", "-p", "--ppath", folder.path().string()};
  for (const auto& file : fs::directory_iterator(VANTAGE_LCM_TYPES)) {
    if (file.path().extension() == ".lcm") generate.push_back(file.path());
  }
  ASSERT_EQ(RunToEnd(generate, folder), "");
  const std::string problem =
      RunToEnd({VANTAGE_PYTHON, std::string(VANTAGE_MESSAGING_TESTS) + "/echo_messages.py",
                folder.path().string()},
               folder);
  ASSERT_EQ(problem, "");
  for (const auto& [type, bytes] : samples)
    EXPECT_EQ(ReadFile(folder.path() / (type + ".out")), bytes) << type;
}

// What Python reads is what was meant, not only the same bytes again.
TEST(Python, ReadsTheValues) {
  const test::TemporaryFolder folder;
  WriteFile(folder.path() / "vantage_msgs.joint_state_t.in",
            test::Encoded(test::SampleJointState()));
  ASSERT_EQ(RunToEnd({"lcm-gen", "-p", "--ppath", folder.path().string(),
                      std::string(VANTAGE_LCM_TYPES) + "/joint_state_t.lcm"},
                     folder),
            "");
  ASSERT_EQ(RunToEnd({VANTAGE_PYTHON, std::string(VANTAGE_MESSAGING_TESTS) + "/echo_messages.py",
                      folder.path().string()},
                     folder),
            "");
  const Bytes text = ReadFile(folder.path() / "vantage_msgs.joint_state_t.txt");
  EXPECT_EQ(std::string(text.begin(), text.end()),
            "utime 1234567\nnum_joints 6\nposition (-1.0, -0.6, -0.2, 0.2, 0.6, 1.0)\n"
            "velocity (0.1, 0.2, 0.3, 0.4, 0.5, 0.6)\n");
}

// Events of a log by channel; those of a type we decode must decode.
struct LogContent {
  std::map<std::string, int> events;
  int undecodable{0};
};

template <typename Value>
bool Decodes(const lcm::LogEvent& event) {
  Value value;
  return Decode(event.data, static_cast<std::size_t>(event.datalen), &value) == Refusal::kNone;
}

LogContent ReadLog(const std::string& path) {
  const std::map<std::string, bool (*)(const lcm::LogEvent&)> decoders{
      {kJointStateChannel, Decodes<JointState>},
      {kJointCommandChannel, Decodes<JointCommand>},
      {kCameraPoseChannel, Decodes<CameraPose>},
      {kCameraPoseCommandChannel, Decodes<CameraPose>},
      {kImageFeaturesChannel, Decodes<ImageFeatures>},
      {kObservabilityChannel, Decodes<ObservabilityReport>},
      {kServoStatusChannel, Decodes<ServoStatus>},
      {kSimTruthChannel, Decodes<GroundTruth>},
      {kCameraImageChannel, Decodes<CameraImage>},
  };
  LogContent content;
  lcm::LogFile log(path, "r");
  if (!log.good()) return content;
  while (const lcm::LogEvent* event = log.readNextEvent()) {
    ++content.events[event->channel];
    const auto decoder = decoders.find(event->channel);
    if (decoder == decoders.end() || !decoder->second(*event)) ++content.undecodable;
  }
  return content;
}

TEST(StockLogger, RecordsAndReplaysThroughTheHub) {
  const test::TemporaryFolder folder;
  const std::string log = folder.path() / "log";
  const TcpHub hub(test::AnyPort());
  {
    ChildOptions logger_options;
    logger_options.arguments = {"lcm-logger", "--lcm-url=" + hub.url(), log};
    logger_options.output = folder.path() / "logger";
    ChildProcess logger(logger_options);
    ASSERT_TRUE(BecomesTrue([&] { return hub.stats().clients == 1; }));
    ChildOptions publisher_options;
    publisher_options.arguments = {VANTAGE_PUBLISH_SAMPLES, "600", hub.url()};
    publisher_options.output = "/dev/null";
    const ChildProcess publisher(publisher_options);
    // Until the log holds a second's worth of traffic, 8 channels at 50 Hz and images.
    ASSERT_TRUE(BecomesTrue([&] { return hub.stats().delivered > 450; }));
    EXPECT_EQ(logger.Terminate(test::kPatience).signal, 0);
  }
  const LogContent content = ReadLog(log);
  EXPECT_EQ(content.events.size(), 9U);
  EXPECT_EQ(content.undecodable, 0);
  ASSERT_GT(content.events.count(kJointStateChannel), 0U);
  EXPECT_GT(content.events.at(kJointStateChannel), 20);

  // The same log played to a link: all of it arrives, in order.
  LcmLink link({hub.url(), ""});
  std::atomic<int> states{0};
  SubscribeOptions every;
  every.delivery = Delivery::kEvery;
  every.stamps.not_from_future = false;
  link.Subscribe<JointState>(
      kJointStateChannel, [&](const JointState&) { ++states; }, every);
  link.Start();
  ASSERT_TRUE(link.stats().connected);
  EXPECT_EQ(RunToEnd({"lcm-logplayer", "--lcm-url=" + hub.url(), "--speed=4", log}, folder), "");
  EXPECT_TRUE(BecomesTrue([&] { return states == content.events.at(kJointStateChannel); }))
      << states << " of " << content.events.at(kJointStateChannel);
  EXPECT_EQ(link.stats().total_refused(), 0);
}

}  // namespace
}  // namespace vantage
