#include "plan_grid.h"

#include <algorithm>
#include <sstream>

#include <gtest/gtest.h>

#include "config_error.h"
#include "program.h"
#include "read_file.h"
#include "temporary_folder.h"

namespace vantage::test {
namespace {

// Several blocks.
constexpr std::int64_t kCameras = 60000;

const char* const kHidden =
    "scenario: puma3-bad-view\n"
    "motion: {samples: 16}\n"
    "search: {grid: 256, starts: 4, generations: 6, polished: 1}\n";
const char* const kOpen =
    "scenario: puma560-bad-view\n"
    "motion: {samples: 16}\n"
    "limits: {occlusion: false}\n"
    "search: {grid: 256, starts: 4, generations: 6, polished: 1}\n";

PlacementSetup SetupOf(const std::string& text) {
  return ReadPlacement({"cell.yaml", "", text}, "cell");
}

class PlanGrid : public ::testing::Test {
 protected:
  [[nodiscard]] std::string File(const std::string& name) const {
    return (folder_.path() / name).string();
  }
  // The tables of all shards, the last first.
  [[nodiscard]] std::vector<std::string> Tables(const PlacementSetup& setup, int parts,
                                                std::int64_t cameras = kCameras) const {
    const PlacementModel model(setup.problem);
    std::vector<std::string> paths;
    for (int i = parts; i >= 1; --i) {
      paths.push_back(File(std::to_string(i) + "_of_" + std::to_string(parts)));
      WriteGridTable(paths.back(), setup, {i, parts}, SearchGrid(model, cameras, {i, parts}));
    }
    return paths;
  }
  // The table of the first shard of two with line `number` replaced.
  [[nodiscard]] std::string Spoilt(const PlacementSetup& setup, int number,
                                   const std::string& by) const {
    std::istringstream in(ReadFile(Tables(setup, 2, 2000).back()));
    std::string text, line;
    for (int at = 1; std::getline(in, line); ++at) text += (at == number ? by : line) + "\n";
    return folder_.Write("spoilt", text);
  }

  const TemporaryFolder folder_;
};

TEST_F(PlanGrid, OfShardsMergedIsTheSameToTheLastBit) {
  for (const char* text : {kHidden, kOpen}) {
    const PlacementSetup setup = SetupOf(text);
    const PlacementModel model(setup.problem);
    ASSERT_EQ(model.problem().limits.occlusion, text == kHidden);
    const PlacedCamera result = PlaceCamera(model, setup.search).best;
    ASSERT_TRUE(result.feasible);
    const GridCheck check = CheckAgainstGrid(model, result, kCameras);
    ASSERT_TRUE(check.best.feasible);
    for (const int parts : {1, 3, 7}) {
      const SearchedGrid merged = ReadGridTables(Tables(setup, parts), setup);
      const GridCheck joined = FinishGridCheck(model, result, merged);
      EXPECT_EQ(joined.cameras, kCameras);
      EXPECT_EQ(joined.best_on_grid, check.best_on_grid) << parts << " parts";
      EXPECT_EQ(joined.best.q_c, check.best.q_c) << parts << " parts";
      EXPECT_EQ(joined.gap, check.gap) << parts << " parts";
      // What was merged is, as a table, that of the undivided grid.
      WriteGridTable(File("merged"), setup, {1, 1}, merged);
      WriteGridTable(File("whole"), setup, {1, 1}, SearchGrid(model, kCameras, {1, 1}));
      EXPECT_EQ(ReadFile(File("merged")), ReadFile(File("whole"))) << parts << " parts";
    }
  }
}

TEST_F(PlanGrid, OfBlocksInAnyOrderIsTheSameTable) {
  const PlacementSetup setup = SetupOf(kHidden);
  const PlacementModel model(setup.problem);
  const auto backwards = [](auto items, const auto& work, const auto& take) {
    for (auto item = items.rbegin(); item != items.rend(); ++item) take(*item, work(*item));
  };
  WriteGridTable(File("forwards"), setup, {}, SearchGrid(model, kCameras, {}));
  WriteGridTable(File("backwards"), setup, {}, SearchGrid(model, kCameras, {}, {}, backwards));
  EXPECT_EQ(ReadFile(File("backwards")), ReadFile(File("forwards")));
}

TEST_F(PlanGrid, TellsTheShareAndTheBestSoFar) {
  const PlacementSetup setup = SetupOf(kHidden);
  const PlacementModel model(setup.problem);
  std::vector<double> shares, values;
  const SearchedGrid grid =
      SearchGrid(model, kCameras, {}, [&](const auto&, double share, const auto& best) {
        shares.push_back(share);
        values.push_back(best.value_or(-INFINITY));
      });
  ASSERT_EQ(shares.size(), static_cast<std::size_t>(GridSearch::BlocksOf(kCameras)));
  EXPECT_TRUE(std::is_sorted(shares.begin(), shares.end()));
  EXPECT_EQ(shares.back(), 1.0);
  EXPECT_TRUE(std::is_sorted(values.begin(), values.end()));
  EXPECT_EQ(values.back(), grid.best.ValueOfBest(model));
}

TEST_F(PlanGrid, OfMissingDoubleOrForeignTablesIsRefused) {
  const PlacementSetup setup = SetupOf(kHidden);
  const auto error_of = [&](const std::vector<std::string>& paths) {
    return ConfigErrorOf([&] { (void)ReadGridTables(paths, setup); });
  };
  const std::vector<std::string> two = Tables(setup, 2, 2000);
  EXPECT_EQ(error_of({two[0]}), "--merge: part 1 of 2 is in none of the tables");
  EXPECT_EQ(error_of({two[0], two[1], two[0]}), two[0] + ":1: part 2 is there twice");
  EXPECT_EQ(error_of({two[0], Tables(setup, 3, 2000)[2]}),
            File("1_of_3") + ":1: is one of 3 parts, the first table of 2");
  const std::string fewer = Tables(setup, 4, 1000)[0];
  EXPECT_EQ(error_of({two[0], fewer}),
            fewer + ":1: is of a grid of 1000 cameras, the first table of 2000");
  const std::string foreign = Tables(SetupOf(kOpen), 5, 2000)[0];
  EXPECT_EQ(error_of({two[0], foreign}), foreign + ":1: is of another problem than cell");
  EXPECT_EQ(error_of({File("nothing")}), File("nothing") + ": cannot be opened");
}

TEST_F(PlanGrid, OfADamagedTableNamesTheLine) {
  const PlacementSetup setup = SetupOf(kHidden);
  const auto error_of = [&](int number, const std::string& by) {
    return ConfigErrorOf([&] { (void)ReadGridTables({Spoilt(setup, number, by)}, setup); });
  };
  const std::string file = File("spoilt");
  EXPECT_EQ(error_of(1, "# vantage-plan sweep of cell, problem 1, 6 items"),
            file + ":1: is no table of a grid check");
  const std::string title = "# vantage-plan grid check of cell, problem " +
                            std::to_string(setup.fingerprint) + ", 2000 cameras";
  EXPECT_EQ(error_of(1, title), file + ":1: is no first line of a grid check");
  EXPECT_EQ(error_of(1, title + ", part 3 of 2, 1 kept"),
            file + ":1: is no first line of a grid check");
  EXPECT_EQ(error_of(2, "camera,score"), file + ":2: must be 'camera,cell,score'");
  for (const char* wrong : {"", "1,2", "1,2,x", "1,2,nan", "1,2,3,4", "-1,2,3", "2000,2,3"}) {
    EXPECT_EQ(error_of(4, wrong), file + ":4: is no line of a grid check") << wrong;
  }
  EXPECT_EQ(error_of(1, title + ", part 1 of 1, 9999 kept").find(file + ": has "), 0u);
}

std::string GridCheckLineOf(const std::string& plan) {
  const std::string text = ReadFile(plan);
  const std::size_t at = text.find("  grid_check:");
  return at == std::string::npos ? "" : text.substr(at, text.find('\n', at) - at);
}

TEST_F(PlanGrid, OfTheProgramIsTheSameInOneAndInParts) {
  const std::string problem = folder_.Write("cell.yaml", kHidden);
  const auto run = [&](const std::string& arguments) {
    return RunProgram(VANTAGE_BIN "/vantage-plan " + arguments);
  };
  const std::string grid = problem + " --grid-check 60000 --no-pictures";
  const ProgramRun whole = run(grid + " --out " + File("whole"));
  ASSERT_EQ(whole.exit_code, 0) << whole.output;
  for (const char* shard : {"1/2", "2/2"}) {
    const ProgramRun part = run(grid + " --out " + File("parts") + " --shard " + shard);
    ASSERT_EQ(part.exit_code, 0) << part.output;
    EXPECT_NE(part.output.find("of 2 of a grid of 60000 cameras: the best is worth"),
              std::string::npos)
        << part.output;
  }
  const std::string tables = File("parts") + "/cell_grid_1_of_2.csv " + File("parts") +
                             "/cell_grid_2_of_2.csv --no-pictures --out " + File("merged");
  const ProgramRun merged = run(problem + " --merge " + tables);
  ASSERT_EQ(merged.exit_code, 0) << merged.output;
  const std::string line = GridCheckLineOf(File("whole") + "/cell_plan.yaml");
  EXPECT_NE(line.find("cameras: 60000"), std::string::npos) << line;
  EXPECT_EQ(GridCheckLineOf(File("merged") + "/cell_plan.yaml"), line);

  const ProgramRun alone = run("--merge " + tables);
  EXPECT_EQ(alone.exit_code, 2);
  EXPECT_NE(alone.output.find("PROBLEM --merge FILES"), std::string::npos) << alone.output;
  const ProgramRun foreign = run("fig5-arm --merge " + tables);
  EXPECT_EQ(foreign.exit_code, 2);
  EXPECT_NE(foreign.output.find("is of another problem than fig5-arm"), std::string::npos)
      << foreign.output;
  const ProgramRun useless = run(problem + " --shard 1/2 --out " + File("none"));
  EXPECT_EQ(useless.exit_code, 2);
  EXPECT_NE(useless.output.find("only a sweep or a --grid-check can be cut"), std::string::npos)
      << useless.output;
}

#ifdef VANTAGE_MPIRUN
TEST_F(PlanGrid, UnderMpiIsTheSameToTheLastBit) {
  const std::string problem = folder_.Write("cell.yaml", kHidden);
  const std::string rest = problem + " --no-pictures --grid-check 60000 --out ";
  const ProgramRun two = RunProgram(std::string(VANTAGE_MPIRUN) +
                                    " -n 2 " VANTAGE_BIN "/vantage-plan-mpi " + rest + File("two"));
  ASSERT_EQ(two.exit_code, 0) << two.output;
  const ProgramRun one = RunProgram(VANTAGE_BIN "/vantage-plan " + rest + File("one"));
  ASSERT_EQ(one.exit_code, 0) << one.output;
  const std::string line = GridCheckLineOf(File("one") + "/cell_plan.yaml");
  EXPECT_NE(line.find("cameras: 60000"), std::string::npos) << line;
  EXPECT_EQ(GridCheckLineOf(File("two") + "/cell_plan.yaml"), line);
}

TEST_F(PlanGrid, UnderMpiOfAProblemWithoutAnswerEnds) {
  // No camera is so far away: rank 0 has no result to check, and the others nothing to wait for.
  const std::string problem =
      folder_.Write("cell.yaml", std::string(kHidden) + "limits: {min_depth: 80, max_depth: 90}\n");
  const ProgramRun run =
      RunProgram(std::string(VANTAGE_MPIRUN) + " -n 2 " VANTAGE_BIN "/vantage-plan-mpi " + problem +
                 " --grid-check 60000 --out " + File("out"));
  EXPECT_EQ(run.exit_code, 1) << run.output;
  EXPECT_NE(run.output.find("no camera of the rig keeps all limits"), std::string::npos)
      << run.output;
}
#endif

}  // namespace
}  // namespace vantage::test
