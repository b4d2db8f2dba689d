// Scenarios as one text that can be read anywhere: what a log carries.

#include <filesystem>

#include <gtest/gtest.h>

#include "config_error.h"
#include "temporary_folder.h"
#include "vantage/config/camera_plan_file.h"
#include "vantage/config/scenario.h"
#include "vantage/math/error.h"
#include "vantage/robot/kinematics.h"

namespace vantage {
namespace {

// The same to the last bit, where a controller looks.
void ExpectSame(const Scenario& a, const Scenario& b) {
  EXPECT_EQ(a.description, b.description);
  const ArmModel& arm = a.task.view.arm;
  ASSERT_EQ(arm.size(), b.task.view.arm.size());
  EXPECT_EQ(arm.name(), b.task.view.arm.name());
  EXPECT_EQ(arm.capsules().size(), b.task.view.arm.capsules().size());
  for (int i = 0; i < arm.size(); ++i) {
    EXPECT_EQ(arm.limits()[i].lower, b.task.view.arm.limits()[i].lower);
    EXPECT_EQ(arm.limits()[i].acceleration, b.task.view.arm.limits()[i].acceleration);
  }
  const JointVector& q = a.sim.q_start;
  EXPECT_EQ(q, b.sim.q_start);
  EXPECT_EQ(EndEffectorPose(arm, q).matrix(), EndEffectorPose(b.task.view.arm, q).matrix());
  EXPECT_EQ(a.task.goal.p_WG, b.task.goal.p_WG);
  EXPECT_EQ(a.q_c_start, b.q_c_start);
  EXPECT_EQ(RigPose(a.rig, a.q_c_start).matrix(), RigPose(b.rig, b.q_c_start).matrix());
  EXPECT_EQ(a.servo.law.gain_at_zero, b.servo.law.gain_at_zero);
  EXPECT_EQ(a.active.trigger.threshold, b.active.trigger.threshold);
}

TEST(SelfContained, BuiltInScenariosAreTheSame) {
  for (const std::string& name : BuiltInConfigs(ConfigKind::kScenario)) {
    SCOPED_TRACE(name);
    const ConfigText text = SelfContainedScenario(name);
    EXPECT_EQ(text.folder, "");
    ExpectSame(LoadScenario(name), ReadScenario(text, name));
  }
}

TEST(SelfContained, ErrorsOfARecordedScenarioNameTheLog) {
  EXPECT_EQ(ReadRecordedScenario("mine", SelfContainedScenario("puma560-bad-view").text).name,
            "mine");
  const std::string error =
      test::ConfigErrorOf([] { (void)ReadRecordedScenario("mine", "robot: puma560\n"); });
  EXPECT_EQ(error.rfind("log:mine", 0), 0u) << error;
}

// Robots beside the scenario's file, described in YAML and in URDF, found from anywhere.
TEST(SelfContained, TakesTheRobotFromBesideTheScenario) {
  const test::TemporaryFolder folder;
  const std::string robots = std::string(VANTAGE_TEST_DATA) + "/../../config/robots";
  std::filesystem::copy(robots + "/puma560.yaml", folder.path() / "mine.yaml");
  std::filesystem::copy(robots + "/ur5.urdf", folder.path() / "mine.urdf");
  std::filesystem::copy(robots + "/meshes", folder.path() / "meshes",
                        std::filesystem::copy_options::recursive);
  std::string text = FindConfigText(ConfigKind::kScenario, "puma560-bad-view").text;
  const std::string named = "robot: puma560";
  ASSERT_NE(text.find(named), std::string::npos);
  for (const char* robot : {"mine.yaml", "mine.urdf"}) {
    SCOPED_TRACE(robot);
    std::string with = text;
    with.replace(with.find(named), named.size(), std::string("robot: ") + robot);
    const std::string path = folder.Write("scenario.yaml", with);
    const ConfigText alone = SelfContainedScenario(path);
    ExpectSame(LoadScenario(path), ReadScenario({"log", "", alone.text}, "scenario"));
  }
}

// Also of a scenario that says where the camera starts: a key may stand in a file once.
TEST(SelfContained, StartsWithTheCameraWhereItIsToldTo) {
  const std::string name = "puma560-bad-view";
  const Scenario scenario = LoadScenario(name);
  const RigVector elsewhere = scenario.q_c_start + RigVector::Constant(scenario.rig.size(), 0.01);
  const test::TemporaryFolder folder;
  const std::string path = folder.Write(
      "own.yaml", SelfContainedScenario(name, CameraStartText(scenario.rig, elsewhere)).text);
  EXPECT_TRUE(LoadScenario(path).q_c_start.isApprox(elsewhere, 1e-12));
  const ConfigText back =
      SelfContainedScenario(path, CameraStartText(scenario.rig, scenario.q_c_start));
  EXPECT_TRUE(ReadScenario(back, "own").q_c_start.isApprox(scenario.q_c_start, 1e-12));
}

TEST(SelfContained, SaysWhatIsMissing) {
  EXPECT_THROW((void)SelfContainedScenario("no-such-scenario"), ConfigError);
  const test::TemporaryFolder folder;
  EXPECT_THROW((void)SelfContainedScenario(folder.Write("a.yaml", "description: x\n")),
               ConfigError);
  EXPECT_THROW((void)SelfContainedScenario(folder.Write("b.yaml", "robot: nobody\n")), ConfigError);
}

}  // namespace
}  // namespace vantage
