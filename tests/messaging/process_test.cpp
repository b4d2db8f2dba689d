// Real processes on a hub, killed, stopped and restarted: what one suffers, the others survive.

#include <csignal>
#include <mutex>

#include <gtest/gtest.h>

#include "any_port.h"
#include "raw_client.h"
#include "samples.h"
#include "vantage/messaging/lcm_link.h"
#include "vantage/messaging/tcp_hub.h"
#include "vantage/runtime/child_process.h"

namespace vantage {
namespace {

using std::chrono::milliseconds;
using test::AnyPort;
using test::BecomesTrue;

// Publishes all channels at 50 Hz.
ChildProcess StartPublisher(const std::string& url) {
  ChildOptions options;
  options.arguments = {VANTAGE_PUBLISH_SAMPLES, "600", url};
  options.output = "/dev/null";
  return ChildProcess(options);
}

// Counts the joint states that arrive.
class Listener {
 public:
  explicit Listener(const std::string& url) : link_({url, ""}) {
    link_.Subscribe<JointState>(kJointStateChannel, [this](const JointState&) { ++count_; });
    link_.Start();
  }
  [[nodiscard]] bool HearsMore() {
    const int before = count_;
    return BecomesTrue([&] { return count_ > before + 3; });
  }
  [[nodiscard]] LinkStats stats() const { return link_.stats(); }

 private:
  std::atomic<int> count_{0};
  LcmLink link_;
};

TEST(Processes, APublisherIsKilledAndRestarted) {
  const TcpHub hub(AnyPort());
  Listener listener(hub.url());
  for (int i = 0; i < 3; ++i) {
    ChildProcess publisher = StartPublisher(hub.url());
    EXPECT_TRUE(listener.HearsMore()) << "start " << i;
    publisher.Signal(SIGKILL);
    ASSERT_TRUE(publisher.WaitFor(test::kPatience));
    ASSERT_TRUE(BecomesTrue([&] { return hub.stats().clients == 1; }));
  }
  EXPECT_EQ(listener.stats().connects, 1);
  EXPECT_EQ(listener.stats().total_refused(), 0);
}

TEST(Processes, TheHubIsRestartedInMidTraffic) {
  auto hub = std::make_unique<TcpHub>(AnyPort());
  TcpHubOptions same_port;
  same_port.port = hub->port();
  same_port.ports_tried = 1;
  Listener listener(hub->url());
  const ChildProcess publisher = StartPublisher(hub->url());
  for (int i = 0; i < 3; ++i) {
    EXPECT_TRUE(listener.HearsMore()) << "start " << i;
    hub.reset();
    hub = std::make_unique<TcpHub>(same_port);
  }
  EXPECT_TRUE(listener.HearsMore());
  EXPECT_EQ(listener.stats().total_refused(), 0);
}

TEST(Processes, AStoppedPublisherStopsNobody) {
  const TcpHub hub(AnyPort());
  Listener listener(hub.url());
  ChildProcess stopped = StartPublisher(hub.url());
  ASSERT_TRUE(listener.HearsMore());
  ASSERT_TRUE(stopped.Signal(SIGSTOP));
  const ChildProcess running = StartPublisher(hub.url());
  EXPECT_TRUE(listener.HearsMore());
  ASSERT_TRUE(stopped.Signal(SIGCONT));
  EXPECT_TRUE(listener.HearsMore());
}

// With LCM's Java hub, a subscriber that is stopped freezes every publisher.
TEST(Processes, AStoppedSubscriberStopsNobody) {
  const TcpHub hub(AnyPort());
  ChildOptions options;
  options.arguments = {"lcm-logger", "--lcm-url=" + hub.url(), "--force", "/dev/null"};
  options.output = "/dev/null";
  ChildProcess logger(options);
  LcmLink publisher({hub.url(), ""});
  publisher.Start();
  // Stopped only once it has subscribed: something has been delivered to it.
  ASSERT_TRUE(BecomesTrue([&] {
    publisher.Publish(kCameraImageChannel, test::SampleCameraImage());
    return hub.stats().delivered > 0;
  }));
  ASSERT_TRUE(logger.Signal(SIGSTOP));

  test::RawClient other(hub.port());
  ASSERT_TRUE(other.Subscribe(kCameraImageChannel) && other.Sync());
  CameraImage image = test::SampleCameraImage();
  image.width = 640;
  image.height = 480;
  image.row_stride = 640;
  image.data.resize(640 * 480);
  // Some 60 MB: the system's buffers for the stopped one are full by far.
  for (int i = 0; i < 200; ++i) {
    ASSERT_TRUE(publisher.Publish(kCameraImageChannel, image)) << i;
    ASSERT_TRUE(other.Receive()) << i;
  }
  EXPECT_GT(hub.stats().dropped, 0);
  EXPECT_EQ(publisher.stats().unsent, 0);
}

}  // namespace
}  // namespace vantage
