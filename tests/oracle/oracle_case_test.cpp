#include "vantage/config/oracle_case.h"

#include <functional>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "eigen_matchers.h"
#include "temporary_folder.h"
#include "vantage/math/error.h"
#include "vantage/robot/kinematics.h"

namespace vantage {
namespace {

using Json = nlohmann::json;

const std::string kFile = VANTAGE_TEST_DATA "/oracles.json";

// A case with every kind of feature.
Json Entry() {
  return Json::parse(R"({
    "id": "T1", "k": 7, "n": 2, "m": 6,
    "robot": {"name": "arm", "convention": "modified",
      "base": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]],
      "tool": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0.1], [0, 0, 0, 1]],
      "joints": [{"type": "R", "a": 1, "alpha": 0, "d": 0.5, "offset": 0.1},
                 {"type": "P", "a": 0, "alpha": 0.3, "theta": 0.2, "offset": 0}]},
    "q": [0.3, 0.2],
    "points": [{"frame": "ee", "xyz": [0, 0, 0]}, {"frame": "ee", "xyz": [0, 0.1, 0]},
               {"frame": "world", "xyz": [0.1, 0, 0]}],
    "features": [{"type": "point", "p": 0, "coord": "x"}, {"type": "point", "p": 1, "coord": "y"},
                 {"type": "distance", "i": 0, "j": 1}, {"type": "angle", "i": 0, "j": 2},
                 {"type": "edge_angle", "i": 0, "j": 1, "k": 1, "l": 2},
                 {"type": "area", "poly": [0, 1, 2]},
                 {"type": "centroid", "pts": [0, 1], "coord": "y"}],
    "camera": {"mount": "world",
      "intrinsics": {"fx": 600, "fy": 500, "skew": 2, "u0": 320, "v0": 240},
      "spherical": {"R": 3, "theta": 0.5, "phi": 0.2, "roll": 0.1, "target": [0, 0, 0.2],
                    "orientation": "lookat"}}})");
}

TEST(OracleCase, ReadsEveryPart) {
  const OracleCase read = ParseOracleCase(Entry());
  EXPECT_EQ(read.id, "T1");
  EXPECT_EQ(read.arm.joint_kinds()[1], JointKind::kPrismatic);
  EXPECT_EQ(read.q(1), 0.2);
  EXPECT_TRUE(read.points[1].on_body);
  EXPECT_FALSE(read.points[2].on_body);
  const std::vector<Feature>& features = read.features.features();
  ASSERT_EQ(features.size(), 7U);
  const std::vector<FeatureKind> kinds{
      FeatureKind::kPointX,    FeatureKind::kPointY, FeatureKind::kDistance, FeatureKind::kAngle,
      FeatureKind::kEdgeAngle, FeatureKind::kArea,   FeatureKind::kCentroidY};
  for (std::size_t i = 0; i < kinds.size(); ++i) EXPECT_EQ(features[i].kind, kinds[i]) << i;
  EXPECT_EQ(features[4].points, (std::vector<int>{0, 1, 1, 2}));
  EXPECT_EQ(read.camera.model.skew, 2.0);
  ASSERT_TRUE(read.camera.sphere.has_value());
  EXPECT_EQ(read.camera.sphere->q_c(3), 0.1);
  // The optical axis passes through the target.
  const Eigen::Vector3d target = read.camera.X.inverse() * Eigen::Vector3d(0, 0, 0.2);
  EXPECT_TRUE(test::Near(target, Eigen::Vector3d(0, 0, 3), 1e-14));
}

TEST(OracleCase, CarriedCamera) {
  Json entry = Entry();
  entry["camera"] = Json::parse(R"({"mount": "ee", "intrinsics": {"fx": 1, "fy": 1},
      "T_ec": [[1, 0, 0, 0.1], [0, 1, 0, 0.2], [0, 0, 1, 0.3], [0, 0, 0, 1]]})");
  const OracleCase read = ParseOracleCase(entry);
  EXPECT_TRUE(read.camera.eye_in_hand);
  const Eigen::Isometry3d X_WE = EndEffectorPose(read.arm, read.q);
  const Eigen::Isometry3d X_WC = CameraPoseOf(read.camera, X_WE);
  EXPECT_TRUE(test::Near(X_WC.translation(), X_WE * Eigen::Vector3d(0.1, 0.2, 0.3), 1e-15));
}

TEST(OracleCase, PointsBehindTheCameraAreNotSeen) {
  const std::vector<OraclePoint> points{{true, {0, 0, 2}}, {false, {0, 0, 3}}};
  Eigen::Isometry3d X_WE = Eigen::Isometry3d::Identity();
  X_WE.translation().z() = -5.0;
  const PointViews views = ViewPoints(points, X_WE, Eigen::Isometry3d::Identity());
  EXPECT_FALSE(views[0].visible);
  EXPECT_TRUE(views[1].visible);
  EXPECT_EQ(views[1].image.depth, 3.0);
  EXPECT_FALSE(views[1].on_body);
}

TEST(OracleCase, LoadsOneOfAFile) {
  const OracleCase read = LoadOracleCase(kFile, "D06");
  EXPECT_EQ(read.id, "D06");
  EXPECT_EQ(read.arm.size(), 6);
  EXPECT_EQ(read.features.features().size(), 12U);
}

std::string Refusal(const std::function<void()>& call) {
  try {
    call();
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(OracleCase, NamesTheIdsThereAre) {
  const std::string message = Refusal([] { (void)LoadOracleCase(kFile, "Z99"); });
  EXPECT_NE(message.find("Z99: is not a case"), std::string::npos) << message;
  EXPECT_NE(message.find("D06"), std::string::npos) << message;
}

TEST(OracleCase, RefusesAFileThatIsNotThereOrNotJson) {
  EXPECT_NE(Refusal([] { (void)ReadJsonFile("/no/such.json"); }).find("cannot be opened"),
            std::string::npos);
  EXPECT_NE(Refusal([] {
              (void)ReadJsonFile(VANTAGE_TEST_DATA "/../CMakeLists.txt");
            }).find("parse error"),
            std::string::npos);
}

TEST(OracleCase, NamesFileAndKeyOfABadCaseOnce) {
  const test::TemporaryFolder folder;
  Json entry = Entry();
  entry["m"] = 7;
  const std::string path =
      folder.Write("cases.json", Json({{"cases", Json::array({entry})}}).dump());
  EXPECT_EQ(Refusal([&] { (void)LoadOracleCase(path, "T1"); }),
            path + ": m: must be in [1, 6], is 7");
}

struct Fault {
  std::string path;   // of the value that is set
  std::string value;  // "" takes it away
  std::string key;    // that the refusal names
};

class BadCase : public ::testing::TestWithParam<Fault> {};

TEST_P(BadCase, NamesTheKey) {
  Json entry = Entry();
  const Json::json_pointer path(GetParam().path);
  if (GetParam().value.empty()) {
    entry[path.parent_pointer()].erase(path.back());
  } else {
    entry[path] = Json::parse(GetParam().value);
  }
  try {
    (void)ParseOracleCase(entry);
    FAIL() << "accepted";
  } catch (const ConfigError& error) {
    EXPECT_EQ(error.key(), GetParam().key) << error.what();
  }
}

INSTANTIATE_TEST_SUITE_P(
    OracleCase, BadCase,
    ::testing::Values(
        Fault{"/id", "", "case.id"}, Fault{"/k", "6", "k"}, Fault{"/n", "3", "n"},
        Fault{"/m", "7", "m"}, Fault{"/q", "[0.1]", "q"}, Fault{"/q/1", "null", "q[1]"},
        Fault{"/robot/convention", "\"craig\"", "robot.convention"},
        Fault{"/robot/joints/0/type", "\"S\"", "robot.joints[0].type"},
        Fault{"/robot/joints/0/d", "", "robot.joints[0].d"},
        Fault{"/robot/joints/1/theta", "", "robot.joints[1].theta"},
        Fault{"/robot/base/0/0", "2", "robot.base"},
        Fault{"/robot/tool/3", "[0, 0, 0]", "robot.tool[3]"},
        Fault{"/robot/tool/3", "[0, 0, 1, 1]", "robot.tool"},
        Fault{"/points/0/frame", "\"tool\"", "points[0].frame"},
        Fault{"/points/0/xyz", "[1, 2]", "points[0].xyz"},
        Fault{"/features/2/type", "\"ellipse\"", "features[2].type"},
        Fault{"/features/2/j", "", "features[2].j"}, Fault{"/features/2/j", "1.5", "features[2].j"},
        Fault{"/features/2/j", "3", "features[2]"},
        Fault{"/features/0/coord", "\"z\"", "features[0].coord"},
        Fault{"/features/5/poly", "[0, 1]", "features[5]"},
        Fault{"/camera/mount", "\"tripod\"", "camera.mount"},
        Fault{"/camera/intrinsics/fx", "0", "camera.intrinsics.fx"},
        Fault{"/camera/intrinsics/fy", "", "camera.intrinsics.fy"},
        Fault{"/camera/spherical/R", "\"far\"", "camera.spherical.R"},
        Fault{"/camera/spherical/orientation", "\"up\"", "camera.spherical.orientation"},
        Fault{"/camera/spherical", "", "camera.T_wc"}));

}  // namespace
}  // namespace vantage
