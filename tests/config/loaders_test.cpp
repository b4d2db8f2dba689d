#include "vantage/config/loaders.h"

#include <functional>

#include <gtest/gtest.h>

#include "config_error.h"
#include "eigen_matchers.h"
#include "temporary_folder.h"
#include "vantage/math/angles.h"
#include "vantage/robot/kinematics.h"

namespace vantage {
namespace {

using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Vector3d;

Section Parse(const std::string& text) {
  return ParseConfig({"file.yaml", "", text});
}

// `text` with the first `from` replaced; fails the test when there is none.
std::string With(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

struct Edit {
  const char* name;
  const char* from;  // In the valid text ...
  const char* to;    // ... becomes this.
  const char* message;
};

// --- robots ---

const char* const kArm = R"(name: arm
convention: modified
joints:
  - {name: turn, d: 0.1, a: 0.2, alpha_deg: 30, offset_deg: 40, lower_deg: -90, upper_deg: 80, max_speed_deg_s: 60, max_acceleration_deg_s2: 120}
  - {name: slide, kind: prismatic, theta_deg: 20, a: 0.3, alpha_deg: 10, offset: 0.4, lower: 0.1, upper: 0.9, max_speed: 0.5, max_acceleration: 2}
base: {position: [1, 2, 3], rpy_deg: [0, 0, 90]}
tool: {quaternion: [0, 1, 0, 0]}
capsules:
  - {link: base, from: [0, 0, 0], to: [0, 0, 1], radius: 0.1}
  - {link: slide, from: [0, 0, 0], to: [1, 0, 0], radius: 0.2}
)";

ArmModel LoadArm(const std::string& text) {
  const Section root = Parse(text);
  ArmModel arm = LoadRobot(root);
  root.RejectUnknownKeys();
  return arm;
}

TEST(LoadRobot, ReadsAllOfIt) {
  const ArmModel arm = LoadArm(kArm);
  EXPECT_EQ(arm.name(), "arm");
  EXPECT_EQ(arm.joint_names(), (std::vector<std::string>{"turn", "slide"}));
  EXPECT_EQ(arm.joint_kinds()[0], JointKind::kRevolute);
  EXPECT_EQ(arm.joint_kinds()[1], JointKind::kPrismatic);
  EXPECT_NEAR(arm.limits()[0].lower, -90 * kDegree, 1e-15);
  EXPECT_NEAR(arm.limits()[0].upper, 80 * kDegree, 1e-15);
  EXPECT_NEAR(arm.limits()[0].velocity, 60 * kDegree, 1e-15);
  EXPECT_NEAR(arm.limits()[0].acceleration, 120 * kDegree, 1e-15);
  EXPECT_EQ(arm.limits()[1].lower, 0.1);
  EXPECT_EQ(arm.limits()[1].upper, 0.9);
  EXPECT_EQ(arm.limits()[1].velocity, 0.5);
  EXPECT_EQ(arm.limits()[1].acceleration, 2.0);
  ASSERT_EQ(arm.capsules().size(), 2u);
  EXPECT_EQ(arm.capsules()[0].link, -1);
  EXPECT_EQ(arm.capsules()[1].link, 1);
  EXPECT_EQ(arm.capsules()[1].p_LB, Vector3d(1, 0, 0));
  EXPECT_EQ(arm.capsules()[1].radius, 0.2);

  const std::vector<DhRow> rows{{JointKind::kRevolute, 0.0, 0.1, 0.2, 30 * kDegree, 40 * kDegree},
                                {JointKind::kPrismatic, 20 * kDegree, 0.0, 0.3, 10 * kDegree, 0.4}};
  Isometry3d base = Isometry3d::Identity();
  base.translate(Vector3d(1, 2, 3)).rotate(AngleAxisd(kPi / 2, Vector3d::UnitZ()));
  Isometry3d tool = Isometry3d::Identity();
  tool.rotate(AngleAxisd(kPi, Vector3d::UnitX()));
  const ArmModel expected("arm", DhConvention::kModified, rows, arm.limits(), base, tool);
  const JointVector q = Eigen::Vector2d(0.7, 0.5);
  EXPECT_TRUE(
      test::Near(EndEffectorPose(arm, q).matrix(), EndEffectorPose(expected, q).matrix(), 1e-14));
}

TEST(LoadRobot, RightAnglesAreTheNearestDoubles) {
  const Section root = Parse("a_deg: 90\nb_deg: -90\nc_deg: 180\n");
  const Range turns{-360, 360, "deg"};
  EXPECT_EQ(root.Degrees("a_deg", turns, kRequired, ""), kPi / 2);
  EXPECT_EQ(root.Degrees("b_deg", turns, kRequired, ""), -kPi / 2);
  EXPECT_EQ(root.Degrees("c_deg", turns, kRequired, ""), kPi);
}

class LoadRobotRefuses : public ::testing::TestWithParam<Edit> {};

TEST_P(LoadRobotRefuses, WithOneLine) {
  ASSERT_NO_THROW((void)LoadArm(kArm));
  const std::string text = With(kArm, GetParam().from, GetParam().to);
  EXPECT_EQ(test::ConfigErrorOf([&] { (void)LoadArm(text); }), GetParam().message);
}

INSTANTIATE_TEST_SUITE_P(
    Edits, LoadRobotRefuses,
    ::testing::Values(
        Edit{"NoName", "name: arm\n", "", "file.yaml:1: name: missing"},
        Edit{"UnknownConvention", "modified", "craig",
             "file.yaml:2: convention: must be one of standard, modified, is 'craig'"},
        Edit{"UnknownKind", "prismatic", "ball",
             "file.yaml:5: joints[1].kind: must be one of revolute, prismatic, is 'ball'"},
        Edit{"RepeatedName", "name: slide", "name: turn",
             "file.yaml:5: joints[1].name: 'turn' names two joints"},
        Edit{"JointNamedBase", "name: slide", "name: base",
             "file.yaml:5: joints[1].name: 'base' is the name of the base"},
        Edit{"NoLimit", "upper_deg: 80, ", "", "file.yaml:4: joints[0].upper_deg: missing"},
        Edit{"EmptyRange", "upper_deg: 80", "upper_deg: -90",
             "file.yaml:4: joints[0].lower_deg: must be below the upper limit"},
        Edit{"EmptyPrismaticRange", "upper: 0.9", "upper: 0.1",
             "file.yaml:5: joints[1].lower: must be below the upper limit"},
        Edit{"RadiansOfADegreeKey", "alpha_deg: 30", "alpha: 0.5",
             "file.yaml:4: joints[0].alpha: unknown key; known here: a, alpha_deg, d, kind, "
             "lower_deg, max_acceleration_deg_s2, max_speed_deg_s, name, offset_deg, upper_deg"},
        Edit{"ThetaOfARevoluteJoint", "d: 0.1", "theta_deg: 10",
             "file.yaml:4: joints[0].theta_deg: unknown key; known here: a, alpha_deg, d, kind, "
             "lower_deg, max_acceleration_deg_s2, max_speed_deg_s, name, offset_deg, upper_deg"},
        Edit{"SpeedZero", "max_speed_deg_s: 60", "max_speed_deg_s: 0",
             "file.yaml:4: joints[0].max_speed_deg_s: must be in [0.0001, 100000] deg/s, is 0"},
        Edit{"LengthNotANumber", "a: 0.2", "a: .nan",
             "file.yaml:4: joints[0].a: must be in [-100, 100] m, is .nan"},
        Edit{"CapsuleOnNoLink", "link: slide", "link: wrist",
             "file.yaml:10: capsules[1].link: must be one of base, turn, slide, is 'wrist'"},
        Edit{"CapsuleRadius", "radius: 0.2", "radius: 0",
             "file.yaml:10: capsules[1].radius: must be in [0.0001, 100] m, is 0"},
        Edit{"QuaternionLength", "[0, 1, 0, 0]", "[0, 1, 0, 1]",
             "file.yaml:7: tool.quaternion: must have length 1, has 1.414214"},
        Edit{"TwoOrientations", "{quaternion: [0, 1, 0, 0]}",
             "{quaternion: [0, 1, 0, 0], rpy_deg: [0, 0, 0]}",
             "file.yaml:7: tool.rpy_deg: must not be given beside quaternion"},
        Edit{"PositionShort", "[1, 2, 3]", "[1, 2]",
             "file.yaml:6: base.position: must be a list of 3 numbers, has 2"},
        Edit{"UnknownKey",
             "base:", "bases:", "file.yaml:6: bases: unknown key; did you mean 'base'?"}),
    [](const auto& test) { return test.param.name; });

TEST(LoadRobot, RefusesTooManyJoints) {
  std::string text = "name: arm\nconvention: standard\njoints:\n";
  for (int i = 0; i < 17; ++i) {
    text += "  - {lower_deg: -1, upper_deg: 1, max_speed_deg_s: 1, max_acceleration_deg_s2: 1}\n";
  }
  EXPECT_EQ(test::ConfigErrorOf([&] { (void)LoadArm(text); }),
            "file.yaml:4: joints: must be a list of 1 to 16 mappings, has 17");
}

TEST(FindRobot, ReadsAFileBesideTheOther) {
  const test::TemporaryFolder folder;
  (void)folder.Write("mine.yaml", kArm);
  EXPECT_EQ(FindRobot("mine.yaml", folder.path().string()).name(), "arm");
}

TEST(FindRobot, NamesTheFileInErrors) {
  const test::TemporaryFolder folder;
  const std::string path = folder.Write("mine.yaml", With(kArm, "name: arm", "nome: arm"));
  EXPECT_EQ(test::ConfigErrorOf([&] { (void)FindRobot(path); }), path + ":1: name: missing");
}

// --- joints ---

TEST(LoadJoints, ReadsDegreesOrRadians) {
  const ArmModel arm = FindRobot("planar2");
  const JointVector expected = Eigen::Vector2d(30 * kDegree, -90 * kDegree);
  EXPECT_TRUE(test::Near(LoadJoints(Parse("q_deg: [30, -90]"), "q", arm, ""), expected, 1e-15));
  EXPECT_TRUE(
      test::Near(LoadJoints(Parse("q: [0.5235987755982988, -1.5707963267948966]"), "q", arm, ""),
                 expected, 1e-15));
}

TEST(LoadJoints, TakesTheLimitsThemselves) {
  const ArmModel arm = FindRobot("planar2");
  const JointVector q = LoadJoints(Parse("q_deg: [170, -160]"), "q", arm, "");
  EXPECT_TRUE(WithinLimits(arm, q));
}

struct JointsRefusal {
  const char* name;
  const char* arm;
  const char* text;
  const char* message;
};

class LoadJointsRefuses : public ::testing::TestWithParam<JointsRefusal> {};

TEST_P(LoadJointsRefuses, WithOneLine) {
  const ArmModel arm = FindRobot(GetParam().arm);
  EXPECT_EQ(test::ConfigErrorOf([&] { (void)LoadJoints(Parse(GetParam().text), "q", arm, ""); }),
            GetParam().message);
}

INSTANTIATE_TEST_SUITE_P(
    Texts, LoadJointsRefuses,
    ::testing::Values(
        JointsRefusal{"Missing", "planar2", "a: 1", "file.yaml:1: q: missing"},
        JointsRefusal{"TooFew", "planar2", "q_deg: [1]",
                      "file.yaml:1: q_deg: must be a list of 2 numbers, has 1"},
        JointsRefusal{"Both", "planar2", "q_deg: [1, 2]\nq: [1, 2]",
                      "file.yaml:2: q: must not be given beside q_deg"},
        JointsRefusal{
            "BeyondALimit", "planar2", "q_deg: [0, 161]",
            "file.yaml:1: q_deg: joint elbow of planar2 must be in [-160, 160] deg, is 161"},
        JointsRefusal{"BelowALimit", "stanford", "q: [0, 0, 0.2, 0, 0, 0]",
                      "file.yaml:1: q: joint boom of stanford must be in [0.3048, 1.27] m, is 0.2"},
        JointsRefusal{
            "DegreesOfAShift", "stanford", "q_deg: [0, 0, 0.5, 0, 0, 0]",
            "file.yaml:1: q_deg: must be given as q (rad and m): joint boom of stanford is "
            "prismatic"}),
    [](const auto& test) { return test.param.name; });

// --- camera ---

TEST(LoadCamera, CentresTheImageByDefault) {
  const CameraModel camera = LoadCamera(Parse("width: 800\nheight: 600\nfx: 700\n"));
  EXPECT_EQ(camera.fy, 700.0);
  EXPECT_EQ(camera.u0, 399.5);
  EXPECT_EQ(camera.v0, 299.5);
  EXPECT_EQ(camera.skew, 0.0);
  EXPECT_TRUE(camera.distortion.none());
}

TEST(LoadCamera, ReadsAllOfIt) {
  const Section root = Parse(
      "{width: 32, height: 16, fx: 10, fy: 11, u0: 12, v0: 13, skew: 0.5,\n"
      " distortion: {k1: 0.1, k2: 0.2, p1: 0.3, p2: 0.4, k3: 0.5}}");
  const CameraModel camera = LoadCamera(root);
  root.RejectUnknownKeys();
  EXPECT_EQ(camera.width, 32);
  EXPECT_EQ(camera.height, 16);
  EXPECT_EQ(camera.fx, 10.0);
  EXPECT_EQ(camera.fy, 11.0);
  EXPECT_EQ(camera.u0, 12.0);
  EXPECT_EQ(camera.v0, 13.0);
  EXPECT_EQ(camera.skew, 0.5);
  EXPECT_EQ(camera.distortion.k1, 0.1);
  EXPECT_EQ(camera.distortion.k2, 0.2);
  EXPECT_EQ(camera.distortion.p1, 0.3);
  EXPECT_EQ(camera.distortion.p2, 0.4);
  EXPECT_EQ(camera.distortion.k3, 0.5);
}

TEST(LoadCamera, RefusesWhatIsOutOfBounds) {
  EXPECT_EQ(test::ConfigErrorOf([] { (void)LoadCamera(Parse("width: 0")); }),
            "file.yaml:1: width: must be in [16, 8192], is 0");
  EXPECT_EQ(test::ConfigErrorOf([] { (void)LoadCamera(Parse("fx: -600")); }),
            "file.yaml:1: fx: must be in [1, 100000] px, is -600");
}

// --- rigs ---

const char* const kRig = R"(kind: spherical
orientation: fixed_down
target: [0.1, 0.2, 0.3]
max_linear_speed: 0.7
axes:
  R: {lower: 1, upper: 3, start: 2, max_speed: 0.5, max_acceleration: 1.5}
  theta: {lower_deg: 0, upper_deg: 90, start_deg: 30, max_speed_deg_s: 20, max_acceleration_deg_s2: 40}
  phi: {lower_deg: -180, upper_deg: 180, start_deg: 45, max_speed_deg_s: 20, max_acceleration_deg_s2: 40}
  roll: {lower_deg: 0, upper_deg: 0, start_deg: 0, max_speed_deg_s: 0}
)";

RigSetup LoadRigText(const std::string& text) {
  const Section root = Parse(text);
  RigSetup setup = LoadRig(root);
  root.RejectUnknownKeys();
  return setup;
}

TEST(LoadRig, ReadsASphericalRig) {
  const RigSetup setup = LoadRigText(kRig);
  EXPECT_EQ(setup.rig.kind, RigKind::kSpherical);
  EXPECT_EQ(setup.rig.orientation, RigOrientation::kFixedDown);
  EXPECT_EQ(setup.rig.target_W, Vector3d(0.1, 0.2, 0.3));
  EXPECT_EQ(setup.rig.max_linear_speed, 0.7);
  ASSERT_EQ(setup.rig.axes.size(), 4u);
  EXPECT_EQ(setup.rig.axes[0].name, "R");
  EXPECT_EQ(setup.rig.axes[0].lower, 1.0);
  EXPECT_EQ(setup.rig.axes[0].upper, 3.0);
  EXPECT_EQ(setup.rig.axes[0].max_speed, 0.5);
  EXPECT_EQ(setup.rig.axes[0].max_acceleration, 1.5);
  EXPECT_NEAR(setup.rig.axes[1].upper, kPi / 2, 1e-15);
  EXPECT_NEAR(setup.rig.axes[2].max_speed, 20 * kDegree, 1e-15);
  EXPECT_NEAR(setup.rig.axes[2].max_acceleration, 40 * kDegree, 1e-15);
  EXPECT_EQ(setup.rig.axes[3].max_speed, 0.0);
  EXPECT_TRUE(
      test::Near(setup.q_c_start, Eigen::Vector4d(2, 30 * kDegree, 45 * kDegree, 0), 1e-15));
}

TEST(LoadRig, ReadsAFixedCamera) {
  const RigSetup setup =
      LoadRigText("kind: fixed\npose: {position: [1, 2, 3], rpy_deg: [180, 0, 0]}");
  EXPECT_EQ(setup.rig.kind, RigKind::kFixed);
  EXPECT_EQ(setup.rig.size(), 0);
  EXPECT_EQ(setup.q_c_start.size(), 0);
  EXPECT_TRUE(test::Near(setup.rig.X_WC_fixed.linear().col(2), Vector3d(0, 0, -1), 1e-15));
  EXPECT_EQ(setup.rig.X_WC_fixed.translation(), Vector3d(1, 2, 3));
}

std::string AxisText(const std::string& name, bool turns) {
  const std::string deg = turns ? "_deg" : "";
  return "  " + name + ": {lower" + deg + ": -2, upper" + deg + ": 2, start" + deg +
         ": 1, max_speed" + (turns ? "_deg_s" : "") + ": 1, max_acceleration" +
         (turns ? "_deg_s2" : "") + ": 1}\n";
}

TEST(LoadRig, ReadsEveryKind) {
  const std::string head = AxisText("pan", true) + AxisText("tilt", true);
  const std::string pose = "pose: {position: [1, 2, 3]}\n";
  struct Form {
    std::string text;
    RigKind kind;
    int axes;
  };
  const std::vector<Form> forms{
      {With(kRig, "  roll:", head + "  roll:"), RigKind::kSpherical, 6},
      {"kind: pan_tilt\n" + pose + "axes:\n" + head, RigKind::kPanTilt, 2},
      {"kind: rail\nrail: [0, 3, 4]\n" + pose + "axes:\n" + AxisText("s", false), RigKind::kRail,
       1},
      {"kind: rail\nrail: [0, 3, 4]\n" + pose + "axes:\n" + AxisText("s", false) + head,
       RigKind::kRail, 3},
      {"kind: free\n" + pose + "axes:\n" + AxisText("x", false) + AxisText("y", false) +
           AxisText("z", false) + head + AxisText("roll", true),
       RigKind::kFree, 6}};
  for (const Form& form : forms) {
    SCOPED_TRACE(form.text);
    const RigSetup setup = LoadRigText(form.text);
    EXPECT_EQ(setup.rig.kind, form.kind);
    EXPECT_EQ(setup.rig.size(), form.axes);
    EXPECT_EQ(setup.q_c_start.size(), form.axes);
    EXPECT_NO_THROW(Validate(setup.rig));
  }
  EXPECT_TRUE(test::Near(LoadRigText(forms[2].text).rig.rail_W, Vector3d(0, 0.6, 0.8), 1e-15));
  EXPECT_EQ(LoadRigText(forms[0].text).rig.axes[4].name, "pan");
}

TEST(LoadRig, AHeadHasBothAxes) {
  const std::string text = "kind: rail\nrail: [1, 0, 0]\npose: {}\naxes:\n" + AxisText("s", false) +
                           AxisText("pan", true);
  EXPECT_EQ(test::ConfigErrorOf([&] { (void)LoadRigText(text); }),
            "file.yaml:5: axes.tilt: missing");
}

TEST(LoadCameraPose, LooksAtAPoint) {
  const Isometry3d X = LoadCameraPose(
      Parse("pose: {position: [2, 1, 1.5], look_at: [0.5, 0.2, 0.3], roll_deg: 0}"), "pose", "");
  const Vector3d axis = (Vector3d(0.5, 0.2, 0.3) - Vector3d(2, 1, 1.5)).normalized();
  EXPECT_TRUE(test::Near(X.linear().col(2), axis, 1e-14));
  EXPECT_TRUE(test::Near(X.translation(), Vector3d(2, 1, 1.5), 1e-14));
  EXPECT_NEAR(X.linear()(2, 0), 0.0, 1e-14);  // Rows are level,
  EXPECT_LT(X.linear()(2, 1), 0.0);           // and the image's down is down.
}

TEST(LoadCameraPose, RollTurnsAboutTheAxis) {
  const std::string text = "pose: {position: [2, 1, 1.5], look_at: [0.5, 0.2, 0.3], roll_deg: 0}";
  const Isometry3d level = LoadCameraPose(Parse(text), "pose", "");
  const Isometry3d rolled =
      LoadCameraPose(Parse(With(text, "roll_deg: 0", "roll_deg: 90")), "pose", "");
  EXPECT_TRUE(test::Near(rolled.linear().col(0), level.linear().col(1), 1e-14));
}

TEST(LoadCameraPose, RefusesOneByOne) {
  const auto error_of = [](const std::string& text) {
    return test::ConfigErrorOf([&] {
      const Section root = Parse(text);
      (void)LoadCameraPose(root, "pose", "");
      root.RejectUnknownKeys();
    });
  };
  EXPECT_EQ(error_of("a: 1"), "file.yaml:1: pose: missing");
  EXPECT_EQ(error_of("pose: {position: [1, 2, 3], look_at: [1, 2, 3]}"),
            "file.yaml:1: pose.look_at: must not be the position itself");
  EXPECT_EQ(error_of("pose: {position: [1, 2, 3], look_at: [0, 0, 0], rpy_deg: [0, 0, 0]}"),
            "file.yaml:1: pose.rpy_deg: unknown key; known here: look_at, position, roll_deg");
}

TEST(LoadPose, TurnsAsUrdfDoes) {
  const Isometry3d X = LoadPose(Parse("x: {rpy_deg: [10, 20, 30]}"), "x", true, "");
  const Eigen::Matrix3d expected =
      (AngleAxisd(30 * kDegree, Vector3d::UnitZ()) * AngleAxisd(20 * kDegree, Vector3d::UnitY()) *
       AngleAxisd(10 * kDegree, Vector3d::UnitX()))
          .toRotationMatrix();
  EXPECT_TRUE(test::Near(X.linear(), expected, 1e-15));
}

TEST(LoadPose, IsTheIdentityWhenAbsent) {
  EXPECT_EQ(LoadPose(Parse("a: 1"), "x", false, "").matrix(), Isometry3d::Identity().matrix());
  EXPECT_EQ(test::ConfigErrorOf([] { (void)LoadPose(Parse("a: 1"), "x", true, ""); }),
            "file.yaml:1: x: missing");
}

class LoadRigRefuses : public ::testing::TestWithParam<Edit> {};

TEST_P(LoadRigRefuses, WithOneLine) {
  ASSERT_NO_THROW((void)LoadRigText(kRig));
  const std::string text = With(kRig, GetParam().from, GetParam().to);
  EXPECT_EQ(test::ConfigErrorOf([&] { (void)LoadRigText(text); }), GetParam().message);
}

INSTANTIATE_TEST_SUITE_P(
    Edits, LoadRigRefuses,
    ::testing::Values(
        Edit{"UnknownKind", "spherical", "crane",
             "file.yaml:1: kind: must be one of fixed, spherical, pan_tilt, rail, free, arm, is "
             "'crane'"},
        Edit{"UnknownOrientation", "fixed_down", "up",
             "file.yaml:2: orientation: must be one of look_at, fixed_down, is 'up'"},
        Edit{"NoTarget", "target: [0.1, 0.2, 0.3]\n", "", "file.yaml:1: target: missing"},
        Edit{"NoAxis",
             "  phi: {lower_deg: -180, upper_deg: 180, start_deg: 45, max_speed_deg_s: 20, "
             "max_acceleration_deg_s2: 40}\n",
             "", "file.yaml:6: axes.phi: missing"},
        Edit{"RadiusZero", "R: {lower: 1", "R: {lower: 0",
             "file.yaml:6: axes.R.lower: must be in [0.001, 1000] m, is 0"},
        Edit{"ThetaBeyondThePole", "upper_deg: 90", "upper_deg: 181",
             "file.yaml:7: axes.theta.upper_deg: must be in [0, 180] deg, is 181"},
        Edit{"LimitsCrossed", "upper: 3", "upper: 0.5",
             "file.yaml:6: axes.R.upper: must not be below lower"},
        Edit{"StartOutside", "start_deg: 30", "start_deg: 91",
             "file.yaml:7: axes.theta.start_deg: must be between the axis' limits"},
        Edit{"NoAcceleration", ", max_acceleration: 1.5", "",
             "file.yaml:6: axes.R.max_acceleration: missing"},
        Edit{"AccelerationZero", "max_acceleration: 1.5", "max_acceleration: 0",
             "file.yaml:6: axes.R.max_acceleration: must be > 0 on an axis that moves"},
        Edit{"SpeedNegative", "max_speed: 0.5", "max_speed: -1",
             "file.yaml:6: axes.R.max_speed: must be in [0, 100] m/s, is -1"},
        Edit{"PoseOfASphere", "kind: spherical", "kind: spherical\npose: {}",
             "file.yaml:2: pose: unknown key; known here: axes, kind, max_linear_speed, "
             "orientation, "
             "target"}),
    [](const auto& test) { return test.param.name; });

// --- markers ---

std::vector<Marker> LoadMarkersText(const std::string& text) {
  const Section root = Parse(text);
  std::vector<Marker> markers = LoadMarkers(root, "markers", 1, 4, "");
  root.RejectUnknownKeys();
  return markers;
}

TEST(LoadMarkers, ReadsAllOfIt) {
  const auto markers = LoadMarkersText(
      "markers:\n  - {id: 3, position: [1, 2, 3], normal: [0, 3, 4], radius: 0.02, dark: false}\n"
      "  - {id: 1, position: [0, 0, 0]}\n");
  ASSERT_EQ(markers.size(), 2u);
  EXPECT_EQ(markers[0].id, 3);
  EXPECT_EQ(markers[0].p, Vector3d(1, 2, 3));
  EXPECT_TRUE(test::Near(markers[0].normal, Vector3d(0, 0.6, 0.8), 1e-15));
  EXPECT_EQ(markers[0].radius, 0.02);
  EXPECT_FALSE(markers[0].dark);
  EXPECT_EQ(markers[1].normal, Vector3d(0, 0, 1));
  EXPECT_TRUE(markers[1].dark);
}

TEST(LoadMarkers, RefusesOneByOne) {
  const auto error_of = [](const std::string& text) {
    return test::ConfigErrorOf([&] { (void)LoadMarkersText(text); });
  };
  EXPECT_EQ(error_of("a: 1"), "file.yaml:1: markers: missing");
  EXPECT_EQ(error_of("markers: [{id: 1, position: [0, 0, 0]}, {id: 1, position: [0, 0, 0]}]"),
            "file.yaml:1: markers[1].id: 1 names two markers");
  EXPECT_EQ(error_of("markers: [{id: -1, position: [0, 0, 0]}]"),
            "file.yaml:1: markers[0].id: must be in [0, 1000000], is -1");
  EXPECT_EQ(error_of("markers: [{id: 1}]"), "file.yaml:1: markers[0].position: missing");
  EXPECT_EQ(error_of("markers: [{id: 1, position: [0, 0, 0], normal: [0, 0, 0]}]"),
            "file.yaml:1: markers[0].normal: must not be zero");
  EXPECT_EQ(error_of("markers: [{id: 1, position: [0, 0, 0], radius: 0}]"),
            "file.yaml:1: markers[0].radius: must be in [0.0001, 10] m, is 0");
}

// --- features ---

std::vector<Feature> LoadFeaturesText(const std::string& text, int num_points = 4) {
  const Section root = Parse(text);
  std::vector<Feature> features = LoadFeatures(root, "features", num_points);
  root.RejectUnknownKeys();
  return features;
}

TEST(LoadFeatures, AllPointsGivesBothCoordinatesOfEach) {
  const auto features = LoadFeaturesText("features: all_points", 2);
  ASSERT_EQ(features.size(), 4u);
  EXPECT_EQ(features[0].kind, FeatureKind::kPointX);
  EXPECT_EQ(features[1].kind, FeatureKind::kPointY);
  EXPECT_EQ(features[3].kind, FeatureKind::kPointY);
  EXPECT_EQ(features[3].points, std::vector<int>{1});
}

TEST(LoadFeatures, ReadsEachKind) {
  const auto features = LoadFeaturesText(R"(features:
  - {kind: point_x, points: [0, 2]}
  - {kind: point_y, points: [1]}
  - {kind: point, points: [3]}
  - {kind: distance, points: [0, 1]}
  - {kind: angle, points: [1, 0]}
  - {kind: edge_angle, points: [0, 1, 2, 3]}
  - {kind: area, points: [0, 1, 2]}
  - {kind: centroid_x, points: [0, 1]}
  - {kind: centroid_y, points: [2, 3]}
  - {kind: centroid, points: [0, 3]}
)");
  using Kind = FeatureKind;
  const std::vector<Feature> expected{{Kind::kPointX, {0}},       {Kind::kPointX, {2}},
                                      {Kind::kPointY, {1}},       {Kind::kPointX, {3}},
                                      {Kind::kPointY, {3}},       {Kind::kDistance, {0, 1}},
                                      {Kind::kAngle, {1, 0}},     {Kind::kEdgeAngle, {0, 1, 2, 3}},
                                      {Kind::kArea, {0, 1, 2}},   {Kind::kCentroidX, {0, 1}},
                                      {Kind::kCentroidY, {2, 3}}, {Kind::kCentroidX, {0, 3}},
                                      {Kind::kCentroidY, {0, 3}}};
  ASSERT_EQ(features.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(features[i].kind, expected[i].kind) << i;
    EXPECT_EQ(features[i].points, expected[i].points) << i;
  }
}

TEST(LoadFeatures, EdgesMayShareAPoint) {
  const auto features = LoadFeaturesText("features: [{kind: edge_angle, points: [0, 1, 0, 2]}]");
  ASSERT_EQ(features.size(), 1u);
  EXPECT_EQ(features[0].points, (std::vector<int>{0, 1, 0, 2}));
}

TEST(LoadFeatures, RefusesOneByOne) {
  const auto error_of = [](const std::string& text) {
    return test::ConfigErrorOf([&] { (void)LoadFeaturesText(text); });
  };
  EXPECT_EQ(error_of("a: 1"), "file.yaml:1: features: missing");
  EXPECT_EQ(error_of("features: every"),
            "file.yaml:1: features: must be one of all_points, is 'every'");
  EXPECT_EQ(error_of("features: []"),
            "file.yaml:1: features: must be a list of 1 to 32 mappings, has 0");
  EXPECT_EQ(
      error_of("features: [{kind: depth, points: [0]}]"),
      "file.yaml:1: features[0].kind: must be one of point, centroid, point_x, point_y, distance, "
      "angle, edge_angle, area, centroid_x, centroid_y, segment_x, segment_y, segment_length, "
      "segment_angle, segment_x_normalised, segment_y_normalised, segment_inverse_length, "
      "moment_basic, moment_centred, moment_x, moment_y, moment_area, moment_area_normalised, "
      "moment_x_normalised, moment_y_normalised, moment_alpha, is 'depth'");
  EXPECT_EQ(error_of("features: [{kind: distance, points: [0]}]"),
            "file.yaml:1: features[0].points: must be a list of 2 integers, has 1");
  EXPECT_EQ(error_of("features: [{kind: area, points: [0, 1]}]"),
            "file.yaml:1: features[0].points: must be a list of 3 to 16 integers, has 2");
  EXPECT_EQ(error_of("features: [{kind: point_x, points: [4]}]"),
            "file.yaml:1: features[0].points[0]: must be in [0, 3], is 4");
  EXPECT_EQ(error_of("features: [{kind: distance, points: [1, 1]}]"),
            "file.yaml:1: features[0].points: must not name a point twice");
  std::string many = "features:\n";
  for (int i = 0; i < 9; ++i) many += "  - {kind: point, points: [0, 1]}\n";
  EXPECT_EQ(error_of(many), "file.yaml:2: features: must give at most 32 rows, give 36");
}

}  // namespace
}  // namespace vantage
