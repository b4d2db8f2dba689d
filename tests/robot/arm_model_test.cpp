#include "vantage/robot/arm_model.h"

#include <functional>
#include <limits>

#include <gtest/gtest.h>

#include "config_error.h"
#include "vantage/math/error.h"

namespace vantage {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// What the constructor takes, valid until a test spoils one thing.
struct Parts {
  std::vector<DhRow> rows{3};
  std::vector<JointLimits> limits{3};
  Eigen::Isometry3d base{Eigen::Isometry3d::Identity()};
  Eigen::Isometry3d tool{Eigen::Isometry3d::Identity()};
  std::vector<Capsule> capsules{{0, {0, 0, 0}, {0, 0, 1}, 0.1}};
  std::vector<std::string> names{"a", "b", "c"};

  [[nodiscard]] ArmModel Make() const {
    return ArmModel("arm", DhConvention::kStandard, rows, limits, base, tool, capsules, names);
  }
};

TEST(ArmModel, KeepsWhatItIsGiven) {
  Parts parts;
  parts.rows[1].kind = JointKind::kPrismatic;
  const ArmModel arm = parts.Make();
  EXPECT_EQ(arm.name(), "arm");
  EXPECT_EQ(arm.size(), 3);
  EXPECT_EQ(arm.joint_names(), (std::vector<std::string>{"a", "b", "c"}));
  EXPECT_EQ(arm.joint_kinds()[1], JointKind::kPrismatic);
  EXPECT_EQ(arm.joint_kinds()[2], JointKind::kRevolute);
  EXPECT_EQ(arm.capsules().size(), 1u);
}

TEST(ArmModel, NumbersJointsWithoutNames) {
  Parts parts;
  parts.names.clear();
  EXPECT_EQ(parts.Make().joint_names(), (std::vector<std::string>{"joint1", "joint2", "joint3"}));
}

TEST(ArmModel, WithLimitsLeavesTheOriginal) {
  const ArmModel arm = Parts().Make();
  const ArmModel narrow = arm.WithLimits({3, {-0.5, 0.5, 1.0, 1.0}});
  EXPECT_EQ(narrow.limits()[2].upper, 0.5);
  EXPECT_NE(arm.limits()[2].upper, 0.5);
}

TEST(ArmModel, TakesTheMostJoints) {
  Parts parts;
  parts.rows.resize(kMaxJoints);
  parts.limits.resize(kMaxJoints);
  parts.names.clear();
  EXPECT_EQ(parts.Make().size(), kMaxJoints);
}

struct Refusal {
  const char* name;
  std::function<void(Parts*)> spoil;
  const char* message;
};

class ArmModelRefuses : public ::testing::TestWithParam<Refusal> {};

TEST_P(ArmModelRefuses, WithOneLine) {
  Parts parts;
  ASSERT_NO_THROW((void)parts.Make());
  GetParam().spoil(&parts);
  try {
    (void)parts.Make();
    FAIL() << "not refused";
  } catch (const ConfigError& error) {
    EXPECT_STREQ(error.what(), GetParam().message);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Parts, ArmModelRefuses,
    ::testing::Values(
        Refusal{"NoJoints",
                [](Parts* p) {
                  p->rows.clear();
                  p->limits.clear();
                },
                "joints: must be 1 to 16, are 0"},
        Refusal{"TooManyJoints",
                [](Parts* p) {
                  p->rows.resize(17);
                  p->limits.resize(17);
                },
                "joints: must be 1 to 16, are 17"},
        Refusal{"MissingLimits", [](Parts* p) { p->limits.pop_back(); },
                "limits: must be given for each of 3 joints, are 2"},
        Refusal{"EmptyRange", [](Parts* p) { p->limits[1].upper = p->limits[1].lower = 2.0; },
                "limits[1]: range must be finite with upper > lower, is [2, 2]"},
        Refusal{"InfiniteRange", [](Parts* p) { p->limits[1].upper = kInfinity; },
                "limits[1]: range must be finite with upper > lower, is [-3.14159, inf]"},
        Refusal{"NoVelocity", [](Parts* p) { p->limits[0].velocity = 0.0; },
                "limits[0]: velocity must be finite and > 0, is 0"},
        Refusal{"NoAcceleration", [](Parts* p) { p->limits[2].acceleration = -1.0; },
                "limits[2]: acceleration must be finite and > 0, is -1"},
        Refusal{"NotANumberInARow", [](Parts* p) { p->rows[2].a = kNaN; },
                "joints[2]: must be finite"},
        Refusal{"BaseThatIsNoPose", [](Parts* p) { p->base.linear() *= 2.0; },
                "base: must be a finite rigid motion"},
        Refusal{"ToolThatIsNoPose", [](Parts* p) { p->tool.translation().x() = kNaN; },
                "tool: must be a finite rigid motion"},
        Refusal{"CapsuleOnNoLink", [](Parts* p) { p->capsules[0].link = 3; },
                "capsules[0]: link must be -1 (base) to 2, is 3"},
        Refusal{"CapsuleWithoutBody", [](Parts* p) { p->capsules[0].radius = 0.0; },
                "capsules[0]: radius must be finite and > 0, is 0"},
        Refusal{"CapsuleWithoutEnd", [](Parts* p) { p->capsules[0].p_LB.y() = kInfinity; },
                "capsules[0]: ends must be finite"},
        Refusal{"TooFewNames", [](Parts* p) { p->names.pop_back(); },
                "joint_names: must be given for each of 3 joints, are 2"},
        Refusal{"EmptyName", [](Parts* p) { p->names[1].clear(); },
                "joint_names: must not be empty"},
        Refusal{"RepeatedName", [](Parts* p) { p->names[1] = "a"; },
                "joint_names: 'a' names two joints"}),
    [](const auto& test) { return test.param.name; });

TEST(ArmModel, WithLimitsRefusesTooFew) {
  EXPECT_THROW((void)Parts().Make().WithLimits({}), ConfigError);
}

TEST(ArmModel, GeneralJointsRefuseWhatIsNoPose) {
  std::vector<JointTransform> joints(3);
  joints[1].X_after.translation().z() = kNaN;
  EXPECT_THROW(ArmModel("arm", joints, std::vector<JointLimits>(3), Eigen::Isometry3d::Identity(),
                        Eigen::Isometry3d::Identity()),
               ConfigError);
}

TEST(ArmModel, WithVisualsRefusesWhatCannotBeDrawn) {
  const ArmModel arm = Parts().Make();
  const auto refusal = [&](const ArmVisual& visual) {
    return test::ConfigErrorOf([&] { (void)arm.WithVisuals({visual}); });
  };
  const ArmVisual good{2, Eigen::Isometry3d::Identity(), SphereShape{0.1}, {}};
  EXPECT_EQ(arm.WithVisuals({good}).visuals().size(), 1u);
  ArmVisual bad = good;
  bad.link = 3;
  EXPECT_EQ(refusal(bad), "visuals[0]: link must be -1 (base) to 2, is 3");
  bad = good;
  bad.X_LV.linear() *= 2.0;
  EXPECT_EQ(refusal(bad), "visuals[0]: must be a finite rigid motion");
  const std::vector<Shape> shapes{
      BoxShape{{1.0, 0.0, 1.0}}, CylinderShape{0.1, 0.0},
      SphereShape{kInfinity},    CapsuleShape{{0, 0, 0}, {0, 0, kNaN}, 1.0},
      MeshShape{"", {1, 1, 1}},  MeshShape{"a.stl", {1, 0, 1}}};
  for (const Shape& shape : shapes) {
    bad = good;
    bad.shape = shape;
    EXPECT_EQ(refusal(bad), "visuals[0]: sizes must be finite and > 0, and a mesh must have a path")
        << shape.index();
  }
}

TEST(WithinLimits, HoldsAtTheBoundsAndNotBeyond) {
  const ArmModel arm = Parts().Make().WithLimits({3, {-1.0, 2.0, 1.0, 1.0}});
  EXPECT_TRUE(WithinLimits(arm, Eigen::Vector3d(-1.0, 0.0, 2.0)));
  EXPECT_FALSE(WithinLimits(arm, Eigen::Vector3d(0.0, 2.0 + 1e-12, 0.0)));
  EXPECT_FALSE(WithinLimits(arm, Eigen::Vector3d(0.0, 0.0, kNaN)));
}

TEST(ClampToLimits, MovesOnlyWhatIsOutside) {
  const ArmModel arm = Parts().Make().WithLimits({3, {-1.0, 2.0, 1.0, 1.0}});
  const JointVector q = ClampToLimits(arm, Eigen::Vector3d(-7.0, 0.25, 2.5));
  EXPECT_EQ(q, JointVector(Eigen::Vector3d(-1.0, 0.25, 2.0)));
}

}  // namespace
}  // namespace vantage
