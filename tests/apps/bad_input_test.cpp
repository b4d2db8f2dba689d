// What every program does with what it cannot use: one line that names the mend, and an exit code.

#include <algorithm>
#include <filesystem>
#include <ostream>

#include <gtest/gtest.h>

#include "contains.h"
#include "program.h"
#include "temporary_folder.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;
using test::Contains;

test::ProgramRun Start(const std::string& command) {
  return test::RunProgram(VANTAGE_BIN "/" + command);
}

const std::vector<std::string>& Programs() {
  static const std::vector<std::string> programs{
      "vantage-run",   "vantage-servo", "vantage-sim",     "vantage-camera",
      "vantage-plan",  "vantage-map",   "vantage-measure", "vantage-report",
      "vantage-bench", "vantage-watch", "vantage-config",  "vantage-panda-bridge"};
  return programs;
}

TEST(EveryProgram, HasHelpWithItsExitCodesAndAVersion) {
  for (const std::string& program : Programs()) {
    const auto help = Start(program + " --help");
    EXPECT_EQ(help.exit_code, 0) << program;
    EXPECT_TRUE(Contains(help.output, "Usage: " + program)) << help.output;
    EXPECT_TRUE(Contains(help.output, "Exit codes: 0 done, ")) << help.output;
    const auto version = Start(program + " --version");
    EXPECT_EQ(version.exit_code, 0) << program;
    EXPECT_EQ(version.output.rfind("vantage ", 0), 0u) << version.output;
  }
}

struct BadInput {
  const char* command;
  int code;
  const char* says;
};

void PrintTo(const BadInput& bad, std::ostream* out) {
  *out << bad.command;
}

class OneLine : public ::testing::TestWithParam<BadInput> {};

TEST_P(OneLine, AndAnExitCode) {
  const test::TemporaryFolder folder;
  folder.Write("text", "no log, no table, no folder");
  folder.Write("bad.yaml", "a: [1, 2\nb: 3");
  fs::create_directory(folder.path() / "dir");
  const BadInput& bad = GetParam();
  const auto run = test::RunProgram("cd " + folder.path().string() +
                                    " && export PATH=" VANTAGE_BIN ":$PATH; " + bad.command);
  EXPECT_EQ(run.exit_code, bad.code) << run.output;
  EXPECT_TRUE(Contains(run.output, bad.says)) << run.output;
  EXPECT_EQ(std::count(run.output.begin(), run.output.end(), '\n'), 1) << run.output;
  // Nothing was left behind.
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), fs::directory_iterator()), 3);
}

INSTANTIATE_TEST_SUITE_P(
    BadInput, OneLine,
    ::testing::Values(
        BadInput{"vantage-run --no-such-option", 2,
                 "vantage-run: The following argument was not expected"},
        BadInput{"vantage-run nothing", 2, "'nothing' is neither a file nor built in"},
        BadInput{"vantage-run none.yaml", 2, "none.yaml: cannot be opened: No such file"},
        BadInput{"vantage-run dir", 2, "dir: is a directory"},
        BadInput{"vantage-run bad.yaml", 2, "bad.yaml:2: not valid YAML"},
        BadInput{"vantage-run --seed -1", 2, "must be a whole number, 0 or more, is -1"},
        BadInput{"vantage-run --out text", 2, "--out: text: Not a directory"},
        BadInput{"LCM_DEFAULT_URL=nonsense vantage-run", 2, "must begin with udpm://"},
        BadInput{"(vantage-run --list > /dev/full)", 3, "cannot write the output: No space left"},
        BadInput{"vantage-servo --replay none", 2, "none: cannot be opened: No such file"},
        BadInput{"vantage-servo --cpus 99 nothing", 2, "'nothing' is neither a file nor built in"},
        BadInput{"vantage-report dir", 2, "dir: is a directory"},
        BadInput{"vantage-camera --source dir planar-good-view", 2, "dir/%05d.png"},
        BadInput{"vantage-plan nothing", 2, "nor a built-in scenario"},
        BadInput{"vantage-plan --quiet --grid-check 5000 puma560-base", 2,
                 "--grid-check: puma560-base is a sweep"},
        BadInput{"vantage-plan --quiet --out text fig5-arm", 2, "--out: text: Not a directory"},
        BadInput{"vantage-map --out text fig3", 2, "--out: text: Not a directory"},
        BadInput{"vantage-measure bad.yaml", 2, "bad.yaml:2: not valid YAML"},
        BadInput{"(vantage-measure planar2 > /dev/full)", 3, "cannot write the output"},
        BadInput{"vantage-bench --json dir", 2, "--json: cannot write dir"},
        BadInput{"vantage-bench --replay S4/planar2 x", 2, "--replay: the seed must be a number"},
        BadInput{"vantage-config check problem bad.yaml", 2, "bad.yaml:2: not valid YAML"},
        BadInput{"vantage-config list nonsense", 2, "nonsense not in {scenario,robot"}));

TEST(Config, ChecksEveryFileWhateverTheOnesBeforeHold) {
  const auto run = Start("vantage-config check robot planar2 nothing ur5");
  EXPECT_EQ(run.exit_code, 2) << run.output;
  for (const char* part : {"planar2: good", "'nothing' is neither", "ur5: good"}) {
    EXPECT_TRUE(Contains(run.output, part)) << run.output;
  }
}

// A built-in file is where a file of one's own begins.
TEST(Config, WhatItListsAndShowsItChecks) {
  const test::TemporaryFolder folder;
  for (const std::string kind : {"scenario", "robot", "measure", "recipe", "problem"}) {
    const auto list = Start("vantage-config list " + kind);
    ASSERT_EQ(list.exit_code, 0) << list.output;
    const std::string name = list.output.substr(0, list.output.find('\n'));
    const auto shown = Start("vantage-config show " + kind + " " + name);
    ASSERT_EQ(shown.exit_code, 0) << shown.output;
    const std::string path = folder.Write(name + ".yaml", shown.output);
    const auto check = Start("vantage-config check " + kind + " " + path);
    EXPECT_EQ(check.exit_code, 0) << check.output;
    EXPECT_EQ(check.output.rfind(path + ": good\n", 0), 0u) << check.output;
  }
}

// The numbers are there even if the picture is not.
TEST(Map, LeavesItsTableWhereGnuplotIsMissing) {
  const test::TemporaryFolder folder;
  const auto run =
      test::RunProgram("cd " + folder.path().string() +
                       " && PATH= " VANTAGE_BIN "/vantage-map fig3 --samples 5 5 --out .");
  EXPECT_EQ(run.exit_code, 3) << run.output;
  EXPECT_TRUE(Contains(run.output, "./fig3.csv\n")) << run.output;
  EXPECT_TRUE(Contains(run.output, "apt-get install gnuplot-nox")) << run.output;
  EXPECT_TRUE(fs::exists(folder.path() / "fig3.csv"));
}

}  // namespace
}  // namespace vantage
