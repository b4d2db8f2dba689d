#include "vantage/runtime/periodic_loop.h"

#include <ctime>

namespace vantage {

void SleepUntil(Time deadline) noexcept {
  // libstdc++'s steady_clock is CLOCK_MONOTONIC.
  const std::int64_t ns = deadline.time_since_epoch().count();
  timespec until{};
  until.tv_sec = static_cast<time_t>(ns / 1'000'000'000);
  until.tv_nsec = static_cast<long>(ns % 1'000'000'000);
  clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr);
}

Time LatestDeadline(Time deadline, Duration period, Time now) noexcept {
  const auto whole_periods = (now - deadline) / period;
  return deadline + whole_periods * period;
}

}  // namespace vantage
