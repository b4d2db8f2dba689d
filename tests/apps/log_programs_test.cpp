// What the programs that read logs print, and their exit codes.

#include <algorithm>
#include <filesystem>

#include <gtest/gtest.h>

#include "../replay/recorded_cell.h"
#include "contains.h"
#include "program.h"
#include "temporary_folder.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;
using test::Contains;

class LogPrograms : public ::testing::Test {
 protected:
  static std::vector<LoggedEvent> Recorded() {
    static const std::vector<LoggedEvent> events = test::RecordedCell("planar-good-view").Run(300);
    return events;
  }
  std::string Log(const std::vector<LoggedEvent>& events) {
    const std::string path = (folder_.path() / "log.lcm").string();
    test::WriteLog(events, path);
    return path;
  }
  test::TemporaryFolder folder_;
};

TEST_F(LogPrograms, ReplaySaysThatAllIsReproduced) {
  const auto run = test::RunProgram(VANTAGE_SERVO " --replay " + Log(Recorded()));
  EXPECT_EQ(run.exit_code, 0) << run.output;
  EXPECT_TRUE(Contains(run.output, "planar-good-view (test 1.0, camera active): 300 periods"))
      << run.output;
  EXPECT_TRUE(Contains(run.output, "\n  reproduced to 1e-09\n")) << run.output;
}

TEST_F(LogPrograms, ReplaySaysWhatDiffersFirst) {
  auto events = Recorded();
  int seen = 0;
  for (LoggedEvent& event : events) {
    if (event.channel != kJointCommandChannel || ++seen != 200) continue;
    JointCommand command;
    ASSERT_EQ(Decode(event.data.data(), event.data.size(), &command), Refusal::kNone);
    command.qdot(1) = 0.123;
    Encode(command, &event.data);
  }
  const auto run = test::RunProgram(VANTAGE_SERVO " --replay " + Log(events));
  EXPECT_EQ(run.exit_code, 1) << run.output;
  EXPECT_TRUE(Contains(run.output, "first difference at t = 0.400"));
  EXPECT_TRUE(Contains(run.output, "JOINT_COMMAND.velocity[1] was 0.123, is ")) << run.output;
  EXPECT_TRUE(Contains(run.output, "NOT reproduced")) << run.output;
  // With a tolerance that wide it is the same.
  EXPECT_EQ(test::RunProgram(VANTAGE_SERVO " --tolerance 1 --replay " + Log(events)).exit_code, 0);
}

TEST_F(LogPrograms, WhatIsNoLogIsOneLineAndExitCodeTwo) {
  const std::string text = folder_.Write("text", "not a log");
  for (const std::string& program :
       {std::string(VANTAGE_SERVO " --replay "), std::string(VANTAGE_REPORT " ")}) {
    const auto run = test::RunProgram(program + text);
    EXPECT_EQ(run.exit_code, 2) << run.output;
    EXPECT_TRUE(Contains(run.output, "is not an LCM event log")) << run.output;
    EXPECT_EQ(std::count(run.output.begin(), run.output.end(), '\n'), 1) << run.output;
  }
}

TEST_F(LogPrograms, ReportNamesTheFilesItWrote) {
  const std::string out = (folder_.path() / "out").string();
  const auto run =
      test::RunProgram(VANTAGE_REPORT " --no-csv --out " + out + " " + Log(Recorded()));
  EXPECT_EQ(run.exit_code, 0) << run.output;
  EXPECT_TRUE(Contains(run.output, out + "/report.html\n")) << run.output;
  EXPECT_TRUE(fs::exists(out + "/report.html"));
  EXPECT_TRUE(fs::exists(out + "/report/error.svg"));
}

TEST_F(LogPrograms, ReportOfALogThatWasCutOffSaysSo) {
  const std::string log = Log(Recorded());
  fs::resize_file(log, fs::file_size(log) - 7);
  const auto run = test::RunProgram(VANTAGE_REPORT " --no-csv " + log);
  EXPECT_EQ(run.exit_code, 0) << run.output;
  EXPECT_TRUE(Contains(run.output, "the log was cut off or damaged")) << run.output;
}

TEST_F(LogPrograms, ReportOfAScenarioThatIsNoneIsExitCodeTwo) {
  const auto run = test::RunProgram(VANTAGE_REPORT " --scenario nonsense " + Log(Recorded()));
  EXPECT_EQ(run.exit_code, 2) << run.output;
}

}  // namespace
}  // namespace vantage
