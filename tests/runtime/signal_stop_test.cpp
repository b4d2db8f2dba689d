#include "vantage/runtime/signal_stop.h"

#include <thread>

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

namespace vantage {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

TEST(SignalStop, SetsTheFlagOnEitherSignal) {
  for (const int signal : {SIGINT, SIGTERM}) {
    const SignalStop stop;
    EXPECT_FALSE(stop.stopped());
    EXPECT_EQ(stop.signal(), 0);
    raise(signal);
    EXPECT_TRUE(stop.stopped());
    EXPECT_EQ(stop.signal(), signal);
  }
}

TEST(SignalStop, RestoresTheHandlers) {
  struct sigaction before {};
  struct sigaction after {};
  sigaction(SIGTERM, nullptr, &before);
  {
    const SignalStop stop;
    sigaction(SIGTERM, nullptr, &after);
    EXPECT_NE(after.sa_handler, before.sa_handler);
  }
  sigaction(SIGTERM, nullptr, &after);
  EXPECT_EQ(after.sa_handler, before.sa_handler);
}

TEST(SignalStop, WaitEndsAtTheTimeout) {
  const SignalStop stop;
  EXPECT_FALSE(stop.WaitFor(milliseconds(5)));
}

TEST(SignalStop, RequestWakesTheWaiter) {
  SignalStop stop;
  std::thread requester([&] { stop.Request(); });
  EXPECT_TRUE(stop.WaitFor(seconds(60)));
  requester.join();
  EXPECT_EQ(stop.signal(), 0);
}

TEST(SignalStop, SecondSignalEndsTheProcess) {
  const pid_t pid = fork();
  if (pid == 0) {
    const SignalStop stop;
    raise(SIGTERM);
    if (!stop.stopped()) _exit(1);
    raise(SIGTERM);
    _exit(2);
  }
  int status = 0;
  waitpid(pid, &status, 0);
  ASSERT_TRUE(WIFSIGNALED(status)) << status;
  EXPECT_EQ(WTERMSIG(status), SIGTERM);
}

}  // namespace
}  // namespace vantage
