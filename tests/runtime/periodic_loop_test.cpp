#include "vantage/runtime/periodic_loop.h"

#include <thread>
#include <vector>

#include <gtest/gtest.h>

namespace vantage {
namespace {

using std::chrono::milliseconds;

TEST(LatestDeadline, StaysOnTheGrid) {
  const Time start = FromMicroseconds(1'000'000);
  const Duration period = milliseconds(2);
  EXPECT_EQ(LatestDeadline(start, period, start), start);
  EXPECT_EQ(LatestDeadline(start, period, start + milliseconds(1)), start);
  EXPECT_EQ(LatestDeadline(start, period, start + milliseconds(2)), start + milliseconds(2));
  EXPECT_EQ(LatestDeadline(start, period, start + milliseconds(9)), start + milliseconds(8));
}

TEST(RunPeriodic, StopsAtTheFlagAndCounts) {
  std::atomic<bool> stop{false};
  int calls = 0;
  const LoopReport report = RunPeriodic(milliseconds(1), stop, [&] { stop = ++calls == 20; });
  EXPECT_EQ(calls, 20);
  EXPECT_EQ(report.cycles, 20);
  EXPECT_EQ(report.execution.count(), 20);
  EXPECT_EQ(report.lateness.count(), 20);
}

TEST(RunPeriodic, DoesNothingWhenStoppedBefore) {
  const std::atomic<bool> stop{true};
  EXPECT_EQ(RunPeriodic(milliseconds(1), stop, [] { FAIL(); }).cycles, 0);
}

// However late the machine wakes the loop, its deadlines are start + i * period, and none begins early.
TEST(RunPeriodic, KeepsAnAbsoluteGrid) {
  std::atomic<bool> stop{false};
  const Duration period = milliseconds(1);
  std::vector<Time> deadlines;
  RunPeriodic(period, stop, [&](const LoopCycle& cycle) {
    deadlines.push_back(cycle.deadline);
    EXPECT_GE(cycle.begin, cycle.deadline);
    stop = deadlines.size() == 50;
  });
  for (const Time deadline : deadlines) {
    EXPECT_EQ((deadline - deadlines.front()) % period, Duration::zero());
  }
  for (std::size_t i = 1; i < deadlines.size(); ++i) EXPECT_GT(deadlines[i], deadlines[i - 1]);
}

// Each rehearsal belongs to the period after it, which may have several; a period that is due already has none.
TEST(RunPeriodic, RehearsesAheadOfEachDeadline) {
  std::atomic<bool> stop{false};
  const Duration period = milliseconds(4);
  const Duration lead = milliseconds(2);
  std::vector<Time> deadlines, rehearsed;
  Time late{};  // the deadline that a rehearsal was overtaken by: the machine was busy
  const auto rehearse = [&](Time deadline) {
    EXPECT_GE(Clock::now(), deadline - lead);
    EXPECT_TRUE(deadlines.empty() || deadlines.back() < deadline);
    EXPECT_NE(late, deadline) << "one more after its period was due";
    if (Clock::now() >= deadline) late = deadline;
    rehearsed.push_back(deadline);
  };
  RunPeriodic(
      period, stop,
      [&](const LoopCycle& cycle) {
        EXPECT_GE(cycle.begin, cycle.deadline);
        deadlines.push_back(cycle.deadline);
        if (deadlines.size() == 10) std::this_thread::sleep_for(2 * period);
        stop = deadlines.size() == 20;
      },
      Rehearsal<decltype(rehearse)>{lead, rehearse});
  EXPECT_GT(rehearsed.size(), deadlines.size());
  std::size_t next = 0;
  for (const Time deadline : rehearsed) {
    while (next < deadlines.size() && deadlines[next] != deadline) ++next;
    EXPECT_LT(next, deadlines.size());
    EXPECT_NE(next, 10U);
  }
}

TEST(RunPeriodic, CountsAnOverrunAndDoesNotBurst) {
  std::atomic<bool> stop{false};
  const Duration period = milliseconds(5);
  std::vector<Time> deadlines;
  std::int64_t misses_after_overrun = 0;
  const LoopReport report = RunPeriodic(period, stop, [&](const LoopCycle& cycle) {
    deadlines.push_back(cycle.deadline);
    if (deadlines.size() == 1) std::this_thread::sleep_for(milliseconds(23));
    if (deadlines.size() == 2) misses_after_overrun = cycle.report.deadline_misses;
    stop = deadlines.size() == 3;
  });
  ASSERT_EQ(deadlines.size(), 3U);
  // 23 ms cover the four deadlines at 5, 10, 15 and 20 ms; the newest of them runs.
  EXPECT_GE(misses_after_overrun, 4);
  EXPECT_EQ(deadlines[1] - deadlines[0], misses_after_overrun * period);
  EXPECT_GE(report.worst_cycle, milliseconds(23));
  EXPECT_GE(report.deadline_misses, misses_after_overrun);
}

}  // namespace
}  // namespace vantage
