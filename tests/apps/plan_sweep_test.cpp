#include "plan_sweep.h"

#include <stdexcept>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "config_error.h"
#include "program.h"
#include "read_file.h"
#include "temporary_folder.h"

namespace vantage::test {
namespace {

const char* const kProblem =
    "scenario: puma3-bad-view\n"
    "motion: {samples: 16}\n"
    "search: {grid: 256, starts: 4, generations: 6, polished: 1}\n"
    "sweep: {base: {x: {from: -0.2, to: 0.2, samples: 3}, yaw: {from_deg: 0, to_deg: 90, samples: "
    "2}}}\n";

PlacementSetup SetupOf(const std::string& text) {
  return ReadPlacement({"sweep.yaml", "", text}, "sweep");
}

TEST(PlanSweep, OfShardsMergedIsTheSameToTheLastBit) {
  const TemporaryFolder folder;
  const auto file = [&](const std::string& name) { return (folder.path() / name).string(); };
  const PlacementSetup setup = SetupOf(kProblem);
  ASSERT_EQ(setup.sweep.size(), 6);
  RunSweep(setup, {1, 1}, file("whole"));
  std::vector<std::string> parts;
  for (int i = 3; i >= 1; --i) {
    parts.push_back(file("part" + std::to_string(i)));
    RunSweep(setup, {i, 3}, parts.back());
  }
  MergeSweeps(parts, file("merged"));
  EXPECT_EQ(ReadFile(file("merged")), ReadFile(file("whole")));
  EXPECT_NE(BestOfSweep(file("merged"), 1).find("value"), std::string::npos);
}

TEST(PlanSweep, OfMissingDoubleOrForeignPartsIsRefused) {
  const TemporaryFolder folder;
  const auto file = [&](const std::string& name) { return (folder.path() / name).string(); };
  const PlacementSetup setup = SetupOf(kProblem);
  RunSweep(setup, {1, 6}, file("a"));
  RunSweep(setup, {2, 6}, file("b"));
  const auto merge = [&](const std::vector<std::string>& parts) {
    return ConfigErrorOf([&] { MergeSweeps(parts, file("out")); });
  };
  EXPECT_NE(merge({file("a"), file("b")}).find("item 2 is in none"), std::string::npos);
  EXPECT_NE(merge({file("a"), file("a")}).find("twice"), std::string::npos);
  RunSweep(SetupOf(std::string(kProblem) + "limits: {min_depth: 0.4}\n"), {2, 6}, file("foreign"));
  EXPECT_NE(merge({file("a"), file("foreign")}).find("another problem"), std::string::npos);
}

TEST(PlanSweep, MovesTheArmAndNotTheCamera) {
  const PlacementSetup setup = SetupOf(kProblem);
  const PlacementProblem moved = ProblemAt(setup.sweep, 5);  // x = 0.2, yaw = 90 degrees
  const Eigen::Vector3d p = setup.problem.motion.samples[3].markers[0].p_W;
  const Eigen::Vector3d expected(0.2 - p.y(), p.x(), p.z());
  EXPECT_LT((moved.motion.samples[3].markers[0].p_W - expected).norm(), 1e-12);
  EXPECT_EQ(moved.rig.target_W, setup.problem.rig.target_W);
}

// Two motions and two rigs of one cell.
const char* const kCases =
    "scenario: puma3-bad-view\n"
    "motion: {samples: 16}\n"
    "search: {grid: 256, starts: 4, generations: 6, polished: 1}\n"
    "sweep:\n"
    "  base: {z: {from: 0, to: 0.05, samples: 2}}\n"
    "  cases:\n"
    "    - {name: as it is}\n"
    "    - name: another motion\n"
    "      motion: {samples: 16, joints: [{at: [0.2, 0.4, -0.7]}, {at: [0.5, 0.2, -0.5]}]}\n"
    "    - name: from nearer\n"
    "      limits: {max_depth: 1.2}\n";

TEST(PlanSweep, OfCasesTakesEachCasesKeysForTheProblems) {
  const TemporaryFolder folder;
  const PlacementSetup setup = SetupOf(kCases);
  ASSERT_EQ(setup.sweep.size(), 6);
  ASSERT_EQ(setup.sweep.cases.size(), 3u);
  const auto& cases = setup.sweep.cases;
  EXPECT_EQ(setup.sweep.CaseOf(3).name, "another motion");
  EXPECT_NEAR(setup.sweep.BaseOf(3).shift.z(), 0.05, 1e-15);
  EXPECT_NEAR(cases[1].problem.motion.samples.front().q(0), 0.2, 1e-12);
  EXPECT_EQ(cases[2].problem.limits.depth.max, 1.2);
  EXPECT_NE(cases[0].problem.limits.depth.max, 1.2);
  EXPECT_EQ(cases[0].problem.motion.samples.back().q, cases[2].problem.motion.samples.back().q);

  const std::string path = (folder.path() / "table").string();
  RunSweep(setup, {1, 1}, path);
  EXPECT_NE(ReadFile(path).find("\n3,another motion,0,0,0.05"), std::string::npos)
      << ReadFile(path);
}

TEST(PlanSweep, NamesWhatIsWrongWithACase) {
  const auto error_of = [](const std::string& sweep) {
    return ConfigErrorOf([&] { (void)SetupOf("scenario: puma3-bad-view\nsweep:\n" + sweep); });
  };
  const auto expect = [&](const std::string& sweep, const std::string& says) {
    EXPECT_NE(error_of(sweep).find(says), std::string::npos) << error_of(sweep);
  };
  expect("  cases: []\n", "needs base, cases or both");
  expect("  cases:\n    - {limits: {max_depht: 1}}\n", "sweep.yaml:4: limits.max_depht");
  expect("  cases:\n    - {motino: {}}\n",
         "sweep.yaml:4: motino: unknown key; did you mean 'motion'?");
  expect("  cases:\n    - {search: {}}\n",
         "sweep.yaml:4: sweep.cases[0].search: is not for a case to say");
  expect("  cases:\n    - {name: 'a,b'}\n", "must be without commas");
  expect("  cases:\n    - {name: a}\n  bse: {}\n", "sweep.bse: unknown key; did you mean 'base'?");
}

TEST(PlanSweep, OfResultsInAnyOrderIsTheSameTable) {
  const TemporaryFolder folder;
  const auto file = [&](const std::string& name) { return (folder.path() / name).string(); };
  const PlacementSetup setup = SetupOf(kProblem);
  RunSweep(setup, {1, 1}, file("in order"));
  RunSweep(setup, {1, 1}, file("backwards"), Begin::kAnew, {},
           [](auto items, const auto& work, const auto& take) {
             for (auto item = items.rbegin(); item != items.rend(); ++item)
               take(*item, work(*item));
           });
  EXPECT_EQ(ReadFile(file("backwards")), ReadFile(file("in order")));
}

// Works out no more than `most` items, as if it had been interrupted then.
DealItems Interrupted(int most, std::vector<int>* worked) {
  return [most, worked](const auto& items, const auto& work, const auto& take) {
    for (const int item : items) {
      if (static_cast<int>(worked->size()) >= most) throw std::runtime_error("interrupted");
      take(item, work(item));
      worked->push_back(item);
    }
  };
}

TEST(PlanSweep, GoesOnWhereItWasInterrupted) {
  const TemporaryFolder folder;
  const auto file = [&](const std::string& name) { return (folder.path() / name).string(); };
  const PlacementSetup setup = SetupOf(kProblem);
  RunSweep(setup, {1, 1}, file("whole"));
  std::vector<int> first;
  EXPECT_THROW(RunSweep(setup, {1, 1}, file("cut"), {}, {}, Interrupted(2, &first)),
               std::runtime_error);
  // The machine went down in the middle of a line.
  const std::string header_and_two = ReadFile(file("cut"));
  const std::string whole = ReadFile(file("whole"));
  ASSERT_EQ(whole.rfind(header_and_two, 0), 0U);
  folder.Write("cut", whole.substr(0, header_and_two.size() + 9));
  std::vector<int> rest;
  EXPECT_EQ(RunSweep(setup, {1, 1}, file("cut"), {}, {}, Interrupted(9, &rest)), 2);
  EXPECT_EQ(rest, (std::vector<int>{2, 3, 4, 5}));
  EXPECT_EQ(ReadFile(file("cut")), whole);
  // What is complete stays; anew means anew; another seed is another sweep.
  std::vector<int> none;
  EXPECT_EQ(RunSweep(setup, {1, 1}, file("cut"), {}, {}, Interrupted(0, &none)), 6);
  std::vector<int> all;
  EXPECT_EQ(RunSweep(setup, {1, 1}, file("cut"), Begin::kAnew, {}, Interrupted(9, &all)), 0);
  EXPECT_EQ(all.size(), 6U);
  PlacementSetup other = setup;
  other.search.seed += 1;
  std::vector<int> with_seed;
  EXPECT_EQ(RunSweep(other, {1, 1}, file("cut"), {}, {}, Interrupted(9, &with_seed)), 0);
  EXPECT_EQ(with_seed.size(), 6U);
}

TEST(PlanSweep, OfALineThatIsCutOffIsNotMerged) {
  const TemporaryFolder folder;
  const std::string path = (folder.path() / "table").string();
  RunSweep(SetupOf(kProblem), {1, 1}, path);
  const std::string whole = ReadFile(path);
  for (const std::size_t missing : {1, 3, 40}) {
    folder.Write("torn", whole.substr(0, whole.size() - missing));
    const std::string error = ConfigErrorOf([&] {
      MergeSweeps({(folder.path() / "torn").string()}, (folder.path() / "out").string());
    });
    EXPECT_NE(error.find("torn:8: is cut off"), std::string::npos) << missing << " " << error;
  }
}

#ifdef VANTAGE_MPIRUN
// A second run finds all items in the table, and nothing is left to deal.
TEST(PlanSweep, UnderMpiGoesOnWhereItWasInterrupted) {
  const TemporaryFolder folder;
  folder.Write("sweep.yaml", kCases);
  const std::string command =
      std::string(VANTAGE_MPIRUN) + " -n 2 " VANTAGE_BIN "/vantage-plan-mpi " +
      (folder.path() / "sweep.yaml").string() + " --out " + folder.path().string();
  ASSERT_EQ(RunProgram(command).exit_code, 0);
  const std::string whole = ReadFile((folder.path() / "sweep_sweep.csv").string());
  for (const std::size_t kept : {whole.size(), whole.size() / 2}) {
    folder.Write("sweep_sweep.csv", whole.substr(0, kept));
    const ProgramRun again = RunProgram(command);
    EXPECT_EQ(again.exit_code, 0) << again.output;
    EXPECT_NE(again.output.find("items were in the table already"), std::string::npos)
        << again.output;
    EXPECT_EQ(ReadFile((folder.path() / "sweep_sweep.csv").string()), whole);
  }
}

TEST(PlanSweep, UnderMpiIsTheSameToTheLastBit) {
  const TemporaryFolder folder;
  folder.Write("sweep.yaml", kCases);
  const std::string problem = (folder.path() / "sweep.yaml").string();
  const std::string out = (folder.path() / "two").string();
  const ProgramRun two =
      RunProgram(std::string(VANTAGE_MPIRUN) + " -n 2 " VANTAGE_BIN "/vantage-plan-mpi " + problem +
                 " --out " + out);
  ASSERT_EQ(two.exit_code, 0) << two.output;
  const ProgramRun one = RunProgram(VANTAGE_BIN "/vantage-plan " + problem + " --out " +
                                    (folder.path() / "one").string());
  ASSERT_EQ(one.exit_code, 0) << one.output;
  EXPECT_EQ(ReadFile(out + "/sweep_sweep.csv"),
            ReadFile((folder.path() / "one" / "sweep_sweep.csv").string()));
}

TEST(PlanSweep, UnderMpiWantsWorkToShareAndTheRightProgram) {
  const std::string mpirun = std::string(VANTAGE_MPIRUN) + " -n 2 " VANTAGE_BIN;
  const ProgramRun single = RunProgram(mpirun + "/vantage-plan-mpi fig5-arm");
  EXPECT_NE(single.exit_code, 0);
  EXPECT_NE(single.output.find("only a sweep or a --grid-check can be dealt out to 2 ranks"),
            std::string::npos)
      << single.output;
  const ProgramRun without = RunProgram(mpirun + "/vantage-plan puma560-base");
  EXPECT_NE(without.exit_code, 0);
  EXPECT_NE(without.output.find("start vantage-plan-mpi"), std::string::npos) << without.output;
}

// Rank 0 would deal the work out, and waits for all who take part in it.
TEST(PlanSweep, UnderMpiNobodyWaitsForARankThatCannotBegin) {
  const TemporaryFolder folder;
  folder.Write("sweep.yaml", kCases);
  const std::string good = (folder.path() / "sweep.yaml").string();
  for (const char* failing : {"0", "1"}) {
    const ProgramRun run = RunProgram(
        "timeout 60 env " + std::string(VANTAGE_MPIRUN) + " -n 2 sh -c 'problem=" + good +
        "; [ $OMPI_COMM_WORLD_RANK != " + failing + " ] || problem=no-such-problem; exec " +
        VANTAGE_BIN "/vantage-plan-mpi $problem --out " + (folder.path() / failing).string() + "'");
    EXPECT_EQ(run.exit_code, 2) << "rank " << failing << ": " << run.output;
    EXPECT_NE(run.output.find("no-such-problem"), std::string::npos) << run.output;
  }
}
#endif

TEST(PlanSweep, ShardsAreChecked) {
  EXPECT_EQ(ParseShard("2/8").index, 2);
  EXPECT_EQ(ParseShard("2/8").count, 8);
  EXPECT_EQ(ItemsOf({2, 3}, 8), (std::vector<int>{1, 4, 7}));
  EXPECT_TRUE(ItemsOf({3, 3}, 2).empty());
  EXPECT_EQ(SuffixOf({2, 3}), "_2_of_3");
  EXPECT_EQ(SuffixOf({1, 1}), "");
  for (const char* wrong : {"0/4", "5/4", "1", "a/b", "1/2x", "1/0"}) {
    EXPECT_EQ(ConfigErrorOf([&] { (void)ParseShard(wrong); }).find("--shard"), 0u) << wrong;
  }
}

}  // namespace
}  // namespace vantage::test
