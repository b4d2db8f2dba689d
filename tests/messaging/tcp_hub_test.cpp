#include "vantage/messaging/tcp_hub.h"

#include <cstdio>
#include <fstream>
#include <random>
#include <string>
#include <thread>

#include <gtest/gtest.h>
#include <ifaddrs.h>
#include <lcm/lcm-cpp.hpp>
#include <net/if.h>
#include <unistd.h>

#include "any_port.h"
#include "raw_client.h"
#include "vantage/math/error.h"

namespace vantage {
namespace {

using std::chrono::milliseconds;
using test::AnyPort;
using test::BecomesTrue;
using test::RawBytes;
using test::RawClient;

constexpr milliseconds kShort(50);  // To see that nothing comes.

RawBytes Numbered(std::uint32_t number, std::size_t size = 4) {
  RawBytes bytes;
  test::Append(number, &bytes);
  bytes.resize(size, static_cast<std::uint8_t>(number));
  return bytes;
}

std::uint32_t NumberOf(const RawBytes& bytes) {
  return std::uint32_t{bytes[0]} << 24 | std::uint32_t{bytes[1]} << 16 |
         std::uint32_t{bytes[2]} << 8 | std::uint32_t{bytes[3]};
}

// --- What it does --------------------------------------------------------------------------------

TEST(TcpHub, PassesMessagesToSubscribersAlone) {
  const TcpHub hub(AnyPort());
  RawClient publisher(hub.port());
  RawClient subscriber(hub.port());
  RawClient other(hub.port());
  ASSERT_TRUE(subscriber.Subscribe("JOINT_STATE") && subscriber.Sync());
  ASSERT_TRUE(other.Subscribe("CAMERA_POSE") && other.Sync());
  ASSERT_TRUE(publisher.Publish("JOINT_STATE", {1, 2, 3}));
  const auto message = subscriber.Receive();
  ASSERT_TRUE(message);
  EXPECT_EQ(message->channel, "JOINT_STATE");
  EXPECT_EQ(message->data, (RawBytes{1, 2, 3}));
  EXPECT_FALSE(other.Receive(kShort));
  EXPECT_FALSE(publisher.Receive(kShort));
}

TEST(TcpHub, GivesPublishersTheirOwnMessages) {
  const TcpHub hub(AnyPort());
  RawClient client(hub.port());
  ASSERT_TRUE(client.Subscribe("A") && client.Publish("A", {7}));
  EXPECT_TRUE(client.Receive());
}

TEST(TcpHub, GivesAMessageOnceHoweverManyPatternsMatch) {
  const TcpHub hub(AnyPort());
  RawClient client(hub.port());
  ASSERT_TRUE(client.Subscribe("A") && client.Subscribe(".*") && client.Subscribe("A"));
  ASSERT_TRUE(client.Publish("A", {1}) && client.Publish("B", {2}));
  EXPECT_EQ(client.Receive()->channel, "A");
  EXPECT_EQ(client.Receive()->channel, "B");
}

TEST(TcpHub, MatchesPatternsAgainstTheWholeChannel) {
  const TcpHub hub(AnyPort());
  RawClient client(hub.port());
  for (const char* pattern : {"JOINT", "J.*E", "ARM[12]_POSE", "X|YY", "a\\.b"}) {
    ASSERT_TRUE(client.Subscribe(pattern));
  }
  for (const char* channel : {"JOINT_STATE", "MY_JOINT", "JOINTS", "ARM1_POSE", "ARM3_POSE", "XY",
                              "YY", "a.b", "aXb", "END"}) {
    ASSERT_TRUE(client.Publish(channel, {}));
  }
  ASSERT_TRUE(client.Publish("X", {}));
  std::vector<std::string> got;
  while (got.empty() || got.back() != "X") got.push_back(client.Receive()->channel);
  EXPECT_EQ(got, (std::vector<std::string>{"JOINT_STATE", "ARM1_POSE", "YY", "a.b", "X"}));
}

TEST(TcpHub, StopsAtUnsubscribe) {
  const TcpHub hub(AnyPort());
  RawClient client(hub.port());
  ASSERT_TRUE(client.Subscribe("A") && client.Publish("A", {1}) && client.Receive());
  ASSERT_TRUE(client.Unsubscribe("NEVER_SUBSCRIBED") && client.Unsubscribe("A"));
  ASSERT_TRUE(client.Publish("A", {2}));
  EXPECT_FALSE(client.Receive(kShort));
}

TEST(TcpHub, KeepsTheOrder) {
  const TcpHub hub(AnyPort());
  RawClient publisher(hub.port());
  RawClient subscriber(hub.port());
  ASSERT_TRUE(subscriber.Subscribe("A.*") && subscriber.Sync());
  RawBytes all;
  for (std::uint32_t i = 0; i < 1000; ++i) {
    const RawBytes one = test::PublishMessage(i % 2 == 0 ? "A0" : "A1", Numbered(i));
    all.insert(all.end(), one.begin(), one.end());
  }
  ASSERT_TRUE(publisher.Send(all));
  for (std::uint32_t i = 0; i < 1000; ++i) ASSERT_EQ(NumberOf(subscriber.Receive()->data), i);
}

TEST(TcpHub, PutsMessagesTogetherFromSingleBytes) {
  const TcpHub hub(AnyPort());
  RawClient client(hub.port(), false);
  RawBytes stream = test::ClientHello();
  for (const RawBytes& part : {test::NameMessage(2, "AB"), test::PublishMessage("AB", {9, 8, 7})}) {
    stream.insert(stream.end(), part.begin(), part.end());
  }
  for (const std::uint8_t byte : stream) {
    ASSERT_TRUE(client.Send({byte}));
    std::this_thread::sleep_for(milliseconds(1));
  }
  ASSERT_TRUE(BecomesTrue([&] { return hub.stats().delivered == 1; }));
}

TEST(TcpHub, PassesLargeMessages) {
  TcpHubOptions options = AnyPort();
  options.max_message = 3'000'000;
  options.max_backlog = 1'000'000;  // Smaller than the message: it is taken all the same.
  const TcpHub hub(options);
  RawClient publisher(hub.port());
  RawClient subscriber(hub.port());
  ASSERT_TRUE(subscriber.Subscribe("IMAGE") && subscriber.Sync());
  const RawBytes image = Numbered(5, 3'000'000);
  ASSERT_TRUE(publisher.Publish("IMAGE", image));
  EXPECT_EQ(subscriber.Receive()->data, image);
}

// LCM's own client library is what lcm-spy's C++ relatives and lcm-logger use.
TEST(TcpHub, SpeaksWithLcmsOwnClient) {
  const TcpHub hub(AnyPort());
  lcm::LCM receiver(hub.url());
  lcm::LCM sender(hub.url());
  ASSERT_TRUE(receiver.good() && receiver.getFileno() >= 0);
  struct Got {
    std::string channel;
    RawBytes data;
  } got;
  using Handler = void (*)(const lcm::ReceiveBuffer*, const std::string&, Got*);
  const Handler handler = [](const lcm::ReceiveBuffer* buffer, const std::string& channel,
                             Got* out) {
    const auto* data = static_cast<const std::uint8_t*>(buffer->data);
    *out = {channel, RawBytes(data, data + buffer->data_size)};
  };
  receiver.subscribeFunction("JOINT_.*", handler, &got);
  RawClient probe(hub.port());
  ASSERT_TRUE(probe.Sync());
  const RawBytes data{4, 5, 6};
  // Its SUBSCRIBE is on the way: publish until it has arrived.
  ASSERT_TRUE(BecomesTrue([&] {
    sender.publish("JOINT_STATE", data.data(), 3);
    return receiver.handleTimeout(20) > 0;
  }));
  EXPECT_EQ(got.channel, "JOINT_STATE");
  EXPECT_EQ(got.data, data);
}

// --- Slow clients --------------------------------------------------------------------------------

TEST(TcpHub, ASlowClientSlowsNobodyAndGetsTheNewest) {
  TcpHubOptions options = AnyPort();
  options.max_backlog = 1'000'000;
  const TcpHub hub(options);
  RawClient publisher(hub.port());
  RawClient quick(hub.port());
  RawClient slow(hub.port());
  ASSERT_TRUE(quick.Subscribe("A") && quick.Sync());
  ASSERT_TRUE(slow.Subscribe("A") && slow.Sync());
  // 60 MB: far more than the system's buffers and the backlog hold.
  constexpr std::uint32_t kMessages = 1000;
  constexpr std::size_t kSize = 60'000;
  for (std::uint32_t i = 0; i < kMessages; ++i) {
    ASSERT_TRUE(publisher.Publish("A", Numbered(i, kSize)));
    const auto message = quick.Receive();
    ASSERT_TRUE(message);
    ASSERT_EQ(message->data, Numbered(i, kSize));
  }
  const TcpHubStats stats = hub.stats();
  EXPECT_GT(stats.dropped, 0);
  EXPECT_EQ(stats.clients, 3);
  EXPECT_EQ(stats.protocol_errors, 0);

  // Now the slow one reads: whole messages, in order, the last one the newest.
  std::uint32_t got = 0;
  std::int64_t last = -1;
  while (last != kMessages - 1) {
    const auto message = slow.Receive();
    ASSERT_TRUE(message);
    const std::uint32_t number = NumberOf(message->data);
    ASSERT_GT(std::int64_t{number}, last);
    ASSERT_EQ(message->data, Numbered(number, kSize));
    last = number;
    ++got;
  }
  EXPECT_EQ(got + hub.stats().dropped, kMessages);
}

// --- Hostile clients -----------------------------------------------------------------------------

class HostileClient : public ::testing::Test {
 protected:
  HostileClient() : hub_(Options()), bystander_(hub_.port()) {}

  static TcpHubOptions Options() {
    TcpHubOptions options = AnyPort();
    options.max_message = 1000;
    return options;
  }

  // The bystander subscribed before the attack still gets what is published after it.
  void ExpectUnharmed() {
    RawClient publisher(hub_.port());
    ASSERT_TRUE(bystander_.Subscribe("LIFE") && bystander_.Sync());
    ASSERT_TRUE(publisher.Publish("LIFE", {42}));
    const auto message = bystander_.Receive();
    ASSERT_TRUE(message);
    EXPECT_EQ(message->data, RawBytes{42});
  }

  void ExpectCutOff(const RawBytes& stream) {
    RawClient client(hub_.port());
    ASSERT_TRUE(client.connected());
    client.Send(stream);
    EXPECT_TRUE(client.IsClosed());
    EXPECT_EQ(hub_.stats().protocol_errors, 1);
    ExpectUnharmed();
  }

  TcpHub hub_;
  RawClient bystander_;
};

TEST_F(HostileClient, WithAnotherMagicIsCutOff) {
  RawClient client(hub_.port(), false);
  client.Send({'G', 'E', 'T', ' ', '/', ' ', 'H', 'T'});
  EXPECT_TRUE(client.IsClosed());
  EXPECT_EQ(hub_.stats().protocol_errors, 1);
  ExpectUnharmed();
}

TEST_F(HostileClient, WithAnUnknownMessageIsCutOff) {
  ExpectCutOff(test::NameMessage(4, "A"));
}

TEST_F(HostileClient, WithAnEmptyNameIsCutOff) {
  ExpectCutOff(test::NameMessage(2, ""));
}

TEST_F(HostileClient, WithAnEndlessNameIsCutOff) {
  ExpectCutOff(test::NameMessage(2, std::string(256, 'A')));
}

TEST_F(HostileClient, WithAnUnprintableNameIsCutOff) {
  ExpectCutOff(test::PublishMessage(std::string("A\0B", 3), {}));
}

TEST_F(HostileClient, WithAHugeMessageIsCutOff) {
  RawBytes stream = test::NameMessage(1, "A");
  test::Append(0xffffffff, &stream);
  ExpectCutOff(stream);
}

TEST_F(HostileClient, JustAboveTheLargestMessageIsCutOff) {
  ExpectCutOff(test::PublishMessage("A", RawBytes(1001)));
}

TEST_F(HostileClient, WithABrokenPatternIsCutOff) {
  ExpectCutOff(test::NameMessage(2, "(["));
}

TEST_F(HostileClient, WithTooManySubscriptionsIsCutOff) {
  RawBytes stream;
  for (int i = 0; i < 1025; ++i) {
    const RawBytes one = test::NameMessage(2, "A");
    stream.insert(stream.end(), one.begin(), one.end());
  }
  ExpectCutOff(stream);
}

// Takes a backtracking engine without limits some 2^60 steps.
TEST_F(HostileClient, WithACostlyPatternDoesNoHarm) {
  RawClient client(hub_.port());
  ASSERT_TRUE(client.Subscribe("(A*)*B") && client.Sync());
  ASSERT_TRUE(client.Publish(std::string(60, 'A'), {}));
  ExpectUnharmed();
  EXPECT_EQ(hub_.stats().protocol_errors, 0);
}

TEST_F(HostileClient, ThatStopsInTheMiddleDoesNoHarm) {
  RawClient client(hub_.port());
  RawBytes half = test::PublishMessage("A", RawBytes(500));
  half.resize(100);
  ASSERT_TRUE(client.Send(half));
  ExpectUnharmed();
}

TEST_F(HostileClient, ThatMakesUpChannelsDoesNoHarm) {
  RawClient client(hub_.port());
  ASSERT_TRUE(bystander_.Subscribe("C9999"));
  ASSERT_TRUE(bystander_.Sync());
  for (int i = 0; i < 10'000; ++i) {
    ASSERT_TRUE(client.Publish("C" + std::to_string(i), Numbered(static_cast<std::uint32_t>(i))));
  }
  EXPECT_EQ(NumberOf(bystander_.Receive()->data), 9999U);
}

TEST_F(HostileClient, WithRandomBytesIsCutOff) {
  std::mt19937 random(3);
  for (int i = 0; i < 200; ++i) {
    RawClient client(hub_.port(), i % 2 == 0);
    RawBytes noise(1 + random() % 300);
    for (std::uint8_t& byte : noise) byte = static_cast<std::uint8_t>(random());
    client.Send(noise);
  }
  ExpectUnharmed();
}

// A machine that went away without a word leaves a connection half open. That the kernel asks after it is in its
// table: a keep-alive timer (2) that runs out within ten seconds.
TEST(TcpHub, AsksAfterClientsThatAreSilent) {
  const TcpHub hub(AnyPort());
  RawClient client(hub.port());
  ASSERT_TRUE(client.Subscribe("A") && client.Sync());
  bool asks = false;
  const bool found = BecomesTrue([&] {
    std::ifstream table("/proc/net/tcp");
    std::string line;
    std::getline(table, line);
    while (std::getline(table, line)) {
      unsigned port = 0, state = 0, timer = 0;
      unsigned long ticks = 0;
      if (std::sscanf(line.c_str(), "%*d: %*8X:%X %*8X:%*X %X %*X:%*X %X:%lX", &port, &state,
                      &timer, &ticks) == 4 &&
          port == hub.port() && state == 1) {
        asks = timer == 2 && ticks <= 10u * static_cast<unsigned long>(sysconf(_SC_CLK_TCK));
      }
    }
    return asks;
  });
  EXPECT_TRUE(found);
}

TEST(TcpHub, CutsOffWhoDoesNotSayHello) {
  TcpHubOptions options = AnyPort();
  options.handshake_timeout = milliseconds(20);
  const TcpHub hub(options);
  RawClient mute(hub.port(), false);
  RawClient greeter(hub.port());
  EXPECT_TRUE(mute.IsClosed());
  EXPECT_EQ(hub.stats().protocol_errors, 1);
  EXPECT_TRUE(greeter.Sync());
}

TEST(TcpHub, TurnsAwayMoreClientsThanItWants) {
  TcpHubOptions options = AnyPort();
  options.max_clients = 2;
  const TcpHub hub(options);
  RawClient first(hub.port());
  auto second = std::make_unique<RawClient>(hub.port());
  RawClient third(hub.port());
  EXPECT_FALSE(third.connected());
  EXPECT_EQ(hub.stats().turned_away, 1);
  ASSERT_TRUE(first.Sync() && second->Sync());
  // A place that becomes free is given away.
  second.reset();
  ASSERT_TRUE(BecomesTrue([&] { return hub.stats().clients == 1; }));
  EXPECT_TRUE(RawClient(hub.port()).connected());
}

// --- Ports ---------------------------------------------------------------------------------------

TEST(TcpHub, TakesTheNextPortWhenOneIsBusy) {
  const TcpHub first(AnyPort());
  TcpHubOptions options;
  options.port = first.port();
  const TcpHub second(options);
  EXPECT_GT(second.port(), first.port());
  EXPECT_EQ(second.url(), "tcpq://127.0.0.1:" + std::to_string(second.port()));
}

TEST(TcpHub, SaysSoWhenNoPortIsFree) {
  const TcpHub first(AnyPort());
  TcpHubOptions options;
  options.port = first.port();
  options.ports_tried = 1;
  try {
    const TcpHub second(options);
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("Address already in use"), std::string::npos)
        << error.what();
  }
}

TEST(TcpHub, RefusesAnAddressInWords) {
  TcpHubOptions options = AnyPort();
  options.address = "localhost";
  EXPECT_THROW(const TcpHub hub(options), Error);
}

TEST(TcpHub, ServesThisMachineAlone) {
  const TcpHub hub(AnyPort());
  ifaddrs* all = nullptr;
  ASSERT_EQ(getifaddrs(&all), 0);
  bool tried = false;
  for (const ifaddrs* one = all; one != nullptr; one = one->ifa_next) {
    if (one->ifa_addr == nullptr || one->ifa_addr->sa_family != AF_INET) continue;
    if ((one->ifa_flags & IFF_LOOPBACK) != 0 || (one->ifa_flags & IFF_UP) == 0) continue;
    char text[INET_ADDRSTRLEN];
    inet_ntop(AF_INET, &reinterpret_cast<sockaddr_in*>(one->ifa_addr)->sin_addr, text,
              sizeof(text));
    EXPECT_FALSE(RawClient(hub.port(), true, text).connected()) << text;
    tried = true;
  }
  freeifaddrs(all);
  if (!tried) GTEST_SKIP() << "this machine has the loopback interface alone";
}

TEST(TcpHub, CanRestartAtItsPortAtOnce) {
  auto hub = std::make_unique<TcpHub>(AnyPort());
  TcpHubOptions options;
  options.port = hub->port();
  options.ports_tried = 1;
  for (int i = 0; i < 5; ++i) {
    RawClient client(hub->port());
    ASSERT_TRUE(client.Sync());
    hub.reset();
    EXPECT_TRUE(client.IsClosed());
    hub = std::make_unique<TcpHub>(options);
  }
}

TEST(ProbeTcpHub, TellsAHubFromOthers) {
  const TcpHub hub(AnyPort());
  EXPECT_TRUE(ProbeTcpHub("127.0.0.1", hub.port(), test::kPatience));
  EXPECT_TRUE(ProbeTcpHub("localhost", hub.port(), test::kPatience));

  // Listens and never answers.
  const int mute = socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof(address);
  ASSERT_EQ(bind(mute, reinterpret_cast<sockaddr*>(&address), size), 0);
  ASSERT_EQ(getsockname(mute, reinterpret_cast<sockaddr*>(&address), &size), 0);
  const std::uint16_t port = ntohs(address.sin_port);
  EXPECT_FALSE(ProbeTcpHub("127.0.0.1", port, test::kPatience));  // Refused.
  ASSERT_EQ(listen(mute, 1), 0);
  EXPECT_FALSE(ProbeTcpHub("127.0.0.1", port, milliseconds(20)));
  close(mute);
}

}  // namespace
}  // namespace vantage
