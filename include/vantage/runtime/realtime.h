#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace vantage {

/// What a thread asks of the system to keep its period.
struct RealtimeOptions {
  int priority{80};        ///< SCHED_FIFO priority, 1-99; 0 leaves the scheduler alone.
  std::vector<int> cpus;   ///< Cores the thread may run on; empty leaves the affinity alone.
  bool lock_memory{true};  ///< mlockall(): no page of the process is ever fetched from disk again.
  std::size_t stack{262'144};  ///< Bytes of stack touched beforehand, 1 MiB at most; 0: none.
};

/// What the system granted.
struct RealtimeReport {
  bool fifo{false};    ///< Runs under SCHED_FIFO. False also where that was not asked for.
  bool pinned{false};  ///< Runs on the cores asked for and no others. False also where none were.
  bool locked{false};  ///< All pages of the process stay in memory. False also where not asked for.

  /// One line for each thing that was refused, with what to grant; empty when all was granted.
  std::string message;

  [[nodiscard]] bool complete() const noexcept { return message.empty(); }
};

/// Prepares the CALLING thread. Start threads that do I/O before: a thread inherits the scheduler of
/// the one that makes it. Nothing is fatal: what is refused is named in the report and left out.
[[nodiscard]] RealtimeReport EnterRealtime(const RealtimeOptions& options);

}  // namespace vantage
