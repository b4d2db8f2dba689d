#include "vantage/messaging/transport.h"

#include <atomic>
#include <cstdlib>
#include <thread>

#include <gtest/gtest.h>
#include <lcm/lcm-cpp.hpp>
#include <sys/wait.h>
#include <unistd.h>

#include "any_port.h"
#include "network_namespace.h"
#include "vantage/math/error.h"

namespace vantage {
namespace {

TransportOptions WithMulticast(const MulticastTest& outcome) {
  TransportOptions options;
  options.hub = test::AnyPort();
  options.test_multicast = [outcome](Duration) { return outcome; };
  return options;
}

class ChooseTransportTest : public ::testing::Test {
 protected:
  ChooseTransportTest() { unsetenv("LCM_DEFAULT_URL"); }
  ~ChooseTransportTest() override { unsetenv("LCM_DEFAULT_URL"); }
};

TEST_F(ChooseTransportTest, TakesWhatTheUserSays) {
  setenv("LCM_DEFAULT_URL", "udpm://239.255.76.67:7667?ttl=1", 1);
  const Transport transport = ChooseTransport(WithMulticast({false, "not asked"}));
  EXPECT_EQ(transport.url, "udpm://239.255.76.67:7667?ttl=1");
  EXPECT_EQ(transport.explanation, "");
  EXPECT_FALSE(transport.hub);
  EXPECT_EQ(transport.ReadyLine(), "LCM_DEFAULT_URL='udpm://239.255.76.67:7667?ttl=1' tools/spy");
}

TEST_F(ChooseTransportTest, RefusesAUrlOfTheUsersThatLcmDoesNotKnow) {
  setenv("LCM_DEFAULT_URL", "239.255.76.67:7667", 1);
  EXPECT_THROW((void)ChooseTransport(WithMulticast({true, ""})), ConfigError);
}

TEST_F(ChooseTransportTest, TakesMulticastWhenItWorks) {
  setenv("LCM_DEFAULT_URL", "", 1);
  TransportOptions options = WithMulticast({true, ""});
  options.join_existing = true;
  const Transport transport = ChooseTransport(options);
  EXPECT_EQ(transport.url, "udpm://239.255.76.67:7667?ttl=0&recv_buf_size=2097152");
  EXPECT_EQ(transport.explanation, "");
  EXPECT_FALSE(transport.hub);
}

TEST_F(ChooseTransportTest, TakesAHubElseAndSaysWhy) {
  const Transport transport = ChooseTransport(WithMulticast({false, "no route"}));
  ASSERT_TRUE(transport.hub);
  EXPECT_EQ(transport.url, transport.hub->url());
  EXPECT_EQ(transport.ReadyLine(), "LCM_DEFAULT_URL='" + transport.url + "' tools/spy");
  for (const std::string& part :
       {std::string("no route"), std::string("sudo ip route add 239.255.76.67/32 dev lo"),
        transport.url}) {
    EXPECT_NE(transport.explanation.find(part), std::string::npos) << transport.explanation;
  }
  EXPECT_TRUE(ProbeTcpHub("127.0.0.1", transport.hub->port(), std::chrono::seconds(30)));
}

TEST_F(ChooseTransportTest, JoinsAHubOnlyWhenToldTo) {
  const TcpHub running(test::AnyPort());
  TransportOptions options = WithMulticast({false, "no route"});
  options.hub.port = running.port();
  options.test_timeout = std::chrono::seconds(30);

  const Transport own = ChooseTransport(options);
  ASSERT_TRUE(own.hub);
  EXPECT_NE(own.url, running.url());

  options.join_existing = true;
  const Transport joined = ChooseTransport(options);
  EXPECT_FALSE(joined.hub);
  EXPECT_EQ(joined.url, running.url());
}

TEST_F(ChooseTransportTest, MakesAHubWhenThereIsNoneToJoin) {
  TransportOptions options = WithMulticast({false, "no route"});
  options.join_existing = true;
  EXPECT_TRUE(ChooseTransport(options).hub);
}

// Runs `body` in a process with a network of its own that has the loopback interface alone. Exit code
// kNoNamespace when the system does not allow that.
constexpr int kNoNamespace = 77;
template <typename Body>
int InEmptyNetwork(const Body& body) {
  const pid_t pid = fork();
  if (pid == 0) {
    _exit(test::EnterEmptyNetwork() ? body() : kNoNamespace);
  }
  int status = 0;
  waitpid(pid, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

// Two runs side by side, and a third beside a program that merely talks at the usual port.
TEST(ChooseTransport, KeepsRunsApart) {
  const int code = InEmptyNetwork([] {
    if (!test::AddRouteForLcm()) return kNoNamespace;
    unsetenv("LCM_DEFAULT_URL");
    TransportOptions options;
    options.multicast_port = 17667;
    options.test_timeout = std::chrono::seconds(30);
    const Transport first = ChooseTransport(options);
    if (first.url != MulticastUrl(17667) || !first.explanation.empty()) return 1;
    Transport second = ChooseTransport(options);
    if (second.url != MulticastUrl(17668) || second.explanation.empty()) return 2;
    second = Transport();
    if (ChooseTransport(options).url != MulticastUrl(17668)) return 3;

    options.multicast_port = 17700;
    options.listen_time = std::chrono::seconds(30);
    std::atomic<bool> done{false};
    std::thread talker([&] {
      lcm::LCM lcm(MulticastUrl(17700));
      while (!done && lcm.publish("ANY", "x", 1) == 0) usleep(1000);
    });
    TransportOptions brief = options;
    brief.multicast_port = 17701;
    brief.listen_time = std::chrono::milliseconds(1);
    const bool silent = ChooseTransport(brief).url == MulticastUrl(17701);
    // Listening ends as soon as somebody is heard; what is silent costs the whole time.
    options.listen_time = std::chrono::seconds(2);
    const std::string url = ChooseTransport(options).url;
    done = true;
    talker.join();
    return silent && url == MulticastUrl(17701) ? 0 : 4;
  });
  if (code == kNoNamespace) GTEST_SKIP() << "no network namespaces here";
  EXPECT_EQ(code, 0);
}

TEST(TestMulticast, FailsWithAReasonWhereThereIsNoRoute) {
  const int code = InEmptyNetwork([] {
    const MulticastTest test = TestMulticast();
    return test.works ? 1 : test.reason.empty() ? 2 : 0;
  });
  if (code == kNoNamespace) GTEST_SKIP() << "no network namespaces here";
  EXPECT_EQ(code, 0);
}

TEST(TestMulticast, WorksOnceMended) {
  const int code = InEmptyNetwork([] {
    if (!test::AddRouteForLcm()) return kNoNamespace;
    return TestMulticast(std::chrono::seconds(30)).works ? 0 : 1;
  });
  if (code == kNoNamespace) GTEST_SKIP() << "no network namespaces here";
  EXPECT_EQ(code, 0);
}

}  // namespace
}  // namespace vantage
