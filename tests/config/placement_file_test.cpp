#include "vantage/config/placement_file.h"

#include <fstream>

#include <gtest/gtest.h>

#include "config_error.h"
#include "temporary_folder.h"
#include "vantage/config/camera_plan_file.h"
#include "vantage/config/scenario.h"

namespace vantage::test {
namespace {

PlacementSetup Read(const std::string& text) {
  return ReadPlacement({"test.yaml", "", text}, "test");
}

TEST(PlacementFile, BuiltInProblemsHaveASolution) {
  for (const std::string& name : BuiltInConfigs(ConfigKind::kProblem)) {
    SCOPED_TRACE(name);
    const PlacementSetup setup = LoadPlacement(name);
    EXPECT_FALSE(setup.description.empty());
    const PlacementModel model(setup.problem);
    const PlacedCamera best = PlaceCamera(model, setup.search).best;
    EXPECT_TRUE(best.feasible);
    if (setup.camera_moves) {
      EXPECT_EQ(PlanCameraPath(model, best, setup.path_search).path.broken, 0);
    }
  }
}

TEST(PlacementFile, AScenarioIsAProblem) {
  const PlacementSetup setup = LoadPlacement("puma560-bad-view");
  const Scenario scenario = LoadScenario("puma560-bad-view");
  EXPECT_EQ(setup.scenario, "puma560-bad-view");
  EXPECT_EQ(setup.problem.scene_markers.size(), 4u);
  EXPECT_EQ(setup.problem.motion.samples.front().q, scenario.sim.q_start);
  // The motion ends where the markers truly have to go.
  for (std::size_t i = 0; i < 4; ++i) {
    const Eigen::Vector3d& p = setup.problem.motion.samples.back().markers[i].p_W;
    EXPECT_LT((p - scenario.p_WG_true[i]).norm(), 1e-3);
  }
  const PlacementSetup same = Read("scenario: puma560-bad-view\nlimits: {min_depth: 0.9}\n");
  EXPECT_EQ(same.problem.limits.depth.min, 0.9);
  EXPECT_EQ(same.problem.limits.depth.max, setup.problem.limits.depth.max);
}

TEST(PlacementFile, AScenariosFileIsAProblemToo) {
  const TemporaryFolder folder;
  const std::string path =
      folder.Write("mine.yaml", FindConfigText(ConfigKind::kScenario, "puma3-bad-view").text);
  const PlacementSetup setup = LoadPlacement(path);
  EXPECT_EQ(setup.scenario, "mine");
  EXPECT_EQ(setup.problem.motion.samples.front().q,
            LoadPlacement("puma3-bad-view").problem.motion.samples.front().q);
}

TEST(PlacementFile, RefusesWithFileLineAndKey) {
  const std::string start = "scenario: puma560-bad-view\n";
  EXPECT_EQ(ConfigErrorOf([&] {
              Read(start + "limits: {focus: [2, 1]}\n");
            }).find("test.yaml:2: limits.focus"),
            0u);
  EXPECT_EQ(ConfigErrorOf([&] {
              Read(start + "limits: {margin: 300}\n");
            }).find("test.yaml:2: limits.margin"),
            0u);
  EXPECT_EQ(ConfigErrorOf([&] {
              Read(start + "objective: {of: both}\n");
            }).find("test.yaml:2: objective.of"),
            0u);
  EXPECT_EQ(
      ConfigErrorOf([&] { (void)Read(start + "robot: puma560\n"); }).find("test.yaml:2: robot"),
      0u);
  EXPECT_EQ(ConfigErrorOf([&] {
              Read(start + "motion: {samples: 0}\n");
            }).find("test.yaml:2: motion.samples"),
            0u);
  const std::string area =
      "robot: puma560\nmarkers:\n  - {id: 0, position: [0, 0, 0]}\n  - {id: 1, position: [0, 1, "
      "0]}\n"
      "features:\n  - {kind: distance, points: [0, 1]}\n"
      "camera_rig: {kind: fixed, pose: {position: [0, 0, 0]}}\n";
  EXPECT_EQ(ConfigErrorOf([&] { (void)Read(area); }).find("test.yaml:6: features"), 0u);
}

// Limits that are good each by itself and leave nothing together: no key alone is wrong, the file is.
TEST(PlacementFile, RefusesWhatDoesNotFitTogether) {
  EXPECT_EQ(ConfigErrorOf([&] {
              Read("scenario: puma560-bad-view\nlimits: {min_depth: 0.9, focus: [0.1, 0.4]}\n");
            }).find("test.yaml: limits.focus: ends before"),
            0u);
}

TEST(CameraPlanFile, CarriesTheStartToTheLastBit) {
  const Scenario scenario = LoadScenario("puma560-bad-view");
  RigVector q_c(4);
  q_c << 1.2345678901234567, 0.7, -2.1, 0.3333333333333333;
  const TemporaryFolder folder;
  const std::string path = (folder.path() / "plan.yaml").string();
  std::ofstream(path) << "problem: x\n" << CameraStartText(scenario.rig, q_c);
  EXPECT_LT((LoadCameraStart(path, scenario.rig) - q_c).cwiseAbs().maxCoeff(), 1e-15);
  // The same line in a scenario moves its start.
  const ConfigText text = SelfContainedScenario("puma560-bad-view");
  const Scenario moved = ReadScenario(
      {text.source, text.folder, text.text + "\n" + CameraStartText(scenario.rig, q_c)}, "moved");
  EXPECT_LT((moved.q_c_start - q_c).cwiseAbs().maxCoeff(), 1e-15);
  q_c(0) = 99.0;
  std::ofstream(path) << CameraStartText(scenario.rig, q_c);
  EXPECT_NE(
      ConfigErrorOf([&] { (void)LoadCameraStart(path, scenario.rig); }).find("camera_start.R"),
      std::string::npos);
}

}  // namespace
}  // namespace vantage::test
