// vantage-bench as a process.

#include <filesystem>
#include <iterator>

#include <gtest/gtest.h>

#include "program.h"
#include "read_file.h"
#include "temporary_folder.h"

namespace vantage {
namespace {

const std::string kBench = VANTAGE_BENCH;

// The same seeds give the same file, bit for bit, however many threads play them; on pixels and projected.
TEST(Bench, TheSameSeedsGiveTheSameFile) {
  const test::TemporaryFolder folder;
  for (const std::string model : {"", " --kinematic"}) {
    for (const std::string jobs : {"1", "3"}) {
      const test::ProgramRun run =
          test::RunProgram(kBench + " --suite S1/planar2 --seeds 4 --quiet --jobs " + jobs + model +
                           " --json " + (folder.path() / (jobs + ".json")).string());
      ASSERT_EQ(run.exit_code, 0) << run.output;
    }
    const std::string one = test::ReadFile(folder.path() / "1.json");
    EXPECT_GT(one.size(), 500U);
    EXPECT_EQ(one, test::ReadFile(folder.path() / "3.json")) << model;
  }
}

std::ptrdiff_t FoldersIn(const std::filesystem::path& path) {
  return std::distance(std::filesystem::directory_iterator(path),
                       std::filesystem::directory_iterator());
}

// A sequence is replayed goal by goal, as the suite plays it.
TEST(Bench, ReplaysASequenceGoalByGoal) {
  const test::TemporaryFolder folder;
  const test::ProgramRun run = test::RunProgram(
      kBench + " --replay sequence/planar2 2 --kinematic --quiet --out " + folder.path().string());
  ASSERT_EQ(run.exit_code, 0) << run.output;
  EXPECT_EQ(FoldersIn(folder.path()), 10);
}

// A goal that moves is followed to the end of its time.
TEST(Bench, ReplaysAGoalThatMovesToTheEnd) {
  const test::TemporaryFolder folder;
  const test::ProgramRun run = test::RunProgram(
      kBench + " --replay follow/puma560 1 --kinematic --quiet --out " + folder.path().string());
  ASSERT_EQ(run.exit_code, 0) << run.output;
  ASSERT_EQ(FoldersIn(folder.path()), 1);
  const auto left = std::filesystem::directory_iterator(folder.path())->path();
  EXPECT_NE(test::ReadFile(left / "summary.json").find("\"control_periods\": 12000"),
            std::string::npos);
}

}  // namespace
}  // namespace vantage
