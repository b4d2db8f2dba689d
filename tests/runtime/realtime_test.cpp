#include "vantage/runtime/realtime.h"

#include <functional>
#include <thread>

#include <gtest/gtest.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace vantage {
namespace {

RealtimeOptions Nothing() {
  RealtimeOptions options;
  options.priority = 0;
  options.lock_memory = false;
  options.stack = 0;
  return options;
}

TEST(EnterRealtime, LeavesAloneWhatIsNotAskedFor) {
  const RealtimeReport report = EnterRealtime(Nothing());
  EXPECT_TRUE(report.complete());
  EXPECT_FALSE(report.fifo || report.pinned || report.locked);
}

TEST(EnterRealtime, PinsTheThread) {
  cpu_set_t allowed;
  ASSERT_EQ(sched_getaffinity(0, sizeof(allowed), &allowed), 0);
  int cpu = 0;
  while (!CPU_ISSET(cpu, &allowed)) ++cpu;
  std::thread([&] {
    RealtimeOptions options = Nothing();
    options.cpus = {cpu};
    const RealtimeReport report = EnterRealtime(options);
    EXPECT_TRUE(report.pinned) << report.message;
    cpu_set_t now;
    ASSERT_EQ(sched_getaffinity(0, sizeof(now), &now), 0);
    EXPECT_EQ(CPU_COUNT(&now), 1);
    EXPECT_TRUE(CPU_ISSET(cpu, &now));
  }).join();
}

TEST(EnterRealtime, NamesACoreThatIsNotThere) {
  for (const int cpu : {-1, 1023, CPU_SETSIZE}) {
    RealtimeOptions options = Nothing();
    options.cpus = {cpu};
    const RealtimeReport report = EnterRealtime(options);
    EXPECT_FALSE(report.pinned);
    EXPECT_NE(report.message.find("core " + std::to_string(cpu)), std::string::npos)
        << report.message;
  }
}

// Runs `body` in a child process that may neither lock memory nor use real-time priorities; the exit
// code is what body returns.
int InPowerlessProcess(const std::function<int()>& body) {
  const pid_t pid = fork();
  if (pid == 0) {
    const rlimit none{0, 0};
    setrlimit(RLIMIT_RTPRIO, &none);
    setrlimit(RLIMIT_MEMLOCK, &none);
    if (getuid() == 0 && setuid(65534) != 0) _exit(100);
    _exit(body());
  }
  int status = 0;
  waitpid(pid, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 101;
}

TEST(EnterRealtime, SaysWhatToGrantWhenPriorityIsRefused) {
  EXPECT_EQ(InPowerlessProcess([] {
              RealtimeOptions options = Nothing();
              options.priority = 80;
              const RealtimeReport report = EnterRealtime(options);
              if (report.fifo || report.complete()) return 1;
              return report.message.find("rtprio 80") == std::string::npos ? 2 : 0;
            }),
            0);
}

TEST(EnterRealtime, SaysWhatToGrantWhenLockingIsRefused) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers turn mlockall() into a function that does nothing";
#endif
  EXPECT_EQ(InPowerlessProcess([] {
              RealtimeOptions options = Nothing();
              options.lock_memory = true;
              const RealtimeReport report = EnterRealtime(options);
              if (report.locked || report.complete()) return 1;
              return report.message.find("memlock") == std::string::npos ? 2 : 0;
            }),
            0);
}

// Granted or refused is the machine's choice; the report must tell which.
TEST(EnterRealtime, ReportsTheTruthAboutThePriority) {
  std::thread([] {
    RealtimeOptions options = Nothing();
    options.priority = 10;
    options.stack = 64 * 1024;
    const RealtimeReport report = EnterRealtime(options);
    EXPECT_EQ(report.fifo, sched_getscheduler(0) == SCHED_FIFO);
    EXPECT_EQ(report.fifo, report.complete()) << report.message;
  }).join();
}

}  // namespace
}  // namespace vantage
