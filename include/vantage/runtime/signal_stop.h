#pragma once

#include <atomic>
#include <csignal>

#include "vantage/math/time.h"

namespace vantage {

/// While it lives, SIGINT and SIGTERM set a flag instead of ending the process. The second signal of
/// a kind ends the process as by default, so that a program that hangs can still be stopped. One
/// instance at a time; make it before any thread.
class SignalStop {
 public:
  SignalStop();
  ~SignalStop();
  SignalStop(const SignalStop&) = delete;
  SignalStop& operator=(const SignalStop&) = delete;

  /// True once a signal came. Real-time safe to read.
  [[nodiscard]] const std::atomic<bool>& flag() const noexcept;
  [[nodiscard]] bool stopped() const noexcept { return flag().load(std::memory_order_relaxed); }
  /// The signal that came, or 0.
  [[nodiscard]] int signal() const noexcept;

  /// Sets the flag as a signal would: the program's own wish to stop. Any thread.
  void Request() noexcept;

  /// Waits until the flag is set, at most `timeout`. True when it is set. One thread at a time.
  [[nodiscard]] bool WaitFor(Duration timeout) const noexcept;

 private:
  struct sigaction old_int_ {};
  struct sigaction old_term_ {};
};

}  // namespace vantage
