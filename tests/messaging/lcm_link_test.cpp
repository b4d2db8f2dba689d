#include "vantage/messaging/lcm_link.h"

#include <atomic>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>

#include <gtest/gtest.h>

#include "any_port.h"
#include "raw_client.h"
#include "samples.h"
#include "vantage/math/error.h"
#include "vantage/messaging/tcp_hub.h"
#include "vantage/messaging/transport.h"
#include "vantage/runtime/latest_value.h"

namespace vantage {
namespace {

using std::chrono::milliseconds;
using test::AnyPort;
using test::BecomesTrue;

JointState StateNow(double q0 = 0.0) {
  JointState state = test::SampleJointState();
  state.stamp = Clock::now();
  state.q[0] = q0;
  return state;
}

SubscribeOptions Every() {
  SubscribeOptions options;
  options.delivery = Delivery::kEvery;
  return options;
}

// What a callback got, for another thread to look at.
template <typename T>
class Inbox {
 public:
  void Add(const T& value) {
    const std::lock_guard<std::mutex> lock(mutex_);
    values_.push_back(value);
  }
  [[nodiscard]] std::vector<T> values() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return values_;
  }
  [[nodiscard]] std::size_t size() const { return values().size(); }

 private:
  mutable std::mutex mutex_;
  std::vector<T> values_;
};

// Publishes until the other side, whose subscription may still be on its way, has got something.
template <typename T>
bool PublishUntil(LcmLink* link, const std::string& channel, const std::function<T()>& make,
                  const std::function<bool()>& arrived) {
  return BecomesTrue([&] {
    link->Publish(channel, make());
    return arrived();
  });
}

// --- Set-up errors -------------------------------------------------------------------------------

std::string ErrorOf(const LcmLinkOptions& options) {
  try {
    const LcmLink link(options);
  } catch (const ConfigError& error) {
    return error.key();
  }
  return "";
}

TEST(LcmLinkSetUp, RefusesBadUrlsAndPrefixes) {
  for (const char* url :
       {"", "http://x", "tcpq://h:0", "tcpq://h:65536", "tcpq://h:x", "tcpq://h:"}) {
    EXPECT_EQ(ErrorOf({url, ""}), "lcm.url") << url;
  }
  for (const char* url : {"memq://", "tcpq://", "tcpq://127.0.0.1", "tcpq://127.0.0.1:7700"}) {
    EXPECT_EQ(ErrorOf({url, ""}), "") << url;
  }
  for (const char* prefix : {"A.*", "A B", "A/", "012345678901234567890123456789012"}) {
    EXPECT_EQ(ErrorOf({"memq://", prefix}), "lcm.prefix") << prefix;
  }
  EXPECT_EQ(ErrorOf({"memq://", "ARM-1_"}), "");
}

TEST(LcmLinkSetUp, PublishingWithoutConnectionSaysSo) {
  LcmLink link({"tcpq://127.0.0.1:1", ""});
  EXPECT_FALSE(link.Publish(kJointStateChannel, StateNow()));
  link.Start();
  EXPECT_FALSE(link.Publish(kJointStateChannel, StateNow()));
  EXPECT_EQ(link.stats().unsent, 2);
  EXPECT_FALSE(link.stats().connected);
}

// --- The same over each transport ----------------------------------------------------------------

// memq:// stays within one link; over the hub a second one publishes.
class OverTransport : public ::testing::TestWithParam<const char*> {
 protected:
  OverTransport() {
    if (std::string(GetParam()) == "hub") {
      hub_ = std::make_unique<TcpHub>(AnyPort());
      url_ = hub_->url();
    } else if (std::string(GetParam()) == "multicast") {
      url_ = MulticastUrl();
    } else {
      url_ = "memq://";
    }
  }
  void SetUp() override {
    if (std::string(GetParam()) == "multicast" && !TestMulticast().works) {
      GTEST_SKIP() << "no multicast here";
    }
    // A prefix of this process: other tests may use the same multicast group at the same time.
    prefix_ = "T" + std::to_string(getpid()) + "_";
  }

  // A link for the tests below; publisher() is another one where that works.
  std::unique_ptr<LcmLink> MakeLink() {
    return std::make_unique<LcmLink>(LcmLinkOptions{url_, prefix_});
  }
  LcmLink* PublisherFor(LcmLink* receiver) {
    if (url_ == "memq://") return receiver;
    publisher_ = MakeLink();
    publisher_->Start();
    return publisher_.get();
  }

  std::unique_ptr<TcpHub> hub_;
  std::string url_;
  std::string prefix_;
  std::unique_ptr<LcmLink> publisher_;
};

TEST_P(OverTransport, EveryTypeCrosses) {
  const auto link = MakeLink();
  std::atomic<int> arrived{0};
  const auto mark = [&arrived](int bit) {
    return [&arrived, bit](const auto&) { arrived |= 1 << bit; };
  };
  SubscribeOptions any_time;
  any_time.stamps.in_order = false;
  link->Subscribe<JointState>(kJointStateChannel, mark(0), any_time);
  link->Subscribe<JointCommand>(kJointCommandChannel, mark(1), any_time);
  link->Subscribe<CameraPose>(kCameraPoseChannel, mark(2), any_time);
  link->Subscribe<ImageFeatures>(kImageFeaturesChannel, mark(3), any_time);
  link->Subscribe<ObservabilityReport>(kObservabilityChannel, mark(4), any_time);
  link->Subscribe<ServoStatus>(kServoStatusChannel, mark(5), any_time);
  link->Subscribe<CameraImage>(kCameraImageChannel, mark(6), any_time);
  link->Subscribe<GroundTruth>(kSimTruthChannel, mark(7), any_time);
  link->Start();
  LcmLink* publisher = PublisherFor(link.get());
  EXPECT_TRUE(BecomesTrue([&] {
    publisher->Publish(kJointStateChannel, test::SampleJointState());
    publisher->Publish(kJointCommandChannel, test::SampleJointCommand());
    publisher->Publish(kCameraPoseChannel, test::SampleCameraPose());
    publisher->Publish(kImageFeaturesChannel, test::SampleImageFeatures());
    publisher->Publish(kObservabilityChannel, test::SampleObservability());
    publisher->Publish(kServoStatusChannel, test::SampleServoStatus());
    publisher->Publish(kCameraImageChannel, test::SampleCameraImage());
    publisher->Publish(kSimTruthChannel, test::SampleGroundTruth());
    return arrived == 0xff;
  })) << std::hex
      << arrived;
  EXPECT_EQ(link->stats().total_refused(), 0);
  EXPECT_EQ(link->stats().connects, 1);
}

TEST_P(OverTransport, ReadsTheChannelsOfItsPrefixAlone) {
  const auto link = MakeLink();
  Inbox<JointState> inbox;
  link->Subscribe<JointState>(
      "A", [&](const JointState& s) { inbox.Add(s); }, Every());
  link->Start();
  LcmLink* publisher = PublisherFor(link.get());
  ASSERT_TRUE(PublishUntil<JointState>(
      publisher, "A", [] { return StateNow(1.0); }, [&] { return inbox.size() > 0; }));
  // A longer and a shorter name are others.
  publisher->Publish("AA", StateNow(2.0));
  publisher->Publish("XA", StateNow(2.0));
  publisher->Publish("A", StateNow(3.0));
  ASSERT_TRUE(BecomesTrue([&] { return inbox.values().back().q[0] == 3.0; }));
  for (const JointState& state : inbox.values()) EXPECT_NE(state.q[0], 2.0);
}

TEST_P(OverTransport, CountsGarbageAndKeepsTheGoodValue) {
  const auto link = MakeLink();
  Inbox<JointState> inbox;
  std::atomic<bool> hold{true};
  link->Subscribe<JointState>("A", [&](const JointState& s) {
    inbox.Add(s);
    while (hold) std::this_thread::sleep_for(milliseconds(1));
  });
  link->Start();
  LcmLink* publisher = PublisherFor(link.get());
  ASSERT_TRUE(PublishUntil<JointState>(
      publisher, "A", [] { return StateNow(1.0); }, [&] { return inbox.size() == 1; }));
  // While the callback is busy: a good value, then garbage of several kinds on the same channel.
  ASSERT_TRUE(publisher->Publish("A", StateNow(2.0)));
  Bytes bytes = test::Encoded(StateNow(3.0));
  bytes[20] ^= 1;  // A joint count of its own.
  Bytes truncated = bytes;
  truncated.resize(10);
  ASSERT_TRUE(publisher->PublishBytes("A", truncated));
  ASSERT_TRUE(publisher->PublishBytes("A", test::Encoded(test::SampleCameraPose())));
  JointState not_finite = StateNow(4.0);
  not_finite.q[0] = std::numeric_limits<double>::infinity();
  ASSERT_TRUE(publisher->Publish("A", not_finite));
  JointState future = StateNow(5.0);
  future.stamp += std::chrono::hours(1);
  ASSERT_TRUE(publisher->Publish("A", future));
  JointState old = StateNow(6.0);
  old.stamp -= milliseconds(100);
  ASSERT_TRUE(publisher->Publish("A", old));
  hold = false;
  ASSERT_TRUE(BecomesTrue([&] { return link->stats().total_refused() == 5; }));
  ASSERT_TRUE(BecomesTrue([&] { return inbox.size() == 2; }));
  EXPECT_EQ(inbox.values().back().q[0], 2.0);
  const LinkStats stats = link->stats();
  for (const Refusal refusal : {Refusal::kTruncated, Refusal::kFingerprint, Refusal::kNotFinite,
                                Refusal::kFuture, Refusal::kReordered}) {
    EXPECT_EQ(stats.refused[static_cast<int>(refusal)], 1) << Name(refusal);
  }
}

TEST_P(OverTransport, GivesABusyCallbackTheNewestAlone) {
  const auto link = MakeLink();
  Inbox<JointState> inbox;
  std::atomic<bool> hold{true};
  link->Subscribe<JointState>("A", [&](const JointState& s) {
    inbox.Add(s);
    while (hold) std::this_thread::sleep_for(milliseconds(1));
  });
  link->Start();
  LcmLink* publisher = PublisherFor(link.get());
  ASSERT_TRUE(PublishUntil<JointState>(
      publisher, "A", [] { return StateNow(-1.0); }, [&] { return inbox.size() == 1; }));
  for (int i = 0; i < 20; ++i) {
    std::this_thread::sleep_for(milliseconds(1));  // Time stamps are in whole microseconds.
    ASSERT_TRUE(publisher->Publish("A", StateNow(i)));
  }
  // All of them wait in the link's queue or socket by the time the callback returns: what is sent on
  // this machine has arrived when sending returns, but for the hub, which needs a moment.
  std::this_thread::sleep_for(milliseconds(200));
  hold = false;
  ASSERT_TRUE(BecomesTrue([&] { return inbox.size() >= 2; }));
  EXPECT_EQ(inbox.values()[1].q[0], 19.0);
  EXPECT_GE(link->stats().dropped, 19);
}

TEST_P(OverTransport, GivesEveryValueInOrderWhenAskedTo) {
  const auto link = MakeLink();
  Inbox<JointState> inbox;
  link->Subscribe<JointState>(
      "A", [&](const JointState& s) { inbox.Add(s); }, Every());
  link->Start();
  LcmLink* publisher = PublisherFor(link.get());
  ASSERT_TRUE(PublishUntil<JointState>(
      publisher, "A", [] { return StateNow(-1.0); }, [&] { return inbox.size() > 0; }));
  for (int i = 0; i < 50; ++i) {
    std::this_thread::sleep_for(milliseconds(1));
    ASSERT_TRUE(publisher->Publish("A", StateNow(i)));
  }
  ASSERT_TRUE(BecomesTrue([&] { return inbox.values().back().q[0] == 49.0; }));
  const std::vector<JointState> values = inbox.values();
  for (int i = 0; i < 50; ++i) EXPECT_EQ(values[values.size() - 50 + i].q[0], i);
}

TEST_P(OverTransport, SurvivesCallbacksThatThrow) {
  const auto link = MakeLink();
  std::atomic<int> calls{0};
  link->Subscribe<JointState>("A", [&](const JointState&) {
    if (++calls < 4) throw std::runtime_error("from a callback");
  });
  link->Start();
  LcmLink* publisher = PublisherFor(link.get());
  EXPECT_TRUE(PublishUntil<JointState>(
      publisher, "A", [] { return StateNow(); }, [&] { return calls >= 5; }));
  EXPECT_EQ(link->stats().callback_errors, 3);
}

TEST_P(OverTransport, CallbacksMayPublish) {
  const auto link = MakeLink();
  std::atomic<int> echoes{0};
  LcmLink* self = link.get();
  link->Subscribe<JointState>("A", [self](const JointState& s) { self->Publish("B", s); });
  link->Subscribe<JointState>("B", [&](const JointState&) { ++echoes; });
  link->Start();
  LcmLink* publisher = PublisherFor(link.get());
  EXPECT_TRUE(PublishUntil<JointState>(
      publisher, "A", [] { return StateNow(); }, [&] { return echoes > 0; }));
}

// Four threads at once on one link: every message arrives whole.
TEST_P(OverTransport, PublishesFromManyThreads) {
  const auto link = MakeLink();
  constexpr int kThreads = 4;
  constexpr int kMessages = 100;
  std::array<std::atomic<int>, kThreads> next{};
  std::atomic<int> total{0};
  for (int t = 0; t < kThreads; ++t) {
    link->Subscribe<JointState>(
        "T" + std::to_string(t),
        [&next, &total, t](const JointState& s) {
          if (s.q[0] == next[t]) ++next[t];
          ++total;
        },
        Every());
  }
  link->Start();
  LcmLink* publisher = PublisherFor(link.get());
  for (int t = 0; t < kThreads; ++t) {
    ASSERT_TRUE(PublishUntil<JointState>(
        publisher, "T" + std::to_string(t), [] { return StateNow(0.0); },
        [&] { return next[t] >= 1; }));
  }
  std::vector<std::thread> threads;
  for (int t = 0; t < kThreads; ++t) {
    threads.emplace_back([publisher, t] {
      for (int i = 1; i <= kMessages; ++i) {
        std::this_thread::sleep_for(milliseconds(1));
        publisher->Publish("T" + std::to_string(t), StateNow(i));
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_TRUE(BecomesTrue([&] {
    for (const auto& n : next) {
      if (n != kMessages + 1) return false;
    }
    return true;
  }));
  EXPECT_EQ(link->stats().total_refused(), 0);
}

INSTANTIATE_TEST_SUITE_P(Transports, OverTransport, ::testing::Values("memq", "hub", "multicast"),
                         [](const auto& test) { return std::string(test.param); });

// --- Losing the hub ------------------------------------------------------------------------------

TEST(LcmLinkReconnects, WhenTheHubIsRestarted) {
  auto hub = std::make_unique<TcpHub>(AnyPort());
  TcpHubOptions same_port;
  same_port.port = hub->port();
  same_port.ports_tried = 1;
  LcmLink receiver({hub->url(), ""});
  LcmLink sender({hub->url(), ""});
  std::atomic<int> arrived{0};
  receiver.Subscribe<JointState>("A", [&](const JointState&) { ++arrived; });
  receiver.Start();
  sender.Start();
  for (int restarts = 0; restarts < 3; ++restarts) {
    const int before = arrived;
    ASSERT_TRUE(PublishUntil<JointState>(
        &sender, "A", [] { return StateNow(); }, [&] { return arrived > before; }))
        << "after " << restarts << " restarts";
    hub.reset();
    ASSERT_TRUE(BecomesTrue([&] {
      sender.Publish("A", StateNow());
      return !receiver.stats().connected && !sender.stats().connected;
    }));
    EXPECT_FALSE(sender.Publish("A", StateNow()));
    hub = std::make_unique<TcpHub>(same_port);
  }
  EXPECT_GE(receiver.stats().connects, 3);
}

TEST(LcmLinkReconnects, WhenTheHubComesLater) {
  std::uint16_t port = 0;
  { port = TcpHub(AnyPort()).port(); }
  LcmLink link({"tcpq://127.0.0.1:" + std::to_string(port), ""});
  std::atomic<int> arrived{0};
  link.Subscribe<JointState>("A", [&](const JointState&) { ++arrived; });
  link.Start();
  EXPECT_FALSE(link.stats().connected);
  TcpHubOptions options;
  options.port = port;
  options.ports_tried = 1;
  const TcpHub hub(options);
  EXPECT_TRUE(PublishUntil<JointState>(
      &link, "A", [] { return StateNow(); }, [&] { return arrived > 0; }));
}

// A server that says what it is told to, and then nothing, or hangs up: the worst a hub can be.
class FakeHub {
 public:
  explicit FakeHub(test::RawBytes says, bool hangs_up = false)
      : says_(std::move(says)), hangs_up_(hangs_up) {
    listener_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof(address);
    bind(listener_, reinterpret_cast<sockaddr*>(&address), size);
    getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size);
    listen(listener_, 8);
    port_ = ntohs(address.sin_port);
    thread_ = std::thread([this] {
      for (;;) {
        const int client = accept(listener_, nullptr, nullptr);
        if (client < 0) return;
        ++accepted_;
        clients_.push_back(client);
        send(client, says_.data(), says_.size(), MSG_NOSIGNAL);
        if (hangs_up_) shutdown(client, SHUT_WR);
      }
    });
  }
  ~FakeHub() {
    shutdown(listener_, SHUT_RDWR);
    thread_.join();
    close(listener_);
    for (const int client : clients_) close(client);
  }
  FakeHub(const FakeHub&) = delete;
  FakeHub& operator=(const FakeHub&) = delete;

  [[nodiscard]] std::string url() const { return "tcpq://127.0.0.1:" + std::to_string(port_); }
  [[nodiscard]] int accepted() const { return accepted_; }

 private:
  const test::RawBytes says_;
  const bool hangs_up_;
  int listener_{-1};
  std::uint16_t port_{0};
  std::vector<int> clients_;
  std::atomic<int> accepted_{0};
  std::thread thread_;
};

test::RawBytes ServerHello() {
  test::RawBytes bytes;
  test::Append(0x287617fa, &bytes);
  test::Append(0x0100, &bytes);
  return bytes;
}

test::RawBytes Joined(test::RawBytes first, const test::RawBytes& second) {
  first.insert(first.end(), second.begin(), second.end());
  return first;
}

TEST(LcmLinkSurvives, AHubThatNeverAnswers) {
  const FakeHub hub({});
  LcmLink link({hub.url(), ""});
  link.Start();
  EXPECT_FALSE(link.Publish("A", StateNow()));
  EXPECT_TRUE(BecomesTrue([&] { return hub.accepted() >= 2; }));
}

TEST(LcmLinkSurvives, AServerThatIsNoHub) {
  const FakeHub hub({'2', '2', '0', ' ', 'f', 't', 'p', '\n'});
  LcmLink link({hub.url(), ""});
  link.Start();
  EXPECT_TRUE(BecomesTrue([&] { return hub.accepted() >= 2; }));
  EXPECT_FALSE(link.stats().connected);
}

TEST(LcmLinkSurvives, AHubThatStopsInTheMiddleOfAMessage) {
  const test::RawBytes whole = test::PublishMessage("A", test::Encoded(StateNow()));
  const test::RawBytes half(whole.begin(), whole.begin() + 40);
  const FakeHub hub(Joined(ServerHello(), Joined(whole, half)));
  LcmLink link({hub.url(), ""});
  std::atomic<int> arrived{0};
  link.Subscribe<JointState>("A", [&](const JointState&) { ++arrived; });
  link.Start();
  // The half was sent together with the whole one before it.
  EXPECT_TRUE(BecomesTrue([&] { return arrived > 0; }));
  EXPECT_TRUE(link.Publish("A", StateNow()));
  EXPECT_EQ(link.stats().received, 1);
  EXPECT_EQ(arrived, 1);
}

TEST(LcmLinkSurvives, AHubThatHangsUpInTheMiddleOfAMessage) {
  test::RawBytes half = test::PublishMessage("A", test::Encoded(StateNow()));
  half.resize(40);
  const FakeHub hub(Joined(ServerHello(), half), true);
  LcmLink link({hub.url(), ""});
  std::atomic<int> arrived{0};
  link.Subscribe<JointState>("A", [&](const JointState&) { ++arrived; });
  link.Start();
  // It comes again once it has read the half and the end.
  EXPECT_TRUE(BecomesTrue([&] { return hub.accepted() >= 3; }));
  EXPECT_EQ(link.stats().received, 0);
  EXPECT_EQ(arrived, 0);
}

TEST(LcmLinkSurvives, AHubThatTalksNonsense) {
  for (const test::RawBytes& nonsense :
       {test::NameMessage(9, "A"), test::NameMessage(2, "A"),
        Joined(test::NameMessage(1, "A"), {0xff, 0xff, 0xff, 0xff})}) {
    const FakeHub hub(Joined(ServerHello(), nonsense));
    LcmLink link({hub.url(), ""});
    link.Start();
    EXPECT_TRUE(BecomesTrue([&] { return hub.accepted() >= 2; }));
  }
}

// A hub that accepts and then reads nothing: publishing must not wait for ever.
TEST(LcmLinkSurvives, AHubThatDoesNotRead) {
  const FakeHub hub(ServerHello());
  LcmLink link({hub.url(), ""});
  link.Start();
  CameraImage image = test::SampleCameraImage();
  image.width = 1000;
  image.height = 1000;
  image.row_stride = 1000;
  image.data.resize(1'000'000);
  EXPECT_TRUE(BecomesTrue([&] { return !link.Publish("IMAGE", image); }));
  EXPECT_TRUE(BecomesTrue([&] { return link.stats().connects >= 2; }));
}

TEST(LcmLink, FeedsAMailbox) {
  const TcpHub hub(AnyPort());
  LcmLink link({hub.url(), ""});
  LatestValue<JointState> mailbox;
  link.Subscribe<JointState>("A", [&](const JointState& s) { mailbox.Publish(s); });
  link.Start();
  JointState got;
  EXPECT_TRUE(PublishUntil<JointState>(
      &link, "A", [] { return StateNow(7.0); }, [&] { return mailbox.Take(&got); }));
  EXPECT_EQ(got.q[0], 7.0);
}

}  // namespace
}  // namespace vantage
