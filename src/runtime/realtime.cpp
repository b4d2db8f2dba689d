#include "vantage/runtime/realtime.h"

#include <algorithm>
#include <cerrno>
#include <cstring>

#include <alloca.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>

namespace vantage {
namespace {

void AddLine(const std::string& what, int error, const std::string& grant, std::string* message) {
  if (!message->empty()) *message += '\n';
  *message += what + " refused (" + std::strerror(error) + "): " + grant;
}

// Writes to every page of the stack that the period may grow into, so that it never faults there.
// Not inlined: the pages must lie below the caller's frame.
[[gnu::noinline]] void TouchStack(std::size_t bytes) {
  constexpr std::size_t kPage = 4096;
  auto* stack = static_cast<volatile char*>(alloca(bytes));
  for (std::size_t i = 0; i < bytes; i += kPage) stack[i] = 0;
}

std::string ListOf(const std::vector<int>& cpus) {
  std::string list;
  for (const int cpu : cpus) list += (list.empty() ? "" : ",") + std::to_string(cpu);
  return list;
}

// 0, or the errno of the refusal.
int Pin(const std::vector<int>& cpus) {
  cpu_set_t set;
  CPU_ZERO(&set);
  for (const int cpu : cpus) {
    if (cpu < 0 || cpu >= CPU_SETSIZE) return EINVAL;
    CPU_SET(cpu, &set);
  }
  return pthread_setaffinity_np(pthread_self(), sizeof(set), &set);
}

}  // namespace

RealtimeReport EnterRealtime(const RealtimeOptions& options) {
  RealtimeReport report;
  if (options.lock_memory) {
    report.locked = mlockall(MCL_CURRENT | MCL_FUTURE) == 0;
    if (!report.locked) {
      AddLine("memory locking", errno,
              "grant 'memlock unlimited' in /etc/security/limits.d/, or the capability "
              "cap_ipc_lock",
              &report.message);
    }
  }
  // Bounded: the main thread's stack is 8 MiB by default, other threads may have less.
  TouchStack(std::min<std::size_t>(options.stack, std::size_t{1} << 20));
  if (!options.cpus.empty()) {
    const int error = Pin(options.cpus);
    report.pinned = error == 0;
    if (error != 0) {
      AddLine("affinity to core " + ListOf(options.cpus), error,
              "name cores this process may use (see taskset -p $$)", &report.message);
    }
  }
  // Last: nothing above is to run at real-time priority.
  if (options.priority > 0) {
    sched_param parameters{};
    parameters.sched_priority = options.priority;
    const int error = pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters);
    report.fifo = error == 0;
    if (error != 0) {
      AddLine("SCHED_FIFO priority " + std::to_string(options.priority), error,
              "grant 'rtprio " + std::to_string(options.priority) +
                  "' in /etc/security/limits.d/, or the capability cap_sys_nice (in a container: "
                  "--cap-add=SYS_NICE)",
              &report.message);
    }
  }
  return report;
}

}  // namespace vantage
