#include "vantage/camera/camera_rig.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <string>

#include <gtest/gtest.h>

#include "config_error.h"
#include "eigen_matchers.h"
#include "finite_difference.h"
#include "oracles.h"
#include "vantage/math/angles.h"
#include "vantage/math/error.h"

namespace vantage {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::Vector4d;

RigAxis Axis(const char* name, double lower, double upper, double speed = 0.5) {
  return {name, lower, upper, speed, speed > 0.0 ? 1.0 : 0.0};
}

CameraRig Spherical(RigOrientation orientation = RigOrientation::kLookAt) {
  CameraRig rig;
  rig.kind = RigKind::kSpherical;
  rig.orientation = orientation;
  rig.target_W = Vector3d(0.4, -0.1, 0.3);
  rig.axes = {Axis("R", 0.8, 3.0), Axis("theta", 0.05, 2.0), Axis("phi", -3.5, 3.5),
              Axis("roll", -4.0, 4.0)};
  return rig;
}

CameraRig SphericalWithHead() {
  CameraRig rig = Spherical();
  rig.axes.push_back(Axis("pan", -0.7, 0.7));
  rig.axes.push_back(Axis("tilt", -0.6, 0.6));
  return rig;
}

Isometry3d Somewhere() {
  Isometry3d X = Isometry3d::Identity();
  X.translation() = Vector3d(1.2, -0.3, 0.9);
  X.linear() = Eigen::AngleAxisd(2.0, Vector3d(0.3, 1.0, -0.4).normalized()).toRotationMatrix();
  return X;
}

CameraRig PanTilt() {
  CameraRig rig;
  rig.kind = RigKind::kPanTilt;
  rig.X_WC_fixed = Somewhere();
  rig.axes = {Axis("pan", -2.0, 2.0), Axis("tilt", -1.2, 1.2)};
  return rig;
}

CameraRig Rail(bool head) {
  CameraRig rig;
  rig.kind = RigKind::kRail;
  rig.X_WC_fixed = Somewhere();
  rig.rail_W = Vector3d(0.6, 0.0, 0.8);
  rig.axes = {Axis("s", -1.0, 1.0)};
  if (head) {
    rig.axes.push_back(Axis("pan", -2.0, 2.0));
    rig.axes.push_back(Axis("tilt", -1.2, 1.2));
  }
  return rig;
}

CameraRig Free() {
  CameraRig rig;
  rig.kind = RigKind::kFree;
  rig.X_WC_fixed = Somewhere();
  rig.axes = {Axis("x", -2.0, 2.0),   Axis("y", -2.0, 2.0),    Axis("z", -2.0, 2.0),
              Axis("pan", -2.5, 2.5), Axis("tilt", -1.2, 1.2), Axis("roll", -3.0, 3.0)};
  return rig;
}

// Six joints, the second of them prismatic, axes askew.
CameraRig OnArm() {
  CameraRig rig;
  rig.kind = RigKind::kArm;
  rig.X_WC_fixed = Somewhere();
  const auto joint = [](const Vector3d& axis, const Vector3d& point, bool prismatic) {
    return RigJoint{prismatic, axis.normalized(), point};
  };
  rig.joints = {
      joint({0, 0, 1}, {0, 0, 0}, false),          joint({1, 0, 1}, {0, 0, 0}, true),
      joint({0, 1, 0.1}, {0.2, 0, 0.5}, false),    joint({0, 1, 0}, {0.7, 0, 0.6}, false),
      joint({1, 0.2, 0}, {1.0, -0.2, 0.8}, false), joint({0, 0.3, 1}, {1.2, -0.3, 0.8}, false)};
  rig.axes = {Axis("j1", -1.0, 1.0), Axis("j2", -0.3, 0.3), Axis("j3", -1.0, 1.0),
              Axis("j4", -1.0, 1.0), Axis("j5", -1.0, 1.0), Axis("j6", -1.5, 1.5)};
  return rig;
}

RigVector RandomCoordinates(const CameraRig& rig, std::mt19937* random) {
  RigVector q_c(rig.size());
  for (int i = 0; i < rig.size(); ++i) {
    q_c(i) = std::uniform_real_distribution<double>(rig.axes[i].lower, rig.axes[i].upper)(*random);
  }
  return q_c;
}

struct NamedRig {
  const char* name;
  std::function<CameraRig()> make;
};

class EveryRig : public ::testing::TestWithParam<NamedRig> {};

INSTANTIATE_TEST_SUITE_P(
    Kinds, EveryRig,
    ::testing::Values(NamedRig{"Spherical", [] { return Spherical(); }},
                      NamedRig{"FixedDown", [] { return Spherical(RigOrientation::kFixedDown); }},
                      NamedRig{"SphericalWithHead", SphericalWithHead},
                      NamedRig{"PanTilt", PanTilt}, NamedRig{"Rail", [] { return Rail(false); }},
                      NamedRig{"RailWithHead", [] { return Rail(true); }}, NamedRig{"Free", Free},
                      NamedRig{"OnArm", OnArm}),
    [](const auto& test) { return std::string(test.param.name); });

TEST(SphericalPose, MatchesOracles) {
  const nlohmann::json oracles = test::ReadOracles();
  int checked = 0;
  for (const auto& c : oracles["cases"]) {
    if (!c["camera"].contains("spherical")) continue;
    const auto& s = c["camera"]["spherical"];
    const Vector4d q_c(s["R"], s["theta"], s["phi"], s["roll"]);
    const Vector3d target(s["target"][0], s["target"][1], s["target"][2]);
    const bool down = s["orientation"] == "fixed_down";
    const Eigen::Matrix4d reference = test::OracleMatrix(c["expected"]["T_wc"]);
    const Isometry3d X_WC =
        SphericalPose(down ? RigOrientation::kFixedDown : RigOrientation::kLookAt, target, q_c);
    const double scale = std::max(1.0, reference.cwiseAbs().maxCoeff());
    EXPECT_TRUE(test::Near(X_WC.matrix(), reference, 1e-12 * scale)) << c["id"];
    ++checked;
  }
  EXPECT_GT(checked, 0);
}

TEST(SphericalPose, LooksAtTargetFromEverywhere) {
  const Vector3d target(0.1, 0.2, 0.3);
  for (const double theta : {0.0, 0.7, kPi / 2.0, kPi}) {
    const Isometry3d X_WC =
        SphericalPose(RigOrientation::kLookAt, target, Vector4d(1.5, theta, -2.0, 0.4));
    EXPECT_TRUE(test::Near(X_WC.inverse() * target, Vector3d(0.0, 0.0, 1.5), 1e-14));
    EXPECT_TRUE(IsPose(X_WC));
  }
}

TEST_P(EveryRig, JacobianMatchesCentralDifference) {
  const CameraRig rig = GetParam().make();
  std::mt19937 random(11);
  for (int trial = 0; trial < 20; ++trial) {
    const RigVector q_c = RandomCoordinates(rig, &random);
    const Isometry3d X_WC = RigPose(rig, q_c);
    const auto numeric = test::CentralDifference(
        [&](const Eigen::VectorXd& step) -> Eigen::VectorXd {
          return Displacement(X_WC, RigPose(rig, q_c + RigVector(step)));
        },
        6, rig.size());
    EXPECT_TRUE(test::Near(RigJacobian(rig, q_c), numeric, 1e-8));
  }
}

TEST_P(EveryRig, ManyPosesAreThoseOfEach) {
  const CameraRig rig = GetParam().make();
  std::mt19937 random(5);
  std::vector<std::vector<double>> values(rig.size());
  for (int i = 0; i < 3; ++i) {
    const RigVector q_c = RandomCoordinates(rig, &random);
    for (int axis = 0; axis < rig.size(); ++axis) values[axis].push_back(q_c(axis));
  }
  values[0].push_back(values[0].back());  // Twice the same.
  std::vector<int> pick;
  std::vector<RigVector> all;
  for (int i = 0; i < 12; ++i) {
    RigVector q_c(rig.size());
    for (int axis = 0; axis < rig.size(); ++axis) {
      const auto count = static_cast<int>(values[axis].size());
      pick.push_back(std::uniform_int_distribution<int>(0, count - 1)(random));
      q_c(axis) = values[axis][pick.back()];
    }
    all.push_back(q_c);
  }
  std::vector<Isometry3d> X_WC;
  RigPoses(rig, values, pick, &X_WC);
  ASSERT_EQ(X_WC.size(), all.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    EXPECT_TRUE(test::Near(X_WC[i].matrix(), RigPose(rig, all[i]).matrix(), 1e-15)) << i;
  }
}

TEST(RigJacobian, HoldsAtThePole) {
  CameraRig rig = Spherical();
  const RigVector q_c = Vector4d(1.4, 0.0, 0.6, 0.2);
  const auto numeric = test::CentralDifference(
      [&](const Eigen::VectorXd& step) -> Eigen::VectorXd {
        return Displacement(RigPose(rig, q_c), RigPose(rig, q_c + RigVector(step)));
      },
      6, 4);
  EXPECT_TRUE(test::Near(RigJacobian(rig, q_c), numeric, 1e-8));
}

TEST(RigJacobian, OfFixedRigHasNoColumns) {
  CameraRig rig;
  rig.X_WC_fixed = Somewhere();
  EXPECT_EQ(RigJacobian(rig, RigVector(0)).cols(), 0);
  EXPECT_TRUE(test::Near(RigPose(rig, RigVector(0)).matrix(), Somewhere().matrix(), 0.0));
}

TEST(RigPose, PanTurnsRightAndTiltTurnsUp) {
  CameraRig rig = PanTilt();
  RigVector q_c = Eigen::Vector2d(0.3, 0.2);
  const Vector3d axis_C0 = rig.X_WC_fixed.linear().transpose() * RigPose(rig, q_c).linear().col(2);
  EXPECT_GT(axis_C0.x(), 0.1);
  EXPECT_LT(axis_C0.y(), -0.1);
}

TEST_P(EveryRig, NearestCoordinatesUndoPose) {
  const CameraRig rig = GetParam().make();
  std::mt19937 random(12);
  for (int trial = 0; trial < 200; ++trial) {
    const RigVector q_c = RandomCoordinates(rig, &random);
    const RigVector near = RandomCoordinates(rig, &random);
    const Isometry3d X_WC = RigPose(rig, q_c);
    // The very coordinates come back when they are where the search starts: the same turn, or branch.
    EXPECT_TRUE(test::Near(NearestRigCoordinates(rig, X_WC, q_c), q_c, 1e-9));
    if (rig.kind == RigKind::kArm) continue;  // May be on another branch: see the tests of arms.
    const RigVector found = NearestRigCoordinates(rig, X_WC, near);
    EXPECT_TRUE(test::Near(RigPose(rig, found).matrix(), X_WC.matrix(), 1e-9));
  }
}

TEST_P(EveryRig, NearestCoordinatesAreWithinLimits) {
  const CameraRig rig = GetParam().make();
  std::mt19937 random(13);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 200; ++trial) {
    Isometry3d X_WC = Isometry3d::Identity();
    X_WC.translation() = 4.0 * Vector3d(normal(random), normal(random), normal(random));
    X_WC.linear() =
        Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random))
            .normalized()
            .toRotationMatrix();
    const RigVector found = NearestRigCoordinates(rig, X_WC, RandomCoordinates(rig, &random));
    EXPECT_TRUE(test::Near(found, ClampToLimits(rig, found), 0.0));
  }
}

// No point of a fine grid over the limits is nearer to a camera outside them.
TEST(NearestRigCoordinates, IsNearestPositionOfSector) {
  CameraRig rig = Spherical();
  rig.axes[1].lower = 0.4;
  rig.axes[1].upper = 1.2;
  rig.axes[2].lower = -0.5;
  rig.axes[2].upper = 0.5;
  std::mt19937 random(14);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 40; ++trial) {
    Isometry3d X_WC = Isometry3d::Identity();
    X_WC.translation() =
        rig.target_W + 2.0 * Vector3d(normal(random), normal(random), normal(random));
    const RigVector found = NearestRigCoordinates(rig, X_WC, Vector4d(1.0, 1.0, 0.0, 0.0));
    const double reached = (RigPose(rig, found).translation() - X_WC.translation()).norm();
    double best = std::numeric_limits<double>::infinity();
    for (int i = 0; i <= 20; ++i) {
      for (int j = 0; j <= 20; ++j) {
        for (int k = 0; k <= 20; ++k) {
          const RigVector q_c =
              Vector4d(0.8 + 2.2 * i / 20, 0.4 + 0.8 * j / 20, -0.5 + k / 20.0, 0);
          best = std::min(best, (RigPose(rig, q_c).translation() - X_WC.translation()).norm());
        }
      }
    }
    EXPECT_LE(reached, best + 1e-12);
  }
}

TEST(NearestRigCoordinates, KeepsLockedAxes) {
  CameraRig rig = Spherical();
  rig.axes[0].max_speed = 0.0;
  const RigVector near = Vector4d(1.7, 1.0, 0.2, 0.1);
  const Isometry3d X_WC = RigPose(rig, Vector4d(2.5, 0.6, -0.9, 0.3));
  const RigVector found = NearestRigCoordinates(rig, X_WC, near);
  EXPECT_TRUE(test::Near(found, Vector4d(1.7, 0.6, -0.9, 0.3), 1e-9));
}

TEST(NearestRigCoordinates, OfArmFollowsPosesNearby) {
  const CameraRig rig = OnArm();
  std::mt19937 random(16);
  std::normal_distribution<double> step(0.0, 0.05);
  for (int trial = 0; trial < 200; ++trial) {
    const RigVector near = 0.8 * RandomCoordinates(rig, &random);
    RigVector q_c = near;
    for (int i = 0; i < rig.size(); ++i) q_c(i) += step(random);
    q_c = ClampToLimits(rig, q_c);
    const RigVector found = NearestRigCoordinates(rig, RigPose(rig, q_c), near);
    EXPECT_TRUE(test::Near(RigPose(rig, found).matrix(), RigPose(rig, q_c).matrix(), 1e-9));
  }
}

// Out of reach: no small step within the limits comes nearer.
TEST(NearestRigCoordinates, OfArmIsALeastDistance) {
  const CameraRig rig = OnArm();
  std::mt19937 random(17);
  std::normal_distribution<double> normal;
  const auto cost = [&](const RigVector& q_c, const Isometry3d& X_WC) {
    const Isometry3d left = RigPose(rig, q_c).inverse() * X_WC;
    return std::hypot(left.translation().norm(), 0.1 * Eigen::AngleAxisd(left.linear()).angle());
  };
  for (int trial = 0; trial < 30; ++trial) {
    Isometry3d X_WC = RigPose(rig, RandomCoordinates(rig, &random));
    X_WC.translation() += 2.0 * Vector3d(normal(random), normal(random), normal(random));
    const RigVector found = NearestRigCoordinates(rig, X_WC, RigVector::Zero(6));
    const double least = cost(found, X_WC);
    for (int k = 0; k < 200; ++k) {
      RigVector other = found;
      for (int i = 0; i < 6; ++i) other(i) += 0.02 * normal(random);
      EXPECT_GE(cost(ClampToLimits(rig, other), X_WC), least - 1e-4);
    }
  }
}

TEST(NearestRigCoordinates, TakesTheTurnNearby) {
  const CameraRig rig = Spherical();
  const Isometry3d X_WC = RigPose(rig, Vector4d(1.5, 1.0, 3.1, 0.0));
  EXPECT_NEAR(NearestRigCoordinates(rig, X_WC, Vector4d(1.5, 1.0, -3.3, 0.0))(2), 3.1 - 2 * kPi,
              1e-9);
  EXPECT_NEAR(NearestRigCoordinates(rig, X_WC, Vector4d(1.5, 1.0, 3.3, 0.0))(2), 3.1, 1e-9);
}

TEST(AimAt, PutsPointOnOpticalAxis) {
  std::mt19937 random(15);
  for (const CameraRig& rig : {SphericalWithHead(), PanTilt(), Rail(true), Free()}) {
    for (int trial = 0; trial < 50; ++trial) {
      const RigVector q_c = RandomCoordinates(rig, &random);
      // A point that this rig can look at: somewhere on the axis of a reachable pose.
      RigVector aimed = RandomCoordinates(rig, &random);
      const RigHead head = HeadOf(rig);
      for (int i = 0; i < rig.size(); ++i) {
        if (i != head.pan && i != head.tilt) aimed(i) = q_c(i);
      }
      const Vector3d p_W = RigPose(rig, aimed) * Vector3d(0.0, 0.0, 1.3);
      const Vector3d p_C = RigPose(rig, AimAt(rig, q_c, p_W)).inverse() * p_W;
      EXPECT_TRUE(test::Near(p_C, Vector3d(0.0, 0.0, 1.3), 1e-9));
    }
  }
}

TEST(AimAt, LeavesRigsWithoutHead) {
  const CameraRig rig = Spherical();
  const RigVector q_c = Vector4d(1.5, 1.0, 0.3, 0.2);
  EXPECT_TRUE(test::Near(AimAt(rig, q_c, Vector3d(0.0, 1.0, 0.0)), q_c, 0.0));
}

TEST(AimAt, StopsAtLimits) {
  CameraRig rig = PanTilt();
  rig.axes[0].upper = 0.2;
  rig.axes[0].lower = -0.2;
  const Vector3d right_W = rig.X_WC_fixed * Vector3d(1.0, 0.0, 1.0);
  EXPECT_NEAR(AimAt(rig, Eigen::Vector2d(0.0, 0.0), right_W)(0), 0.2, 1e-12);
}

TEST(ClampToLimits, MovesEachAxisInside) {
  const CameraRig rig = Spherical();
  EXPECT_TRUE(test::Near(ClampToLimits(rig, Vector4d(0.1, 3.0, -9.0, 1.0)),
                         Vector4d(0.8, 2.0, -3.5, 1.0), 0.0));
}

TEST_P(EveryRig, Validates) {
  EXPECT_NO_THROW(Validate(GetParam().make()));
}

struct BadRig {
  const char* name;
  const char* key;
  std::function<void(CameraRig*)> spoil;
};

class ValidateRefuses : public ::testing::TestWithParam<BadRig> {};

TEST_P(ValidateRefuses, OneCause) {
  CameraRig rig = Spherical();
  ASSERT_NO_THROW(Validate(rig));
  GetParam().spoil(&rig);
  try {
    Validate(rig);
    FAIL() << "accepted";
  } catch (const ConfigError& error) {
    EXPECT_EQ(error.key(), GetParam().key);
  }
}

const double kNan = std::numeric_limits<double>::quiet_NaN();

INSTANTIATE_TEST_SUITE_P(
    Causes, ValidateRefuses,
    ::testing::Values(BadRig{"AxisMissing", "camera_rig.axes",
                             [](CameraRig* r) { r->axes.pop_back(); }},
                      BadRig{"AxesOnFixedRig", "camera_rig.axes",
                             [](CameraRig* r) { r->kind = RigKind::kFixed; }},
                      BadRig{"LimitsReversed", "camera_rig.axes.phi.limits",
                             [](CameraRig* r) { r->axes[2].lower = 4.0; }},
                      BadRig{"LimitNotFinite", "camera_rig.axes.phi.limits",
                             [](CameraRig* r) { r->axes[2].lower = kNan; }},
                      BadRig{"SpeedNegative", "camera_rig.axes.R.max_speed",
                             [](CameraRig* r) { r->axes[0].max_speed = -0.1; }},
                      BadRig{"NoAcceleration", "camera_rig.axes.R.max_acceleration",
                             [](CameraRig* r) { r->axes[0].max_acceleration = 0.0; }},
                      BadRig{"AccelerationNotFinite", "camera_rig.axes.R.max_acceleration",
                             [](CameraRig* r) { r->axes[0].max_acceleration = kNan; }},
                      BadRig{"RadiusZero", "camera_rig.axes.R.limits",
                             [](CameraRig* r) { r->axes[0].lower = 0.0; }},
                      BadRig{"ThetaPastPole", "camera_rig.axes.theta.limits",
                             [](CameraRig* r) { r->axes[1].upper = 3.2; }},
                      BadRig{"LinearSpeedZero", "camera_rig.max_linear_speed",
                             [](CameraRig* r) { r->max_linear_speed = 0.0; }},
                      BadRig{"TargetNotFinite", "camera_rig.target",
                             [](CameraRig* r) { r->target_W.x() = kNan; }}),
    [](const auto& test) { return std::string(test.param.name); });

TEST(Validate, RefusesSkewedPose) {
  CameraRig rig;
  rig.X_WC_fixed.linear()(0, 0) = 1.1;
  EXPECT_THROW(Validate(rig), ConfigError);
}

TEST(Validate, RefusesArmWithBadJoints) {
  const auto refusal = [](const CameraRig& rig) {
    return test::ConfigErrorOf([&] { Validate(rig); });
  };
  CameraRig rig = OnArm();
  rig.joints.pop_back();
  EXPECT_EQ(refusal(rig),
            "camera_rig.axes: a rig on an arm has one axis for each joint, 1 to 16, found 6 for 5 "
            "joints");
  rig = OnArm();
  rig.joints[2].axis_W = Vector3d(0.0, 0.0, 2.0);
  EXPECT_EQ(refusal(rig), "camera_rig.joints[2].axis: must be a unit vector, has length 2");
  rig = OnArm();
  rig.joints[2].point_W = Vector3d(1.0, std::numeric_limits<double>::infinity(), 3.0);
  EXPECT_EQ(refusal(rig), "camera_rig.joints[2].point: must be finite (m), is (1, inf, 3)");
}

TEST(Validate, RefusesRailThatIsNoUnitVector) {
  CameraRig rig = Rail(false);
  rig.rail_W *= 2.0;
  EXPECT_THROW(Validate(rig), ConfigError);
}

}  // namespace
}  // namespace vantage
