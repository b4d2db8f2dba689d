#include "vantage/runtime/child_process.h"

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <fstream>

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include "becomes_true.h"
#include "read_file.h"
#include "temporary_folder.h"
#include "vantage/math/error.h"

namespace vantage {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using test::BecomesTrue;
using test::kPatience;

ChildOptions Shell(const std::string& script) {
  ChildOptions options;
  options.arguments = {"sh", "-c", script};
  return options;
}

// A process that has died may linger as a zombie of init or of a subreaper: that counts as gone.
bool IsAlive(pid_t pid) {
  std::ifstream stat("/proc/" + std::to_string(pid) + "/stat");
  std::string line;
  if (!std::getline(stat, line)) return false;
  const std::size_t state = line.rfind(')') + 2;
  return state < line.size() && line[state] != 'Z' && line[state] != 'X';
}

TEST(ChildProcess, ReportsTheExitCode) {
  ChildProcess child(Shell("exit 3"));
  const auto status = child.WaitFor(kPatience);
  ASSERT_TRUE(status);
  EXPECT_EQ(status->code, 3);
  EXPECT_EQ(status->signal, 0);
  EXPECT_FALSE(status->success());
  EXPECT_EQ(status->ToString(), "exit code 3");
}

TEST(ChildProcess, ReportsTheSignal) {
  ChildProcess child(Shell("kill -9 $$"));
  const auto status = child.WaitFor(kPatience);
  ASSERT_TRUE(status);
  EXPECT_EQ(status->signal, SIGKILL);
  EXPECT_EQ(status->ToString(), "signal 9 (Killed)");
}

TEST(ChildProcess, PollDoesNotWait) {
  ChildProcess child(Shell("exec sleep 60"));
  EXPECT_FALSE(child.Poll());
  EXPECT_FALSE(child.WaitFor(milliseconds(5)));
}

TEST(ChildProcess, ThrowsWhenThereIsNoSuchProgram) {
  ChildOptions options;
  options.arguments = {"vantage-no-such-program"};
  try {
    const ChildProcess child(options);
    FAIL();
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(), "vantage-no-such-program: No such file or directory");
  }
}

TEST(ChildProcess, ThrowsWhenTheFileIsNotAProgram) {
  const test::TemporaryFolder folder;
  const std::string file = folder.Write("no_program", "");
  ChildOptions options;
  options.arguments = {file};
  try {
    const ChildProcess child(options);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.what(), file + ": Permission denied");
  }
}

TEST(ChildProcess, ThrowsWhenTheOutputCannotBeWritten) {
  ChildOptions options = Shell("true");
  options.output = "/vantage-no-such-folder/log";
  EXPECT_THROW(const ChildProcess child(options), Error);
}

TEST(ChildProcess, TerminatesAtOnceWhatObeys) {
  ChildProcess child(Shell("exec sleep 60"));
  EXPECT_EQ(child.Terminate(kPatience).signal, SIGTERM);
}

TEST(ChildProcess, KillsWhatDoesNotObey) {
  const test::TemporaryFolder folder;
  const std::string ready = (folder.path() / "ready").string();
  ChildProcess child(
      Shell("trap '' TERM; echo ready > " + ready + "; while :; do sleep 0.01; done"));
  ASSERT_TRUE(BecomesTrue([&] { return test::ReadFile(ready) == "ready\n"; }));
  EXPECT_EQ(child.Terminate(milliseconds(50)).signal, SIGKILL);
}

TEST(ChildProcess, TerminatesAStoppedProcess) {
  ChildProcess child(Shell("exec sleep 60"));
  ASSERT_TRUE(child.Signal(SIGSTOP));
  EXPECT_EQ(child.Terminate(kPatience).signal, SIGTERM);
}

TEST(ChildProcess, TerminateTellsHowItHadEnded) {
  ChildProcess child(Shell("exit 4"));
  ASSERT_TRUE(child.WaitFor(kPatience));
  EXPECT_FALSE(child.Signal(SIGTERM));
  EXPECT_EQ(child.Terminate(seconds(1)).code, 4);
}

TEST(ChildProcess, EndsAndReapsWithTheObject) {
  pid_t pid = 0;
  {
    const ChildProcess child(Shell("exec sleep 60"));
    pid = child.pid();
    EXPECT_EQ(kill(pid, 0), 0);
  }
  EXPECT_EQ(kill(pid, 0), -1);
  EXPECT_EQ(errno, ESRCH);
}

TEST(ChildProcess, PassesEnvironmentAndCollectsOutput) {
  const test::TemporaryFolder folder;
  const std::string log = (folder.path() / "log").string();
  setenv("VANTAGE_TEST_KEPT", "kept", 1);
  setenv("VANTAGE_TEST_REPLACED", "old", 1);
  ChildOptions options = Shell("echo $VANTAGE_TEST_KEPT $VANTAGE_TEST_REPLACED; echo error >&2");
  options.environment = {{"VANTAGE_TEST_REPLACED", "new"}};
  options.output = log;
  ChildProcess child(options);
  ASSERT_TRUE(child.WaitFor(kPatience));
  EXPECT_EQ(test::ReadFile(log), "kept new\nerror\n");
}

TEST(ChildProcess, HasItsOwnProcessGroupUnlessToldOtherwise) {
  const ChildProcess own(Shell("exec sleep 60"));
  EXPECT_EQ(getpgid(own.pid()), own.pid());
  ChildOptions options = Shell("exec sleep 60");
  options.own_group = false;
  const ChildProcess shared(options);
  EXPECT_EQ(getpgid(shared.pid()), getpgid(0));
}

// The parent is killed and cannot tidy up: its child goes all the same.
TEST(ChildProcess, DiesWithItsParent) {
  int pids[2];
  ASSERT_EQ(pipe(pids), 0);
  const pid_t parent = fork();
  if (parent == 0) {
    const ChildProcess child(Shell("exec sleep 60"));
    const pid_t pid = child.pid();
    if (write(pids[1], &pid, sizeof(pid)) != sizeof(pid)) _exit(1);
    kill(getpid(), SIGKILL);
  }
  pid_t child = 0;
  ASSERT_EQ(read(pids[0], &child, sizeof(child)), static_cast<ssize_t>(sizeof(child)));
  close(pids[0]);
  close(pids[1]);
  int status = 0;
  waitpid(parent, &status, 0);
  ASSERT_TRUE(WIFSIGNALED(status));
  EXPECT_TRUE(BecomesTrue([&] { return !IsAlive(child); })) << "process " << child;
}

}  // namespace
}  // namespace vantage
