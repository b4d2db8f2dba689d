#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <type_traits>

#include "vantage/math/time.h"
#include "vantage/runtime/histogram.h"

/// @file
/// A loop on absolute deadlines: period i begins at start + i * period, however long the ones before
/// took, so that the rate does not drift.

namespace vantage {

/// How a periodic loop has fared.
struct LoopReport {
  std::int64_t cycles{0};  ///< Periods that ran.
  /// Periods that began late, or were left out, because the one before ended after their deadline.
  std::int64_t deadline_misses{0};
  Duration worst_cycle{0};      ///< Longest execution of the body.
  Duration worst_lateness{0};   ///< Largest delay between a deadline and the begin of its period.
  Duration last_cycle{0};       ///< Execution of the last body.
  DurationHistogram execution;  ///< Of the body, all periods.
  DurationHistogram lateness;   ///< Begin of each period after its deadline.
};

/// What the body of a loop can know of its period.
struct LoopCycle {
  Time deadline;             ///< When this period was to begin: the loop's own time axis.
  Time begin;                ///< When it did begin.
  const LoopReport& report;  ///< Of the periods before this one.
};

/// Sleeps until `deadline` on the monotonic clock; returns earlier when a signal handler ran.
/// Real-time safe.
void SleepUntil(Time deadline) noexcept;

/// Latest of deadline, deadline + period, deadline + 2 period, ... that is not after `now`.
/// @pre now >= deadline, period > 0.
[[nodiscard]] Time LatestDeadline(Time deadline, Duration period, Time now) noexcept;

/// What a loop does ahead of each deadline: it wakes so much earlier and calls body(deadline), again and again while
/// there is time, so that the period finds its code and data in the caches and its core at work. Once is not enough:
/// a machine that is shared takes the core away in between, and gives it back with cold caches. It costs processor
/// time, `lead` of each period.
template <typename Body>
struct Rehearsal {
  Duration lead{0};  ///< >= 0, < the loop's period; 0: no rehearsal.
  /// Must take less than half of lead, and may be called more than once for one deadline.
  Body body{};
};

/// Calls body() or body(const LoopCycle&) each period until `stop` is true. After an overrun the
/// newest period that is due begins at once and the older ones are left out: no burst, and the grid
/// of deadlines stays.
///
/// @param period     > 0.
/// @param stop       Read before each period; a signal handler may set it.
/// @param rehearsal  Nothing, or what to do ahead of each period.
/// Real-time safe as far as body and rehearsal are.
template <typename Body, typename Rehearse = void (*)(Time)>
LoopReport RunPeriodic(Duration period, const std::atomic<bool>& stop, Body&& body,
                       const Rehearsal<Rehearse>& rehearsal = {}) {
  LoopReport report;
  Time deadline = Clock::now();
  // What a rehearsal takes, on average over the last few.
  constexpr int kFew = 8;
  Duration usual = rehearsal.lead / 16;
  while (!stop.load(std::memory_order_relaxed)) {
    const Time begin = Clock::now();
    if (begin < deadline) {
      if (begin < deadline - rehearsal.lead) {
        SleepUntil(deadline - rehearsal.lead);
      } else if (begin < deadline - 2 * usual) {  // later it would only delay the period
        rehearsal.body(deadline);
        usual += (Clock::now() - begin - usual) / kFew;
      }
      continue;  // after the last one: awake until the deadline
    }
    if constexpr (std::is_invocable_v<Body&, const LoopCycle&>) {
      body(LoopCycle{deadline, begin, report});
    } else {
      body();
    }
    const Time end = Clock::now();

    ++report.cycles;
    report.last_cycle = end - begin;
    report.worst_cycle = std::max(report.worst_cycle, report.last_cycle);
    report.worst_lateness = std::max<Duration>(report.worst_lateness, begin - deadline);
    report.execution.Add(report.last_cycle);
    report.lateness.Add(begin - deadline);

    const Time next = deadline + period;
    deadline = end > next ? LatestDeadline(next, period, end) : next;
    if (end > next) report.deadline_misses += 1 + (deadline - next) / period;
  }
  return report;
}

}  // namespace vantage
