#include "vantage/config/robot_task.h"

#include <gtest/gtest.h>

#include "config_error.h"

namespace vantage {
namespace {

std::string ErrorOf(const RobotTask& task) {
  return test::ConfigErrorOf([&] { (void)WriteScenarioFor(task); });
}

TEST(WriteScenarioFor, RefusesANumberOfMarkersThatCannotBe) {
  RobotTask task;
  task.robot = "puma560";
  task.marker_count = kMaxPoints + 1;
  EXPECT_EQ(ErrorOf(task), "markers: must be 1 to 16, are 17");
}

// Links are named in URDF files alone, whatever case their ending is in.
TEST(WriteScenarioFor, TakesLinksOfUrdfFilesAlone) {
  RobotTask task;
  task.tip_link = "hand";
  task.robot = "puma560";
  EXPECT_EQ(ErrorOf(task), "robot: 'puma560' is no URDF file: it has no links to name");
  for (const char* robot : {"/nowhere/arm.urdf", "/nowhere/ARM.URDF", "/nowhere/arm.urdf.xacro"}) {
    task.robot = robot;
    EXPECT_EQ(ErrorOf(task).find("is no URDF file"), std::string::npos) << ErrorOf(task);
    EXPECT_NE(ErrorOf(task).find(robot), std::string::npos) << ErrorOf(task);
  }
}

TEST(WriteScenarioFor, SaysWhyMarkersCannotBeRead) {
  RobotTask task;
  task.robot = "planar2";
  task.marker_file = "/nowhere/markers.yaml";
  EXPECT_EQ(ErrorOf(task), "/nowhere/markers.yaml: cannot be opened: No such file or directory");
}

}  // namespace
}  // namespace vantage
