#include "plan_sweep.h"

#include <fstream>
#include <sstream>

#include <gtest/gtest.h>

#include "config_error.h"
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

std::string TextOf(const std::string& path) {
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

TEST(PlanSweep, OfShardsMergedIsTheSameToTheLastBit) {
  const TemporaryFolder folder;
  const auto file = [&](const std::string& name) { return (folder.path() / name).string(); };
  const PlacementSetup setup = SetupOf(kProblem);
  ASSERT_EQ(setup.bases.size(), 6u);
  RunSweep(setup, {1, 1}, file("whole"));
  std::vector<std::string> parts;
  for (int i = 3; i >= 1; --i) {
    parts.push_back(file("part" + std::to_string(i)));
    RunSweep(setup, {i, 3}, parts.back());
  }
  MergeSweeps(parts, file("merged"));
  EXPECT_EQ(TextOf(file("merged")), TextOf(file("whole")));
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
  const PlacementProblem moved = ProblemAt(setup, 5);  // x = 0.2, yaw = 90 degrees
  const Eigen::Vector3d p = setup.problem.motion.samples[3].markers[0].p_W;
  const Eigen::Vector3d expected(0.2 - p.y(), p.x(), p.z());
  EXPECT_LT((moved.motion.samples[3].markers[0].p_W - expected).norm(), 1e-12);
  EXPECT_EQ(moved.rig.target_W, setup.problem.rig.target_W);
}

TEST(PlanSweep, ShardsAreChecked) {
  EXPECT_EQ(ParseShard("2/8").index, 2);
  EXPECT_EQ(ParseShard("2/8").count, 8);
  for (const char* wrong : {"0/4", "5/4", "1", "a/b", "1/2x", "1/0"}) {
    EXPECT_EQ(ConfigErrorOf([&] { (void)ParseShard(wrong); }).find("--shard"), 0u) << wrong;
  }
}

}  // namespace
}  // namespace vantage::test
