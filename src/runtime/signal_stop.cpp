#include "vantage/runtime/signal_stop.h"

#include <algorithm>
#include <cerrno>
#include <cstdint>

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

namespace vantage {
namespace {

// Signal handlers reach globals only.
std::atomic<bool> stop_requested{false};
std::atomic<int> stop_signal{0};
std::atomic<int> wake_fd{-1};
static_assert(std::atomic<bool>::is_always_lock_free && std::atomic<int>::is_always_lock_free,
              "the handler may use lock-free atomics only");

void SetFlag(int signal) noexcept {
  const int saved_errno = errno;
  int none = 0;
  stop_signal.compare_exchange_strong(none, signal);
  stop_requested.store(true);
  const int fd = wake_fd.load();
  const std::uint64_t one = 1;
  if (fd >= 0 && write(fd, &one, sizeof(one)) < 0) {
    // The counter is full: whoever waits is awake already.
  }
  errno = saved_errno;
}

extern "C" void VantageOnStopSignal(int signal) {
  SetFlag(signal);
}

}  // namespace

SignalStop::SignalStop() {
  stop_requested.store(false);
  stop_signal.store(0);
  wake_fd.store(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK));
  struct sigaction action {};
  action.sa_handler = VantageOnStopSignal;
  sigemptyset(&action.sa_mask);
  // No SA_RESTART: a sleeping loop shall wake. SA_RESETHAND: the second signal ends the process.
  action.sa_flags = static_cast<int>(SA_RESETHAND);
  sigaction(SIGINT, &action, &old_int_);
  sigaction(SIGTERM, &action, &old_term_);
}

SignalStop::~SignalStop() {
  sigaction(SIGINT, &old_int_, nullptr);
  sigaction(SIGTERM, &old_term_, nullptr);
  const int fd = wake_fd.exchange(-1);
  if (fd >= 0) close(fd);
}

const std::atomic<bool>& SignalStop::flag() const noexcept {
  return stop_requested;
}

int SignalStop::signal() const noexcept {
  return stop_signal.load();
}

void SignalStop::Request() noexcept {
  SetFlag(0);
}

bool SignalStop::WaitFor(Duration timeout) const noexcept {
  const Time until = Clock::now() + timeout;
  while (!stopped()) {
    const Duration left = until - Clock::now();
    if (left <= Duration::zero()) return false;
    pollfd wake{wake_fd.load(), POLLIN, 0};
    const auto ms = std::chrono::ceil<std::chrono::milliseconds>(left).count();
    poll(&wake, 1, static_cast<int>(std::min<std::int64_t>(ms, 1000)));
  }
  return true;
}

}  // namespace vantage
