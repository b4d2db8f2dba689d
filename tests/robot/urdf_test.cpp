#include "vantage/robot/urdf.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <random>

#include <gtest/gtest.h>

#include "config_error.h"
#include "eigen_matchers.h"
#include "oracle_arm.h"
#include "temporary_folder.h"
#include "vantage/math/angles.h"
#include "vantage/robot/kinematics.h"
#include "vantage/robot/mesh_file.h"

namespace vantage {
namespace {

using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Translation3d;
using Eigen::Vector3d;

const std::string kRobots = VANTAGE_TEST_DATA "/../../config/robots/";

// Text of a joint between two links; `inner` goes inside.
std::string Joint(const std::string& name, const std::string& type, const std::string& parent,
                  const std::string& child, const std::string& inner = "") {
  const bool limited = type == "revolute" || type == "prismatic";
  return "<joint name='" + name + "' type='" + type + "'><parent link='" + parent +
         "'/><child link='" + child + "'/>" + inner +
         (limited && inner.find("<limit") == std::string::npos
              ? "<limit lower='-1' upper='2' velocity='3' effort='1'/>"
              : "") +
         "</joint>\n";
}

std::string Links(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += "<link name='" + name + "'/>\n";
  return text;
}

std::string Robot(const std::string& inner) {
  return "<?xml version='1.0'?>\n<robot name='test'>\n" + inner + "</robot>\n";
}

// One revolute joint about z between links a and b, with bodies in the link a.
std::string OneJoint(const std::string& in_link_a, const std::string& in_link_b = "") {
  return Robot("<link name='a'>" + in_link_a + "</link>\n<link name='b'>" + in_link_b +
               "</link>\n" +
               Joint("j", "revolute", "a", "b", "<axis xyz='0 0 1'/><origin xyz='0 0 0.5'/>"));
}

class Urdf : public ::testing::Test {
 protected:
  [[nodiscard]] UrdfArm Load(const std::string& text, const std::string& base = "",
                             const std::string& tip = "", const UrdfOptions& options = {}) const {
    return LoadUrdfArm(folder_.Write("arm.urdf", text), base, tip, options);
  }
  // The message without the path of the temporary file's folder.
  [[nodiscard]] std::string ErrorOf(const std::string& text, const std::string& base = "",
                                    const std::string& tip = "") const {
    return Short(test::ConfigErrorOf([&] { (void)Load(text, base, tip); }));
  }
  [[nodiscard]] std::string Short(std::string text) const {
    const std::string path = folder_.path().string() + "/";
    for (std::size_t at = text.find(path); at != std::string::npos; at = text.find(path)) {
      text.erase(at, path.size());
    }
    return text;
  }
  const test::TemporaryFolder folder_;
};

JointVector RandomJoints(const ArmModel& arm, std::mt19937* random) {
  JointVector q(arm.size());
  for (int i = 0; i < arm.size(); ++i) {
    const JointLimits& limit = arm.limits()[i];
    q(i) = std::uniform_real_distribution<double>(limit.lower, limit.upper)(*random);
  }
  return q;
}

// --- the example files -----------------------------------------------------------------------------

class ExampleArm : public ::testing::TestWithParam<const char*> {};

// The oracle's cases name base and tool; with those in place of the file's, pose and Jacobian agree.
TEST_P(ExampleArm, AgreesWithTheOracle) {
  const UrdfArm urdf = LoadUrdfArm(kRobots + GetParam() + ".urdf");
  const nlohmann::json oracles = test::ReadOracles();
  std::mt19937 random(7);
  int cases = 0;
  for (const auto& test_case : oracles.at("cases")) {
    const auto& robot = test_case.at("robot");
    if (robot.at("name") != GetParam()) continue;
    SCOPED_TRACE(test_case.at("id").get<std::string>());
    ++cases;
    const ArmModel dh = test::OracleArm(robot);
    ASSERT_EQ(dh.size(), urdf.arm.size());
    // The file's last frame lies elsewhere on the last body than the table's: by a constant.
    const JointVector zero = JointVector::Zero(dh.size());
    const Isometry3d X_EO =
        (dh.X_WBase() * EndEffectorPose(urdf.arm, zero)).inverse() * EndEffectorPose(dh, zero);
    const ArmModel arm = urdf.arm.WithBase(dh.X_WBase()).WithTool(urdf.arm.X_LastE() * X_EO);
    const Kinematics kinematics = ComputeKinematics(arm, test::OracleJoints(test_case.at("q")));
    const Eigen::MatrixXd X_WE = test::OracleMatrix(test_case.at("expected").at("T_ee"));
    const Eigen::MatrixXd J = test::OracleMatrix(test_case.at("expected").at("J_r"));
    EXPECT_TRUE(test::Near(kinematics.X_WE.matrix(), X_WE, 1e-12));
    EXPECT_TRUE(test::Near(kinematics.J_WE_W, J, 1e-11 * J.cwiseAbs().maxCoeff()));
    // And the constant is the one the tables say: the flange, 107 mm beyond the Panda's last frame.
    Isometry3d expected = Isometry3d::Identity();
    if (std::string(GetParam()) == "panda") expected.translation().z() = -0.107;
    EXPECT_TRUE(
        test::Near(X_EO.matrix(), (expected * test::OraclePose(robot.at("tool"))).matrix(), 1e-12));
    for (int i = 0; i < 20; ++i) {
      const JointVector q = RandomJoints(urdf.arm, &random);
      EXPECT_TRUE(
          test::Near(EndEffectorPose(arm, q).matrix(), EndEffectorPose(dh, q).matrix(), 1e-12));
    }
  }
  EXPECT_GT(cases, 0);
}

TEST_P(ExampleArm, LoadsWithoutWarnings) {
  const UrdfArm urdf = LoadUrdfArm(kRobots + GetParam() + ".urdf");
  EXPECT_TRUE(urdf.warnings.empty()) << urdf.warnings.front();
  EXPECT_EQ(urdf.arm.name(), GetParam());
  EXPECT_EQ(urdf.arm.visuals().size(), static_cast<std::size_t>(urdf.arm.size()) + 1u);
}

// Each vertex that is drawn lies in a capsule of the same link, or sticks out by a little where the
// capsules are fitted to simpler collision shapes.
TEST_P(ExampleArm, HasCapsulesRoundItsMeshes) {
  const ArmModel arm = LoadUrdfArm(kRobots + GetParam() + ".urdf").arm;
  const double allowance = std::string(GetParam()) == "panda" ? 1e-6 : 0.012;
  for (const ArmVisual& visual : arm.visuals()) {
    double worst = -1.0;
    for (const MeshPart& part : ReadMeshFile(std::get<MeshShape>(visual.shape).path)) {
      for (const Eigen::Vector3f& vertex : part.vertices) {
        const Vector3d p = visual.X_LV * vertex.cast<double>();
        double nearest = 1.0;
        for (const Capsule& c : arm.capsules()) {
          if (c.link != visual.link) continue;
          const Vector3d along = c.p_LB - c.p_LA;
          const double s =
              std::clamp((p - c.p_LA).dot(along) / std::max(along.squaredNorm(), 1e-12), 0.0, 1.0);
          nearest = std::min(nearest, (p - c.p_LA - s * along).norm() - c.radius);
        }
        worst = std::max(worst, nearest);
      }
    }
    EXPECT_LE(worst, allowance) << "link " << visual.link;
  }
}

INSTANTIATE_TEST_SUITE_P(Files, ExampleArm, ::testing::Values("ur5", "panda"),
                         [](const auto& test) { return std::string(test.param); });

TEST(ExampleUr5, HasTheMakersLimitsAndTool0) {
  const UrdfArm urdf = LoadUrdfArm(kRobots + "ur5.urdf");
  EXPECT_EQ(urdf.base_link, "base");
  EXPECT_EQ(urdf.tip_link, "tool0");
  for (const JointLimits& limit : urdf.arm.limits()) {
    EXPECT_DOUBLE_EQ(limit.lower, -2.0 * kPi);
    EXPECT_DOUBLE_EQ(limit.upper, 2.0 * kPi);
    EXPECT_DOUBLE_EQ(limit.velocity, kPi);
    EXPECT_DOUBLE_EQ(limit.acceleration, 5.0 * kPi);
  }
}

// --- the chain -------------------------------------------------------------------------------------

TEST_F(Urdf, MergesFixedJointsAndKeepsAxes) {
  const UrdfArm urdf = Load(
      Robot(Links({"base", "pole", "arm", "bracket", "slide", "tool"}) +
            Joint("up", "fixed", "base", "pole", "<origin xyz='0.1 0.2 0.3' rpy='0.3 -0.4 0.5'/>") +
            Joint("turn", "revolute", "pole", "arm",
                  "<origin xyz='0 0 0.4' rpy='0.1 0.2 -0.3'/><axis xyz='1 2 -2'/>") +
            Joint("hold", "fixed", "arm", "bracket", "<origin xyz='0.5 0 0' rpy='0 1.2 0'/>") +
            Joint("push", "prismatic", "bracket", "slide",
                  "<origin xyz='0 0.6 0' rpy='-0.7 0 0'/><axis xyz='0 -3 4'/>") +
            Joint("mount", "fixed", "slide", "tool", "<origin xyz='0 0 0.7' rpy='0 0 0.9'/>")));
  EXPECT_EQ(urdf.base_link, "base");
  EXPECT_EQ(urdf.tip_link, "tool");
  ASSERT_EQ(urdf.arm.size(), 2);
  EXPECT_EQ(urdf.arm.joint_names(), (std::vector<std::string>{"turn", "push"}));
  EXPECT_EQ(urdf.arm.joint_kinds()[0], JointKind::kRevolute);
  EXPECT_EQ(urdf.arm.joint_kinds()[1], JointKind::kPrismatic);

  const auto origin = [](const Vector3d& p, double roll, double pitch, double yaw) {
    return Isometry3d(Translation3d(p)) * AngleAxisd(yaw, Vector3d::UnitZ()) *
           AngleAxisd(pitch, Vector3d::UnitY()) * AngleAxisd(roll, Vector3d::UnitX());
  };
  const Eigen::Vector2d q(0.8, 0.25);
  const Isometry3d X_W0 = origin({0.1, 0.2, 0.3}, 0.3, -0.4, 0.5) *
                          origin({0, 0, 0.4}, 0.1, 0.2, -0.3) *
                          AngleAxisd(q(0), Vector3d(1, 2, -2) / 3.0);
  const Isometry3d X_W1 = X_W0 * origin({0.5, 0, 0}, 0, 1.2, 0) * origin({0, 0.6, 0}, -0.7, 0, 0) *
                          Translation3d(q(1) * Vector3d(0, -0.6, 0.8));
  const Isometry3d X_WE = X_W1 * origin({0, 0, 0.7}, 0, 0, 0.9);
  const LinkPoses links = ComputeLinkPoses(urdf.arm, q);
  EXPECT_TRUE(test::Near(links[0].matrix(), X_W0.matrix(), 1e-14));
  EXPECT_TRUE(test::Near(links[1].matrix(), X_W1.matrix(), 1e-14));
  EXPECT_TRUE(test::Near(EndEffectorPose(urdf.arm, q).matrix(), X_WE.matrix(), 1e-14));
}

TEST_F(Urdf, WithoutAnAxisTurnsAboutX) {
  const UrdfArm urdf = Load(Robot(Links({"a", "b"}) + Joint("j", "revolute", "a", "b")));
  EXPECT_TRUE(test::Near(EndEffectorPose(urdf.arm, JointVector::Constant(1, 0.5)).linear(),
                         AngleAxisd(0.5, Vector3d::UnitX()).toRotationMatrix(), 1e-15));
}

TEST_F(Urdf, TakesLimitsFromTheFileAndChoosesAccelerations) {
  UrdfOptions options;
  options.acceleration_time = 0.5;
  const UrdfArm urdf =
      Load(Robot(Links({"a", "b"}) + Joint("j", "revolute", "a", "b")), "", "", options);
  const JointLimits limit = urdf.arm.limits()[0];
  EXPECT_EQ(limit.lower, -1.0);
  EXPECT_EQ(limit.upper, 2.0);
  EXPECT_EQ(limit.velocity, 3.0);
  EXPECT_EQ(limit.acceleration, 6.0);
  ASSERT_EQ(urdf.notes.size(), 1u);
  EXPECT_EQ(
      Short(urdf.notes[0]),
      "arm.urdf: URDF has no acceleration limits; each joint reaches its greatest speed in 0.5 s");
}

TEST_F(Urdf, GivesContinuousJointsARange) {
  const UrdfArm urdf =
      Load(Robot(Links({"a", "b", "c"}) + Joint("free", "continuous", "a", "b") +
                 Joint("fast", "continuous", "b", "c", "<limit velocity='4' effort='1'/>")));
  ASSERT_EQ(urdf.arm.size(), 2);
  for (const JointLimits& limit : urdf.arm.limits()) {
    EXPECT_DOUBLE_EQ(limit.lower, -2.0 * kPi);
    EXPECT_DOUBLE_EQ(limit.upper, 2.0 * kPi);
  }
  EXPECT_EQ(urdf.arm.limits()[0].velocity, 1.0);
  EXPECT_EQ(urdf.arm.limits()[1].velocity, 4.0);
  EXPECT_EQ(Short(urdf.notes.at(0)),
            "arm.urdf:6: joint 'free' is continuous: its range is taken as -360 to 360 deg, its "
            "greatest speed as 1 rad/s");
  EXPECT_EQ(Short(urdf.notes.at(1)),
            "arm.urdf:7: joint 'fast' is continuous: its range is taken as -360 to 360 deg");
}

TEST_F(Urdf, TakesTheLongestChainByDefault) {
  const UrdfArm urdf =
      Load(Robot(Links({"a", "b", "c", "d", "e"}) + Joint("j1", "revolute", "a", "b") +
                 Joint("j2", "revolute", "b", "c") + Joint("side", "revolute", "a", "d") +
                 Joint("pad", "fixed", "d", "e")));
  EXPECT_EQ(urdf.tip_link, "c");
  EXPECT_EQ(urdf.arm.joint_names(), (std::vector<std::string>{"j1", "j2"}));
  EXPECT_EQ(Short(urdf.notes.at(0)), "arm.urdf: joints off the chain to 'c' do not move: 'side'");
}

TEST_F(Urdf, PrefersWellKnownTipsThenTheFarthest) {
  const std::string common = Links({"a", "b", "x", "y", "z"}) + Joint("j", "revolute", "a", "b") +
                             Joint("jx", "fixed", "b", "x") + Joint("jy", "fixed", "x", "y");
  const auto tip = [&](const std::string& name) {
    return Load(Robot("<link name='" + name + "'/>" + common + Joint("jz", "fixed", "b", "z") +
                      Joint("jn", "fixed", "b", name)))
        .tip_link;
  };
  EXPECT_EQ(tip("left_tool0"), "left_tool0");
  EXPECT_EQ(tip("hand_tcp"), "hand_tcp");
  EXPECT_EQ(tip("ee_link"), "ee_link");
  EXPECT_EQ(tip("other"), "y");
}

// A gripper whose second finger mimics its first: the arm ends before both.
TEST_F(Urdf, EndsBeforeAGripper) {
  const UrdfArm urdf =
      Load(Robot(Links({"a", "b", "hand", "left", "right"}) + Joint("j", "revolute", "a", "b") +
                 Joint("jh", "fixed", "b", "hand") + Joint("jl", "prismatic", "hand", "left") +
                 Joint("jr", "prismatic", "hand", "right", "<mimic joint='jl'/>")));
  EXPECT_EQ(urdf.arm.size(), 1);
  EXPECT_EQ(urdf.tip_link, "hand");
}

TEST_F(Urdf, StartsAndEndsWhereItIsTold) {
  const std::string text =
      Robot(Links({"world", "table", "a", "b", "c"}) +
            Joint("stand", "fixed", "world", "table", "<origin xyz='5 0 0'/>") +
            Joint("bolt", "fixed", "table", "a", "<origin xyz='0 6 0' rpy='0 0 1'/>") +
            Joint("j1", "revolute", "a", "b", "<origin xyz='0 0 1'/><axis xyz='0 0 1'/>") +
            Joint("j2", "revolute", "b", "c", "<origin xyz='0 0 2'/><axis xyz='0 0 1'/>"));
  const UrdfArm urdf = Load(text, "a", "b");
  EXPECT_EQ(urdf.base_link, "a");
  EXPECT_EQ(urdf.tip_link, "b");
  ASSERT_EQ(urdf.arm.size(), 1);
  // The world frame is the base link's.
  EXPECT_TRUE(test::Near(EndEffectorPose(urdf.arm, JointVector::Zero(1)).translation(),
                         Vector3d(0, 0, 1), 1e-15));
  // From the file's root the table stands in between.
  EXPECT_TRUE(
      test::Near(EndEffectorPose(Load(text, "", "b").arm, JointVector::Zero(1)).translation(),
                 Vector3d(5, 6, 1), 1e-15));
}

TEST_F(Urdf, TakesAsManyJointsAsThereMayBe) {
  const auto chain = [](int joints) {
    std::string inner = Links({"l0"});
    for (int i = 1; i <= joints; ++i) {
      const std::string n = std::to_string(i);
      inner += Links({"l" + n}) + Joint("j" + n, "revolute", "l" + std::to_string(i - 1), "l" + n);
    }
    return Robot(inner);
  };
  EXPECT_EQ(Load(chain(kMaxJoints)).arm.size(), kMaxJoints);
  EXPECT_EQ(ErrorOf(chain(kMaxJoints + 1)),
            "arm.urdf:36: link 'l17': 17 joints move between it and the base link 'l0'; at most 16 "
            "are taken");
  EXPECT_EQ(Load(chain(kMaxJoints + 1), "", "l16").arm.size(), kMaxJoints);
}

struct Refusal {
  const char* name;
  std::string inner;  // Of <robot>.
  const char* base;
  const char* tip;
  const char* message;
};

class UrdfRefusal : public Urdf, public ::testing::WithParamInterface<Refusal> {};

TEST_P(UrdfRefusal, NamesFileElementAndReason) {
  EXPECT_EQ(ErrorOf(Robot(GetParam().inner), GetParam().base, GetParam().tip), GetParam().message);
}

const std::string kAb = Links({"a", "b"});

INSTANTIATE_TEST_SUITE_P(
    Each, UrdfRefusal,
    ::testing::Values(
        Refusal{"UnknownBase", kAb + Joint("j", "revolute", "a", "b"), "c", "",
                "arm.urdf: base link 'c' is no link of this file; its links: 'a', 'b'"},
        Refusal{"UnknownTip", kAb + Joint("j", "revolute", "a", "b"), "", "c",
                "arm.urdf: tip link 'c' is no link of this file; its links: 'a', 'b'"},
        Refusal{"TipAboveBase", kAb + Joint("j", "revolute", "a", "b"), "b", "a",
                "arm.urdf:3: link 'a': the tip link is not below the base link 'b'"},
        Refusal{"NothingMoves", kAb + Joint("j", "fixed", "a", "b"), "", "",
                "arm.urdf:3: link 'a': no joint of an arm moves below this base link"},
        Refusal{"NothingMovesToTheTip", kAb + Joint("j", "fixed", "a", "b"), "", "b",
                "arm.urdf:4: link 'b': no joint moves between it and the base link 'a'"},
        Refusal{
            "Branches",
            Links({"a", "b", "c", "d"}) + Joint("j", "revolute", "a", "b") +
                Joint("l", "revolute", "b", "c") + Joint("r", "revolute", "b", "d"),
            "", "",
            "arm.urdf:4: link 'b': the arm branches here, and no branch is longer than the others: "
            "name the tip link, for instance 'c' or 'd'"},
        Refusal{
            "Floating", kAb + Joint("j", "floating", "a", "b"), "", "b",
            "arm.urdf:5: joint 'j': is floating: an arm has revolute, continuous, prismatic and "
            "fixed joints"},
        Refusal{"Planar", kAb + Joint("j", "planar", "a", "b"), "", "b",
                "arm.urdf:5: joint 'j': is planar: an arm has revolute, continuous, prismatic and "
                "fixed joints"},
        Refusal{"Mimic",
                Links({"a", "b", "c"}) + Joint("i", "revolute", "a", "b") +
                    Joint("j", "revolute", "b", "c", "<mimic joint='i'/>"),
                "", "c", "arm.urdf:7: joint 'j': mimics 'i': an arm's joints move on their own"},
        Refusal{
            "NoLimits",
            kAb + "<joint name='j' type='revolute'><parent link='a'/><child link='b'/></joint>", "",
            "",
            "arm.urdf:5: not a valid URDF: Joint [j] is of type REVOLUTE but it does not specify "
            "limits"},
        Refusal{
            "NoVelocity",
            kAb + Joint("j", "revolute", "a", "b", "<limit lower='0' upper='1' effort='1'/>"), "",
            "",
            "arm.urdf:5: not a valid URDF: joint limit: no velocity; Could not parse limit element "
            "for joint [j]"},
        Refusal{"NoRange",
                kAb + Joint("j", "revolute", "a", "b", "<limit velocity='1' effort='1'/>"), "", "",
                "arm.urdf:5: joint 'j': limit: upper must be above lower, are 0 and 0"},
        Refusal{"NoSpeed",
                kAb + Joint("j", "prismatic", "a", "b",
                            "<limit lower='0' upper='1' velocity='0' effort='1'/>"),
                "", "", "arm.urdf:5: joint 'j': limit: velocity must be > 0, is 0"},
        Refusal{"NoAxis", kAb + Joint("j", "revolute", "a", "b", "<axis xyz='0 0 0'/>"), "", "",
                "arm.urdf:5: joint 'j': axis must be finite and not zero"},
        Refusal{"UnknownType",
                kAb + "<joint name='j' type='screw'><parent link='a'/><child link='b'/></joint>",
                "", "", "arm.urdf:5: not a valid URDF: Joint [j] has no known type [screw]"},
        Refusal{
            "NoSuchChild", Links({"a"}) + Joint("j", "revolute", "a", "b"), "", "",
            "arm.urdf:4: not a valid URDF: Failed to build tree: child link [b] of joint [j] not "
            "found"},
        Refusal{
            "TwoRoots", kAb, "", "",
            "arm.urdf:3: not a valid URDF: Failed to find root link: Two root links found: [a] and "
            "[b]"},
        Refusal{"TwoParents",
                Links({"a", "b", "c"}) + Joint("i", "revolute", "a", "b") +
                    Joint("j", "fixed", "b", "c") + Joint("k", "fixed", "a", "c"),
                "", "", "arm.urdf:5: link 'c': is the child of two joints, 'j' and 'k'"},
        Refusal{"CircleBesideTheTree",
                Links({"a", "b", "c", "d"}) + Joint("i", "revolute", "a", "b") +
                    Joint("j", "fixed", "c", "d") + Joint("k", "fixed", "d", "c"),
                "", "", "arm.urdf:5: link 'c': is in a circle of joints"},
        Refusal{"ShapeWithoutSize",
                "<link name='a'><collision><geometry><sphere "
                "radius='0'/></geometry></collision></link>" +
                    Links({"b"}) + Joint("j", "revolute", "a", "b"),
                "", "", "arm.urdf:3: link 'a': collision: a sphere needs a radius > 0, has 0"},
        Refusal{"NotExpanded", kAb + "<xacro:arm prefix='x'/>" + Joint("j", "revolute", "a", "b"),
                "", "",
                "arm.urdf:5: <xacro:arm> must be expanded first: xacro FILE.xacro > FILE.urdf"}),
    [](const auto& test) { return test.param.name; });

TEST_F(Urdf, RefusesWhatIsNoUrdfFile) {
  const auto message = [&](const std::string& text) { return ErrorOf(text); };
  EXPECT_EQ(message("<robot name='x'>\n<link name='a'>\n</robot>"),
            "arm.urdf:2: not valid XML: mismatched element");
  EXPECT_EQ(message(""), "arm.urdf: not valid XML: empty document");
  EXPECT_EQ(message("<sdf version='1.6'/>"),
            "arm.urdf:1: is no URDF: the root element must be <robot>, is <sdf>");
  EXPECT_EQ(message("<robot>" + kAb + Joint("j", "revolute", "a", "b") + "</robot>"),
            "arm.urdf: not a valid URDF: No name given for the robot.");
}

TEST_F(Urdf, RefusesWhatIsNoFile) {
  const std::string folder = folder_.path().string();
  EXPECT_EQ(test::ConfigErrorOf([&] { (void)LoadUrdfArm(folder); }), folder + ": is a directory");
  EXPECT_EQ(test::ConfigErrorOf([&] { (void)LoadUrdfArm(folder + "/none.urdf"); }),
            folder + "/none.urdf: cannot be opened: No such file or directory");
}

TEST_F(Urdf, RefusesAnAccelerationTimeOfNothing) {
  UrdfOptions options;
  options.acceleration_time = 0.0;
  EXPECT_EQ(test::ConfigErrorOf([&] { (void)Load(OneJoint(""), "", "", options); }),
            "acceleration_time: must be finite and > 0 s, is 0");
}

// --- bodies ----------------------------------------------------------------------------------------

std::string Shape(const std::string& kind, const std::string& geometry,
                  const std::string& origin = "") {
  return "<" + kind + "><geometry>" + geometry + "</geometry>" + origin + "</" + kind + ">";
}

// One triangle in the plane z = 0.
const std::string kTriangle = "v 0 0 0\nv 0.4 0 0\nv 0 0.3 0\nf 1 2 3\n";

TEST_F(Urdf, FitsCapsulesToCollisionShapes) {
  const UrdfArm urdf =
      Load(OneJoint(Shape("collision", "<sphere radius='0.2'/>", "<origin xyz='1 2 3'/>") +
                        Shape("visual", "<sphere radius='7'/>"),
                    Shape("collision", "<cylinder radius='0.1' length='1'/>",
                          "<origin xyz='0 0 0.5' rpy='1.5707963267948966 0 0'/>")));
  ASSERT_EQ(urdf.arm.capsules().size(), 2u);
  const Capsule& ball = urdf.arm.capsules()[0];
  EXPECT_EQ(ball.link, -1);
  EXPECT_EQ(ball.p_LA, Vector3d(1, 2, 3));
  EXPECT_EQ(ball.p_LB, Vector3d(1, 2, 3));
  EXPECT_DOUBLE_EQ(ball.radius, 0.2);
  const Capsule& rod = urdf.arm.capsules()[1];
  EXPECT_EQ(rod.link, 0);
  EXPECT_NEAR(rod.p_LA.z(), 0.5, 1e-12);
  EXPECT_NEAR(std::abs(rod.p_LA.y()), std::abs(rod.p_LB.y()), 1e-12);
  EXPECT_LT(std::abs(rod.p_LA.y()), 0.5);
  EXPECT_GT(rod.radius, 0.1);
  EXPECT_LT(rod.radius, 0.11);
  // The visuals are the file's.
  ASSERT_EQ(urdf.arm.visuals().size(), 1u);
  EXPECT_EQ(std::get<SphereShape>(urdf.arm.visuals()[0].shape).radius, 7.0);
}

TEST_F(Urdf, FitsCapsulesToVisualShapesWhereThereAreNoOthers) {
  const UrdfArm urdf = Load(OneJoint("", Shape("visual", "<box size='0.1 0.1 1'/>")));
  ASSERT_EQ(urdf.arm.capsules().size(), 1u);
  const Capsule& rod = urdf.arm.capsules()[0];
  EXPECT_EQ(rod.link, 0);
  EXPECT_LT(std::abs(rod.p_LA.x()) + std::abs(rod.p_LA.y()), 1e-3);
  EXPECT_GT(std::abs(rod.p_LA.z()), 0.4);
  EXPECT_NEAR(rod.radius, 0.05 * std::sqrt(2.0), 0.005);
}

TEST_F(Urdf, CarriesBodiesOfFixedLinksAlong) {
  const UrdfArm urdf = Load(
      Robot(
          "<link name='table'>" + Shape("collision", "<sphere radius='0.3'/>") + "</link>" +
          Links({"a", "b"}) + "<link name='tool'>" + Shape("visual", "<sphere radius='0.1'/>") +
          "</link><link name='lid'>" + Shape("visual", "<sphere radius='0.2'/>") + "</link>" +
          Joint("stand", "fixed", "table", "a", "<origin xyz='0 0 1'/>") +
          Joint("j", "revolute", "a", "b", "<axis xyz='0 0 1'/>") +
          Joint("mount", "fixed", "b", "tool", "<origin xyz='2 0 0'/>") +
          Joint("hinge", "revolute", "a", "lid",
                "<origin xyz='0 0 5'/><axis xyz='0 0 1'/><limit lower='0.5' upper='1' velocity='1' "
                "effort='1'/>")),
      "a", "tool");
  ASSERT_EQ(urdf.arm.capsules().size(), 3u);
  ASSERT_EQ(urdf.arm.visuals().size(), 2u);
  for (const Capsule& capsule : urdf.arm.capsules()) {
    if (capsule.radius == 0.3) {  // What stands under the base is fixed to it.
      EXPECT_EQ(capsule.link, -1);
      EXPECT_TRUE(test::Near(capsule.p_LA, Vector3d(0, 0, -1), 1e-15));
    } else if (capsule.radius == 0.1) {
      EXPECT_EQ(capsule.link, 0);
      EXPECT_TRUE(test::Near(capsule.p_LA, Vector3d(2, 0, 0), 1e-15));
    } else {
      EXPECT_EQ(capsule.link, -1);
      EXPECT_TRUE(test::Near(capsule.p_LA, Vector3d(0, 0, 5), 1e-15));
    }
  }
  // A joint off the chain stands at the value nearest to 0 that it may have.
  EXPECT_TRUE(test::Near(urdf.arm.visuals()[0].X_LV.linear(),
                         AngleAxisd(0.5, Vector3d::UnitZ()).toRotationMatrix(), 1e-15));
}

TEST_F(Urdf, LeavesOutCapsulesInsideOthers) {
  const std::string ball = Shape("collision", "<sphere radius='0.2'/>");
  const std::string small =
      Shape("collision", "<sphere radius='0.1'/>", "<origin xyz='0.05 0 0'/>");
  const std::string out = Shape("collision", "<sphere radius='0.1'/>", "<origin xyz='0.15 0 0'/>");
  EXPECT_EQ(Load(OneJoint(small + ball)).arm.capsules().size(), 1u);
  EXPECT_EQ(Load(OneJoint(ball + ball)).arm.capsules().size(), 1u);
  EXPECT_EQ(Load(OneJoint(ball + out)).arm.capsules().size(), 2u);
  EXPECT_EQ(Load(OneJoint(ball, ball)).arm.capsules().size(), 2u);  // Of two links.
}

TEST_F(Urdf, ReadsColours) {
  const std::string ball = "<geometry><sphere radius='1'/></geometry>";
  const UrdfArm urdf = Load(
      Robot("<material name='shared'><color rgba='1 0.5 0 1'/></material>"
            "<link name='a'><visual>" +
            ball +
            "<material name='own'><color rgba='0.1 0.2 0.3 1'/></material></visual>"
            "<visual>" +
            ball +
            "<material name='shared'/></visual>"
            "<visual>" +
            ball +
            "</visual>"
            "<visual>" +
            ball + "<material name='glass'><color rgba='1 1 1 0'/></material></visual></link>" +
            Links({"b"}) + Joint("j", "revolute", "a", "b")));
  ASSERT_EQ(urdf.arm.visuals().size(), 3u);
  EXPECT_TRUE(test::Near(*urdf.arm.visuals()[0].colour, Eigen::Vector3f(0.1F, 0.2F, 0.3F), 1e-6));
  EXPECT_TRUE(test::Near(*urdf.arm.visuals()[1].colour, Eigen::Vector3f(1, 0.5F, 0), 1e-6));
  EXPECT_FALSE(urdf.arm.visuals()[2].colour.has_value());
}

TEST_F(Urdf, FindsMeshesBesideTheFileAndInPackages) {
  folder_.Write("meshes/part.obj", kTriangle);
  folder_.Write("ws/src/my_arm-1.2/package.xml", "<package><name>my_arm</name></package>");
  folder_.Write("ws/src/my_arm-1.2/meshes/own.obj", kTriangle);
  folder_.Write("ws/src/other_arm/meshes/other.obj", kTriangle);
  folder_.Write("elsewhere/third/meshes/third.obj", kTriangle);
  const std::string absolute = (folder_.path() / "meshes/part.obj").string();
  UrdfOptions options;
  options.package_folders = {(folder_.path() / "elsewhere").string()};
  const auto path_of = [&](const std::string& name) {
    const std::string text =
        OneJoint(Shape("visual", "<mesh filename='" + name + "' scale='1 2 -3'/>"));
    const UrdfArm urdf =
        LoadUrdfArm(folder_.Write("ws/src/my_arm-1.2/urdf/arm.urdf", text), "", "", options);
    if (!urdf.warnings.empty()) return urdf.warnings[0];
    const MeshShape& mesh = std::get<MeshShape>(urdf.arm.visuals().at(0).shape);
    EXPECT_EQ(mesh.scale, Vector3d(1, 2, -3));
    EXPECT_FALSE(urdf.arm.capsules().empty());
    return std::filesystem::canonical(mesh.path).string();
  };
  const auto at = [&](const char* name) {
    return std::filesystem::canonical(folder_.path() / name).string();
  };
  EXPECT_EQ(path_of("../meshes/own.obj"), at("ws/src/my_arm-1.2/meshes/own.obj"));
  EXPECT_EQ(path_of(absolute), at("meshes/part.obj"));
  EXPECT_EQ(path_of("file://" + absolute), at("meshes/part.obj"));
  EXPECT_EQ(path_of("package://my_arm/meshes/own.obj"), at("ws/src/my_arm-1.2/meshes/own.obj"));
  EXPECT_EQ(path_of("package://other_arm/meshes/other.obj"),
            at("ws/src/other_arm/meshes/other.obj"));
  EXPECT_EQ(path_of("model://third/meshes/third.obj"), at("elsewhere/third/meshes/third.obj"));
  // Out of its package, but below a folder above the file.
  EXPECT_EQ(path_of("package://lost/meshes/part.obj"), at("meshes/part.obj"));
}

TEST_F(Urdf, ReplacesAMissingMeshByACapsuleFromJointToJoint) {
  const std::string mesh = "<mesh filename='part.stl'/>";
  const UrdfArm urdf = Load(OneJoint(Shape("visual", mesh) + Shape("collision", mesh)));
  ASSERT_EQ(urdf.warnings.size(), 1u);  // Both name the same file.
  EXPECT_EQ(
      Short(urdf.warnings[0]),
      "arm.urdf:3: link 'a', visual: mesh 'part.stl' not found: no file part.stl; capsules stand "
      "in");
  ASSERT_EQ(urdf.arm.capsules().size(), 1u);
  const Capsule& capsule = urdf.arm.capsules()[0];
  EXPECT_EQ(capsule.p_LA, Vector3d(0, 0, 0));
  EXPECT_EQ(capsule.p_LB, Vector3d(0, 0, 0.5));
  EXPECT_GT(capsule.radius, 0.0);
  ASSERT_EQ(urdf.arm.visuals().size(), 1u);
  const CapsuleShape& seen = std::get<CapsuleShape>(urdf.arm.visuals()[0].shape);
  EXPECT_EQ(seen.p_B, capsule.p_LB);
  EXPECT_EQ(seen.radius, capsule.radius);
}

TEST_F(Urdf, FitsTheVisualMeshWhereTheCollisionMeshIsMissing) {
  folder_.Write("part.obj", kTriangle);
  const UrdfArm urdf = Load(OneJoint(Shape("visual", "<mesh filename='part.obj'/>") +
                                     Shape("collision", "<mesh filename='hull.stl'/>")));
  ASSERT_EQ(urdf.warnings.size(), 1u);
  EXPECT_NE(urdf.warnings[0].find("collision: mesh 'hull.stl' not found"), std::string::npos);
  ASSERT_FALSE(urdf.arm.capsules().empty());
  for (const Capsule& capsule : urdf.arm.capsules()) {
    EXPECT_LT(std::abs(capsule.p_LB.z()), 0.1);  // Not up to the joint.
  }
  EXPECT_EQ(urdf.arm.visuals().size(), 1u);
}

TEST_F(Urdf, DrawsTheCollisionBodyWhereTheVisualMeshIsMissing) {
  const UrdfArm urdf = Load(OneJoint(Shape("visual", "<mesh filename='part.obj'/>") +
                                     Shape("collision", "<sphere radius='0.25'/>")));
  EXPECT_EQ(urdf.warnings.size(), 1u);
  ASSERT_EQ(urdf.arm.visuals().size(), 1u);
  EXPECT_EQ(std::get<CapsuleShape>(urdf.arm.visuals()[0].shape).radius, 0.25);
}

TEST_F(Urdf, ReplacesABrokenMesh) {
  folder_.Write("part.stl", "no mesh at all");
  const UrdfArm urdf = Load(OneJoint(Shape("collision", "<mesh filename='part.stl'/>")));
  ASSERT_EQ(urdf.warnings.size(), 1u);
  EXPECT_EQ(Short(urdf.warnings[0])
                .rfind("arm.urdf:3: link 'a', collision: part.stl: cannot be read as a mesh: ", 0),
            0u)
      << urdf.warnings[0];
  EXPECT_EQ(urdf.arm.capsules().at(0).p_LB, Vector3d(0, 0, 0.5));
}

TEST_F(Urdf, WarnsOnceOfAMissingPackage) {
  const auto mesh = [](const std::string& name) {
    return Shape("visual", "<mesh filename='package://arm_parts/" + name + ".stl'/>");
  };
  const UrdfArm urdf = Load(OneJoint(mesh("one") + mesh("two"), mesh("three")));
  ASSERT_EQ(urdf.warnings.size(), 1u);
  EXPECT_EQ(
      Short(urdf.warnings[0]),
      "arm.urdf:3: link 'a', visual: mesh 'package://arm_parts/one.stl' not found among the "
      "package folders or above the URDF file, nor 2 more of package 'arm_parts'; capsules stand "
      "in");
  EXPECT_EQ(urdf.arm.capsules().size(), 2u);
}

TEST_F(Urdf, PassesOnWhatUrdfdomComplainsOf) {
  const UrdfArm urdf = Load(OneJoint(Shape("visual", "<cone radius='1'/>")));
  ASSERT_FALSE(urdf.warnings.empty());
  EXPECT_EQ(Short(urdf.warnings[0]), "arm.urdf: Unknown geometry type 'cone'");
}

TEST(RosPackageFolders, AreThoseOfTheEnvironment) {
  ::setenv("ROS_PACKAGE_PATH", "/one:/two", 1);
  ::setenv("AMENT_PREFIX_PATH", "/opt/ros", 1);
  EXPECT_EQ(RosPackageFolders(), (std::vector<std::string>{"/one", "/two", "/opt/ros/share"}));
  ::unsetenv("ROS_PACKAGE_PATH");
  ::unsetenv("AMENT_PREFIX_PATH");
  EXPECT_TRUE(RosPackageFolders().empty());
}

}  // namespace
}  // namespace vantage
