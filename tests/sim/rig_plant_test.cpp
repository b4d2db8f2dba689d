#include "sim/rig_plant.h"

#include <cmath>

#include <gtest/gtest.h>

#include "config_error.h"

namespace vantage::sim {
namespace {

// Along W's x axis, 0 to 2 m at 0.5 m/s; all else is locked.
CameraRig Rail() {
  CameraRig rig;
  rig.kind = RigKind::kRail;
  rig.rail_W = Eigen::Vector3d::UnitX();
  rig.axes = {{"s", 0.0, 2.0, 0.5, 1.0}, {"pan", 0.0, 0.0, 0.0, 0.0}, {"tilt", 0.0, 0.0, 0.0, 0.0}};
  return rig;
}

CameraPose At(double x) {
  CameraPose pose;
  pose.X_WC.translation().x() = x;
  return pose;
}

TEST(RigPlant, GoesToTheCommandedPoseAtItsSpeedAndStaysThere) {
  RigPlant rig(Rail(), RigVector::Zero(3));
  rig.Accept(At(0.3));
  rig.Step(0.1);
  EXPECT_NEAR(rig.X_WC().translation().x(), 0.05, 1e-9);
  for (int i = 0; i < 10; ++i) rig.Step(0.1);
  EXPECT_NEAR(rig.X_WC().translation().x(), 0.3, 1e-6);
}

TEST(RigPlant, StopsAtTheEndOfItsAxis) {
  RigPlant rig(Rail(), RigVector::Zero(3));
  rig.Accept(At(5.0));
  for (int i = 0; i < 100; ++i) rig.Step(0.1);
  EXPECT_NEAR(rig.X_WC().translation().x(), 2.0, 1e-6);
}

TEST(RigPlant, DoesNotObeyWhatIsNoPose) {
  RigPlant rig(Rail(), RigVector::Zero(3));
  rig.Accept(At(std::nan("")));
  rig.Step(0.1);
  EXPECT_EQ(rig.X_WC().translation().x(), 0.0);
}

TEST(RigPlant, RefusesAStartOfAnotherSize) {
  EXPECT_EQ(test::ConfigErrorOf([] { RigPlant(Rail(), RigVector::Zero(2)); }),
            "camera_rig.start: needs 3 coordinates, found 2");
}

}  // namespace
}  // namespace vantage::sim
