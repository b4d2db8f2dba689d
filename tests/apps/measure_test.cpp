#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "config_error.h"
#include "measure_evaluate.h"
#include "measure_print.h"
#include "measure_setup.h"
#include "oracle_arm.h"
#include "program.h"
#include "temporary_folder.h"
#include "vantage/config/config_text.h"

namespace vantage {
namespace {

using Json = nlohmann::json;
using test::ConfigErrorOf;
using test::RunProgram;

Json Measured(const MeasureSetup& setup) {
  return Json::parse(ToJson(setup, Evaluate(setup, setup.q, setup.q_c)));
}

std::string OraclePath() {
  const char* other = std::getenv("VANTAGE_ORACLES");
  return other != nullptr ? other : VANTAGE_TEST_DATA "/oracles.json";
}

double LargestDifference(const Json& a, const Json& b) {
  const Eigen::MatrixXd A = test::OracleMatrix(a), B = test::OracleMatrix(b);
  if (A.rows() != B.rows() || A.cols() != B.cols()) return std::numeric_limits<double>::infinity();
  return (A - B).cwiseAbs().maxCoeff() / std::max(1e-300, B.cwiseAbs().maxCoeff());
}

// A camera straight above a two-joint arm, in the words of a file; `more` is added.
std::string PlanarFile(const std::string& more) {
  return "robot: planar2\njoints_deg: [20, 60]\nfeatures: all_points\n" + more;
}

constexpr char kCameraAbove[] = "camera_sphere: {R: 1.0, theta_deg: 0, target: [0.3, 0.3, 0]}\n";

class MeasureFile : public ::testing::Test {
 protected:
  MeasureSetup Load(const std::string& text) const {
    return FindMeasureSetup(folder_.Write("case.yaml", text));
  }
  std::string ErrorOf(const std::string& text) const {
    return ConfigErrorOf([&] { (void)Load(text); });
  }
  test::TemporaryFolder folder_;
};

TEST(MeasureOracle, JsonHoldsTheNumbersOfEveryCase) {
  const Json oracles = test::ReadOracles();
  int compared = 0;
  for (const Json& entry : oracles.at("cases")) {
    const auto id = entry.at("id").get<std::string>();
    SCOPED_TRACE(id);
    const Json actual = Measured(LoadOracleSetup(OraclePath(), id));
    const Json& expected = entry.at("expected");
    if (entry.at("features").size() != expected.at("v").size()) continue;
    if (actual.at("J_v").size() != expected.at("J_v").size()) {
      // Rows are missing only where a point is not visible.
      EXPECT_FALSE(actual.at("visible").get<bool>());
      continue;
    }
    ++compared;
    for (const char* name : {"J_v", "J_r", "J_c"}) {
      EXPECT_LE(LargestDifference(actual.at(name), expected.at(name)), 1e-11) << name;
    }
    for (const char* name : {"v", "r", "c"}) {
      const std::string suffix = std::string("_") + name;
      const Json& sigma = actual.at("singular_values" + suffix);
      const Json& expected_sigma = expected.at("sv" + suffix);
      const double w = expected.at("w" + suffix).get<double>();
      const double largest = expected_sigma.at(0).get<double>();
      const int s = expected.at("s" + suffix).get<int>();
      ASSERT_EQ(static_cast<int>(sigma.size()), s);
      for (int i = 0; i < s; ++i) {
        EXPECT_NEAR(sigma[i].get<double>(), expected_sigma[i].get<double>(), 1e-12 * largest)
            << name;
      }
      EXPECT_EQ(actual.at("rank" + suffix), expected.at("rank" + suffix));
      const double tolerance = w > 0.0 ? 1e-9 * w : 1e-9 * std::pow(largest, s);
      EXPECT_NEAR(actual.at("w" + suffix).get<double>(), w, tolerance) << name;
    }
  }
  EXPECT_GE(compared, 30);
}

TEST(MeasureOracle, ACaseThatIsNotThereIsNamedWithThoseThatAre) {
  const std::string error = ConfigErrorOf([] { (void)LoadOracleSetup(OraclePath(), "no-such"); });
  EXPECT_NE(error.find("no-such"), std::string::npos);
  EXPECT_NE(error.find("A01"), std::string::npos);
}

TEST(MeasureExamples, AllAreSeenAndOfFullRank) {
  const std::vector<std::string> names = BuiltInConfigs(ConfigKind::kMeasure);
  for (const char* name : {"panda", "planar2", "puma560", "ur5"}) {
    EXPECT_EQ(std::count(names.begin(), names.end(), name), 1) << name;
  }
  for (const std::string& name : names) {
    SCOPED_TRACE(name);
    const MeasureSetup setup = FindMeasureSetup(name);
    const Json json = Measured(setup);
    EXPECT_FALSE(setup.description.empty());
    EXPECT_TRUE(json.at("visible").get<bool>());
    const int needed = std::min({static_cast<int>(json.at("J_c").size()), setup.arm.size(), 6});
    EXPECT_EQ(json.at("rank_c").get<int>(), needed);
    EXPECT_GT(json.at("w_c").get<double>(), 0.0);
    EXPECT_EQ(json.at("cause"), "NONE");
  }
}

TEST(MeasureExamples, PlanarArmHasThePapersMeasures) {
  const Json json = Measured(FindMeasureSetup("planar2"));
  EXPECT_NEAR(json.at("w_c").get<double>(), 4.0 / 9.0, 1e-12);
  EXPECT_NEAR(json.at("translation").at("w_v").get<double>(), 1.0 / 225.0, 1e-14);
  EXPECT_NEAR(json.at("translation").at("w_r").get<double>(), 100.0, 1e-10);
  EXPECT_NEAR(json.at("translation").at("paper_product").get<double>(), 4.0 / 9.0, 1e-12);
  EXPECT_TRUE(json.at("translation").at("exact").get<bool>());
}

TEST(MeasureJson, HasItsStableKeys) {
  const Json json = Measured(FindMeasureSetup("ur5"));
  for (const char* key : {"J_v",
                          "J_r",
                          "J_c",
                          "singular_values_v",
                          "singular_values_r",
                          "singular_values_c",
                          "w_v",
                          "w_r",
                          "w_c",
                          "log_w_v",
                          "log_w_r",
                          "log_w_c",
                          "rank_v",
                          "rank_r",
                          "rank_c",
                          "sigma_min_c",
                          "condition_c",
                          "cause",
                          "ellipsoid",
                          "visible",
                          "mm_per_px"}) {
    EXPECT_TRUE(json.contains(key)) << key;
  }
  EXPECT_EQ(json.at("ellipsoid").at("axes").size(), 6u);
  EXPECT_EQ(json.at("ellipsoid").at("axes")[0].size(), 8u);
  EXPECT_NEAR(json.at("log_w_c").get<double>(), std::log(json.at("w_c").get<double>()), 1e-9);
}

TEST(MeasureJson, EllipsoidAxesAreTheSingularValuesLong) {
  const Json json = Measured(FindMeasureSetup("puma560"));
  for (std::size_t i = 0; i < 6; ++i) {
    const auto axis = json.at("ellipsoid").at("axes")[i].get<std::vector<double>>();
    const double sigma = json.at("singular_values_c")[i].get<double>();
    EXPECT_NEAR(Eigen::Map<const Eigen::VectorXd>(axis.data(), 8).norm(), sigma, 1e-9 * sigma);
  }
}

TEST_F(MeasureFile, APointBehindTheCameraIsNamedAndGivesNoRow) {
  // The camera stands at (0.3, 0.3, 1) and looks down: the second point is above it.
  const MeasureSetup setup = Load(
      PlanarFile(std::string(kCameraAbove) +
                 "points: [{position: [0, 0, 0]}, {frame: world, position: [0.3, 0.3, 2]}]\n"));
  const Json json = Measured(setup);
  EXPECT_FALSE(json.at("visible").get<bool>());
  EXPECT_EQ(json.at("points")[0].at("fault"), "NONE");
  EXPECT_EQ(json.at("points")[1].at("fault"), "BEHIND");
  EXPECT_TRUE(json.at("points")[1].at("uv").is_null());
  EXPECT_EQ(json.at("J_v").size(), 2u);
  EXPECT_NEAR(json.at("points")[1].at("depth").get<double>(), -1.0, 1e-12);
}

TEST_F(MeasureFile, NothingSeenIsACauseAndNeverANaN) {
  const MeasureSetup setup =
      Load(PlanarFile("camera_sphere: {R: 1.0, theta_deg: 180, target: [0.3, 0.3, 2]}\n"
                      "points: [{position: [0, 0, 0]}]\n"));
  const Measurement m = Evaluate(setup, setup.q, setup.q_c);
  EXPECT_EQ(m.cause, LowCause::kFeatures);
  EXPECT_EQ(m.rows.size(), 0);
  EXPECT_EQ(m.composite.measure.w, 0.0);
  const std::string text = ToJson(setup, m) + ToTable(setup, m);
  EXPECT_EQ(text.find("nan"), std::string::npos);
  const Json json = Json::parse(ToJson(setup, m));
  EXPECT_TRUE(json.at("log_w_c").is_null());
  EXPECT_TRUE(json.at("condition_c").is_null());
  EXPECT_TRUE(json.at("mm_per_px").is_null());
}

TEST_F(MeasureFile, AnArmWithAlignedWristAxesIsTheCause) {
  MeasureSetup setup = FindMeasureSetup("puma560");
  setup.q(4) = 0.0;
  const Json json = Measured(setup);
  EXPECT_EQ(json.at("rank_r"), 5);
  EXPECT_EQ(json.at("cause"), "ARM");
}

TEST_F(MeasureFile, AGrazingViewIsTheCause) {
  // From within the plane of motion, towards the arm: of two coordinates one does not move.
  const MeasureSetup setup =
      Load(PlanarFile("camera_pose: {position: [2.0, 0.3, 0.0], look_at: [0.3, 0.3, 0.0]}\n"
                      "points: [{position: [0, 0, 0]}]\n"));
  const Json json = Measured(setup);
  EXPECT_EQ(json.at("cause"), "VIEW");
  EXPECT_EQ(json.at("rank_c"), 1);
}

TEST_F(MeasureFile, AMarkerIsSeenFromItsFrontAlone) {
  const std::string marker = "markers: [{id: 0, position: [0, 0, 0], normal: [0, 0, SIGN]}]\n";
  for (const bool front : {true, false}) {
    std::string text = marker;
    text.replace(text.find("SIGN"), 4, front ? "1" : "-1");
    const Json json = Measured(Load(PlanarFile(kCameraAbove + text)));
    EXPECT_EQ(json.at("points")[0].at("fault"), front ? "NONE" : "FACES_AWAY");
  }
}

TEST_F(MeasureFile, PixelCamerasHaveABorderAndMetricOnesNone) {
  const std::string wide = "points: [{frame: world, position: [3, 0, 0]}, {position: [0, 0, 0]}]\n";
  const Json pixels = Measured(Load(PlanarFile(kCameraAbove + wide)));
  EXPECT_EQ(pixels.at("points")[0].at("fault"), "OUT_OF_IMAGE");
  const Json metric =
      Measured(Load(PlanarFile(kCameraAbove + wide + "camera: {units: metric, focal: 1}\n")));
  EXPECT_EQ(metric.at("points")[0].at("fault"), "NONE");
  EXPECT_TRUE(metric.at("mm_per_px").is_null());
}

TEST_F(MeasureFile, OnePixelHidesTheDepthOverTheFocalLengthFromAbove) {
  // One point, seen square on at 1 m with f = 500 px: a pixel is 2 mm, in every direction.
  const MeasureSetup setup =
      Load(PlanarFile(std::string(kCameraAbove) + "points: [{position: [0, 0, 0]}]\n"
                                                  "camera: {fx: 500}\n"));
  // The two directions are alike: the largest of equal eigenvalues is good to half the digits.
  EXPECT_NEAR(Measured(setup).at("mm_per_px").get<double>(), 2.0, 1e-7);
}

TEST_F(MeasureFile, ErrorsNameFileLineAndKey) {
  const std::string points = "points: [{position: [0, 0, 0]}]\n";
  EXPECT_NE(ErrorOf(PlanarFile(points)).find("the camera's place is missing"), std::string::npos);
  EXPECT_NE(ErrorOf(PlanarFile(kCameraAbove)).find("what is seen is missing"), std::string::npos);
  EXPECT_NE(ErrorOf(PlanarFile(kCameraAbove + points + "focal: 3\n")).find("focal"),
            std::string::npos);
  EXPECT_NE(
      ErrorOf(PlanarFile(kCameraAbove + points + "camera: {units: metric}\n")).find("camera.focal"),
      std::string::npos);
  const std::string both =
      ErrorOf(PlanarFile(kCameraAbove + points + "camera_pose: {position: [0, 0, 1]}\n"));
  EXPECT_NE(both.find("case.yaml"), std::string::npos);
  EXPECT_NE(both.find("must not be given beside camera_sphere"), std::string::npos);
}

TEST(MeasureProgram, PrintsTableAndJson) {
  const auto table = RunProgram(VANTAGE_MEASURE " puma560");
  EXPECT_EQ(table.exit_code, 0);
  EXPECT_NE(table.output.find("composite J_c 8x6"), std::string::npos);
  const auto json = RunProgram(VANTAGE_MEASURE " puma560 --json");
  EXPECT_EQ(json.exit_code, 0);
  EXPECT_TRUE(Json::parse(json.output).contains("w_c"));
  const auto oracle =
      RunProgram(VANTAGE_MEASURE " --json --oracle-case " VANTAGE_TEST_DATA "/oracles.json A01");
  EXPECT_NEAR(Json::parse(oracle.output).at("w_c").get<double>(), 4.0 / 9.0, 1e-12);
}

TEST(MeasureProgram, BadInputIsOneLineAndExitCode2) {
  for (const char* arguments : {"", "no-such", "/no/such.yaml", "ur5 --oracle-case a b",
                                "--oracle-case " VANTAGE_TEST_DATA "/oracles.json ZZ"}) {
    SCOPED_TRACE(arguments);
    const auto run = RunProgram(std::string(VANTAGE_MEASURE " ") + arguments);
    EXPECT_EQ(run.exit_code, 2);
    EXPECT_EQ(std::count(run.output.begin(), run.output.end(), '\n'), 1) << run.output;
  }
}

TEST(MeasureProgram, HasHelpAndVersion) {
  EXPECT_EQ(RunProgram(VANTAGE_MEASURE " --help").exit_code, 0);
  EXPECT_EQ(RunProgram(VANTAGE_MEASURE " --version").output.rfind("vantage ", 0), 0u);
}

}  // namespace
}  // namespace vantage
