#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include <sys/types.h>

#include "vantage/math/time.h"

namespace vantage {

/// How a process ended.
struct ExitStatus {
  int code{0};    ///< Exit code, when signal is 0.
  int signal{0};  ///< Signal that ended it, or 0.

  [[nodiscard]] bool success() const noexcept { return code == 0 && signal == 0; }
  /// "exit code 2" or "signal 9 (Killed)".
  [[nodiscard]] std::string ToString() const;
};

/// What to run, and how.
struct ChildOptions {
  std::vector<std::string> arguments;  ///< Program (searched in PATH) and its arguments.
  std::map<std::string, std::string> environment;  ///< Added to, or replacing, the parent's.
  std::string output;  ///< File that stdout and stderr are appended to; empty: the parent's.
  /// A process group of its own: Ctrl-C in the terminal reaches the parent alone, which then stops its
  /// children in order.
  bool own_group{true};
};

/// A program that this one started. It gets SIGTERM when its parent dies, however that happens, and
/// is terminated and reaped when this object goes.
class ChildProcess {
 public:
  /// Starts the program. Throws Error when there is none of that name or it cannot be started, with
  /// the system's reason. The child is told of the parent's death by the end of the THREAD that
  /// called this (Linux's rule): call it from a thread that lives as long as the program.
  explicit ChildProcess(const ChildOptions& options);
  /// Terminate(2 s).
  ~ChildProcess();
  ChildProcess(ChildProcess&& other) noexcept;
  ChildProcess& operator=(ChildProcess&&) = delete;
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  [[nodiscard]] pid_t pid() const noexcept { return pid_; }
  [[nodiscard]] const std::string& name() const noexcept { return name_; }

  /// How it ended; nullopt while it runs. Does not wait. Reaps.
  [[nodiscard]] std::optional<ExitStatus> Poll();
  /// Waits for its end, at most `timeout`.
  [[nodiscard]] std::optional<ExitStatus> WaitFor(Duration timeout);
  /// Sends a signal; false when the process has ended.
  bool Signal(int signal);
  /// SIGTERM, and SIGKILL when it still runs after `grace`. Returns how it ended.
  ExitStatus Terminate(Duration grace);

 private:
  std::string name_;
  pid_t pid_{-1};
  std::optional<ExitStatus> status_;
};

}  // namespace vantage
