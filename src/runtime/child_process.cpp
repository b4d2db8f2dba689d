#include "vantage/runtime/child_process.h"

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <thread>
#include <utility>

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "vantage/math/error.h"

namespace vantage {
namespace {

// The parent's environment with the changes, as "NAME=value".
std::vector<std::string> MergedEnvironment(const std::map<std::string, std::string>& changes) {
  std::vector<std::string> merged;
  for (char** entry = environ; entry != nullptr && *entry != nullptr; ++entry) {
    const std::string text(*entry);
    if (changes.count(text.substr(0, text.find('='))) == 0) merged.push_back(text);
  }
  for (const auto& [name, value] : changes) merged.push_back(name + "=" + value);
  return merged;
}

std::vector<char*> Pointers(std::vector<std::string>* strings) {
  std::vector<char*> pointers;
  pointers.reserve(strings->size() + 1);
  for (std::string& text : *strings) pointers.push_back(text.data());
  pointers.push_back(nullptr);
  return pointers;
}

// What exec is to try for the program, PATH searched here: the child of a threaded process may call
// little more than exec itself.
std::vector<std::string> Candidates(const std::string& program) {
  if (program.find('/') != std::string::npos) return {program};
  const char* variable = std::getenv("PATH");
  const std::string path = variable != nullptr ? variable : "/usr/local/bin:/usr/bin:/bin";
  std::vector<std::string> candidates;
  for (std::size_t begin = 0; begin <= path.size();) {
    const std::size_t end = std::min(path.find(':', begin), path.size());
    const std::string folder = path.substr(begin, end - begin);
    candidates.push_back(folder.empty() ? "./" : folder + '/');
    candidates.back() += program;
    begin = end + 1;
  }
  return candidates;
}

// Runs in the child, between fork and exec: async-signal-safe calls alone. Returns errno.
int BecomeProgram(const std::vector<const char*>& candidates, char* const* arguments,
                  char* const* environment, int output, bool own_group, pid_t parent) noexcept {
  if (own_group) setpgid(0, 0);
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (getppid() != parent) _exit(1);  // It died before prctl().
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGPIPE, SIGCHLD}) {
    std::signal(signal, SIG_DFL);
  }
  if (output >= 0) {
    if (dup2(output, STDOUT_FILENO) < 0 || dup2(output, STDERR_FILENO) < 0) return errno;
  }
  int error = ENOENT;
  for (const char* candidate : candidates) {
    execve(candidate, arguments, environment);
    // As execvp does: a file that may not be run is worth more of a message than one not there.
    if (errno != ENOENT && errno != ENOTDIR) error = errno;
    if (error != ENOENT && error != EACCES) break;
  }
  return error;
}

// The errno that the child wrote before it gave up; 0 when exec closed the pipe.
int ReadStartError(int fd) {
  int error = 0;
  ssize_t got = 0;
  do {
    got = read(fd, &error, sizeof(error));
  } while (got < 0 && errno == EINTR);
  return got == sizeof(error) ? error : 0;
}

ExitStatus FromWaitStatus(int status) {
  ExitStatus result;
  if (WIFSIGNALED(status)) {
    result.signal = WTERMSIG(status);
  } else {
    result.code = WEXITSTATUS(status);
  }
  return result;
}

}  // namespace

std::string ExitStatus::ToString() const {
  if (signal == 0) return "exit code " + std::to_string(code);
  return "signal " + std::to_string(signal) + " (" + strsignal(signal) + ")";
}

ChildProcess::ChildProcess(const ChildOptions& options) {
  if (options.arguments.empty()) throw Error("no program to start");
  name_ = options.arguments.front();
  std::vector<std::string> arguments = options.arguments;
  std::vector<std::string> environment = MergedEnvironment(options.environment);
  const std::vector<std::string> candidates = Candidates(name_);
  std::vector<const char*> candidate_pointers;
  candidate_pointers.reserve(candidates.size());
  for (const std::string& candidate : candidates) candidate_pointers.push_back(candidate.c_str());
  const std::vector<char*> argument_pointers = Pointers(&arguments);
  const std::vector<char*> environment_pointers = Pointers(&environment);

  int output = -1;
  if (!options.output.empty()) {
    output = open(options.output.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
    if (output < 0) throw Error(options.output + ": " + std::strerror(errno));
  }
  int start_error[2];
  if (pipe2(start_error, O_CLOEXEC) != 0) {
    const int error = errno;
    if (output >= 0) close(output);
    throw Error(name_ + ": " + std::strerror(error));
  }
  const pid_t parent = getpid();
  const pid_t pid = fork();
  if (pid == 0) {
    const int error = BecomeProgram(candidate_pointers, argument_pointers.data(),
                                    environment_pointers.data(), output, options.own_group, parent);
    if (write(start_error[1], &error, sizeof(error)) < 0) _exit(126);
    _exit(127);
  }
  const int fork_error = errno;
  close(start_error[1]);
  if (output >= 0) close(output);
  const int error = pid < 0 ? fork_error : ReadStartError(start_error[0]);
  close(start_error[0]);
  if (error != 0) {
    if (pid > 0) waitpid(pid, nullptr, 0);
    throw Error(name_ + ": " + std::strerror(error));
  }
  pid_ = pid;
}

ChildProcess::ChildProcess(ChildProcess&& other) noexcept
    : name_(std::move(other.name_)), pid_(other.pid_), status_(other.status_) {
  other.pid_ = -1;
}

ChildProcess::~ChildProcess() {
  if (pid_ > 0) Terminate(std::chrono::seconds(2));
}

std::optional<ExitStatus> ChildProcess::Poll() {
  if (status_ || pid_ <= 0) return status_;
  int status = 0;
  pid_t ended = 0;
  do {
    ended = waitpid(pid_, &status, WNOHANG);
  } while (ended < 0 && errno == EINTR);
  if (ended == pid_) status_ = FromWaitStatus(status);
  // Somebody else reaped it: all that can be said is that it is gone.
  if (ended < 0) status_ = ExitStatus{-1, 0};
  return status_;
}

std::optional<ExitStatus> ChildProcess::WaitFor(Duration timeout) {
  const Time until = Clock::now() + timeout;
  while (!Poll() && Clock::now() < until) std::this_thread::sleep_for(std::chrono::milliseconds(2));
  return Poll();
}

bool ChildProcess::Signal(int signal) {
  if (pid_ <= 0 || Poll()) return false;
  return kill(pid_, signal) == 0;
}

ExitStatus ChildProcess::Terminate(Duration grace) {
  if (pid_ <= 0) return {};
  if (Signal(SIGTERM)) {
    // A stopped process cannot react to SIGTERM.
    Signal(SIGCONT);
    if (!WaitFor(grace)) Signal(SIGKILL);
  }
  while (!WaitFor(std::chrono::seconds(1))) {
  }
  return *status_;
}

}  // namespace vantage
