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
#include "vantage/math/angles.h"

namespace vantage {
namespace {

using Json = nlohmann::json;
using test::ConfigErrorOf;
using test::OraclePath;
using test::RunProgram;

Json Measured(const MeasureSetup& setup) {
  return Json::parse(ToJson(setup, Report(setup)));
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
  const MeasureReport report = Report(setup);
  const std::string text = ToJson(setup, report) + ToTable(setup, report);
  EXPECT_EQ(text.find("nan"), std::string::npos);
  const Json json = Json::parse(ToJson(setup, report));
  EXPECT_TRUE(json.at("log_w_c").is_null());
  EXPECT_TRUE(json.at("condition_c").is_null());
  EXPECT_TRUE(json.at("mm_per_px").is_null());
  EXPECT_EQ(json.at("status_c"), "EMPTY");
  EXPECT_EQ(json.at("gradient_c").at("status"), "NOT_MEASURED");
  EXPECT_TRUE(json.at("gradient_c").at("w").is_null());
  EXPECT_EQ(json.at("features_missing").at(0).at("status"), "BEHIND_CAMERA");
}

TEST_F(MeasureFile, CoincidentImagePointsAreNamed) {
  // The second point lies on the ray to the first: seen as one.
  const MeasureSetup setup = Load(
      "robot: planar2\njoints_deg: [0, 90]\n"
      "camera_pose: {position: [0.3, 0.3, 1.0], rpy_deg: [180, 0, 0]}\n"
      "points: [{frame: world, position: [0.3, 0.3, 0]},"
      " {frame: world, position: [0.3, 0.3, 0.5]}, {position: [0, 0, 0]}]\n"
      "features: [{kind: distance, points: [0, 1]}, {kind: point, points: [2]}]\n");
  const Json json = Measured(setup);
  ASSERT_EQ(json.at("features_missing").size(), 1u);
  EXPECT_EQ(json.at("features_missing")[0].at("name"), "distance_0_1");
  EXPECT_EQ(json.at("features_missing")[0].at("status"), "COINCIDENT");
  EXPECT_EQ(json.at("J_c").size(), 2u);
  EXPECT_NE(ToTable(setup, Report(setup)).find("distance_0_1 COINCIDENT"), std::string::npos);
}

// Stretched, the planar arm moves its tip across alone, and no camera shows more: the arm is the cause,
// though its end effector still turns (rank of J_r 2). Looked at from anywhere.
TEST_F(MeasureFile, AStretchedArmIsTheCauseFromEveryView) {
  for (const char* camera : {"camera_pose: {position: [1.0, 0.2, 2.0], look_at: [1.0, 0, 0]}\n",
                             "camera_pose: {position: [2.5, 0.0, 0.2], look_at: [1.0, 0, 0]}\n",
                             "camera_pose: {position: [1.0, -2.0, 0.5], look_at: [1.0, 0, 0]}\n"}) {
    const Json json =
        Measured(Load(std::string("robot: planar2\njoints_deg: [0, 0]\nfeatures: all_points\n"
                                  "points: [{position: [0, 0, 0]}]\n") +
                      camera));
    EXPECT_TRUE(json.at("visible").get<bool>());
    EXPECT_EQ(json.at("rank_c"), 1);
    EXPECT_EQ(json.at("rank_r"), 2);
    EXPECT_EQ(json.at("cause"), "ARM");
    EXPECT_EQ(json.at("gradient_c").at("status"), "SINGULAR");
  }
}

// Points that the joints do not move say nothing of them, wherever the camera stands.
TEST_F(MeasureFile, PointsThatTheArmDoesNotMoveAreTheFeaturesFault) {
  const Json json = Measured(Load(PlanarFile(
      std::string(kCameraAbove) + "points: [{frame: world, position: [0.3, 0.3, 0]}]\n")));
  EXPECT_EQ(json.at("w_c"), 0.0);
  EXPECT_EQ(json.at("cause"), "FEATURES");
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

// Gradients of the whole program against central differences of its measures: every parameter of every
// built-in file and of each kind of rig.
class MeasureGradient : public MeasureFile {
 protected:
  static void ExpectGradients(const MeasureSetup& setup) {
    const MeasureReport report = Report(setup);
    const auto check = [&](const LogMeasureGradient& gradient, bool composite) {
      ASSERT_EQ(gradient.status, GradientStatus::kOk);
      const auto log_w = [&](const MeasureSetup& moved, const JointVector& q,
                             const RigVector& q_c) {
        const Measurement m = Evaluate(moved, q, q_c);
        return composite ? m.composite.measure.log_w : m.view.measure.log_w;
      };
      const double h = 1e-6;
      const auto expect = [&](double actual, double ahead, double behind, double step,
                              const std::string& what) {
        const double numeric = (ahead - behind) / (2.0 * step);
        EXPECT_NEAR(actual, numeric, 1e-6 * (1.0 + gradient.by.camera.norm())) << what;
      };
      for (int i = 0; i < setup.q.size(); ++i) {
        const JointVector step = h * JointVector::Unit(setup.q.size(), i);
        expect(gradient.by.joints(i), log_w(setup, setup.q + step, setup.q_c),
               log_w(setup, setup.q - step, setup.q_c), h, "joint " + std::to_string(i));
      }
      for (int i = 0; i < setup.q_c.size(); ++i) {
        const RigVector step = h * RigVector::Unit(setup.q_c.size(), i);
        expect(gradient.rig(i), log_w(setup, setup.q, setup.q_c + step),
               log_w(setup, setup.q, setup.q_c - step), h, setup.rig.axes[i].name);
      }
      MeasureSetup longer = setup, shorter = setup;
      const double df = h * setup.camera.fx;
      longer.camera.fx = longer.camera.fy = setup.camera.fx + df;
      shorter.camera.fx = shorter.camera.fy = setup.camera.fx - df;
      expect(gradient.by.calibration.trace(), log_w(longer, setup.q, setup.q_c),
             log_w(shorter, setup.q, setup.q_c), df, "focal length");
    };
    check(report.gradients.view, false);
    check(report.gradients.composite, true);
  }
};

TEST_F(MeasureGradient, OfTheBuiltInFilesMatchesCentralDifferences) {
  for (const char* name : {"panda", "planar2", "puma560", "ur5"}) {
    SCOPED_TRACE(name);
    ExpectGradients(FindMeasureSetup(name));
  }
}

TEST_F(MeasureGradient, ByTheCoordinatesOfEveryRigMatchesCentralDifferences) {
  const std::string cell =
      "robot: puma560\njoints_deg: [10, 60, -110, 15, -60, 0]\n"
      "points: [{position: [0.12, 0.10, 0.02]}, {position: [-0.12, 0.10, 0.02]},"
      " {position: [-0.12, -0.10, 0.05]}]\n"
      "features: [{kind: point, points: [0]}, {kind: distance, points: [0, 1]},"
      " {kind: segment_angle, points: [1, 2]}, {kind: moment_area, points: [0, 1, 2]}]\n";
  const std::string axis = "max_speed: 1, max_acceleration: 1";
  const std::string angle = "max_speed_deg_s: 9, max_acceleration_deg_s2: 9";
  const auto turn = [&](const std::string& name, const std::string& start) {
    return "    " + name + ": {lower_deg: -170, upper_deg: 170, start_deg: " + start + ", " +
           angle + "}\n";
  };
  const std::string sphere =
      "camera_rig:\n  kind: spherical\n  target: [0.6, 0.0, 1.2]\n  axes:\n"
      "    R: {lower: 0.5, upper: 3, start: 1.4, " +
      axis +
      "}\n"
      "    theta: {lower_deg: 0, upper_deg: 180, start_deg: 70, " +
      angle + "}\n" + turn("phi", "40") + turn("roll", "25");
  for (const std::string& rig : {sphere, sphere + turn("pan", "3") + turn("tilt", "-2")}) {
    SCOPED_TRACE(rig);
    ExpectGradients(Load(cell + rig));
  }
  ExpectGradients(Load(cell +
                       "camera_sphere: {R: 1.5, theta_deg: 60, phi_deg: 30, roll_deg: -20, target: "
                       "[0.6, 0, 1.2]}\n"));
}

TEST_F(MeasureGradient, HasOneKeyForEachParameter) {
  const Json json = Measured(FindMeasureSetup("planar2"));
  const Json& gradient = json.at("gradient_c");
  EXPECT_EQ(gradient.at("status"), "OK");
  // w_c = f² l1 l2 |sin theta2| / (R cos theta)² at R 30, theta 60 degrees.
  const Json& by = gradient.at("w");
  EXPECT_NEAR(by.at("rig").at("R").get<double>(), -2.0 * 4.0 / 9.0 / 30.0, 1e-12);
  EXPECT_NEAR(by.at("rig").at("theta").get<double>(), 2.0 * std::tan(kPi / 3) * 4.0 / 9.0, 1e-12);
  EXPECT_NEAR(by.at("rig").at("phi").get<double>(), 0.0, 1e-12);
  EXPECT_NEAR(by.at("rig").at("roll").get<double>(), 0.0, 1e-12);
  EXPECT_NEAR(by.at("focal").get<double>(), 2.0 * 4.0 / 9.0, 1e-12);
  EXPECT_EQ(by.at("camera_twist").size(), 6u);
  EXPECT_EQ(by.at("joints").size(), 2u);
  EXPECT_NEAR(gradient.at("log_w").at("rig").at("R").get<double>(), -2.0 / 30.0, 1e-12);
  EXPECT_TRUE(json.at("gradient_v").at("w").contains("skew"));
}

TEST_F(MeasureFile, WhitensByTheCovarianceOfTheFeatures) {
  const std::string base =
      PlanarFile(std::string(kCameraAbove) + "points: [{position: [0, 0, 0]}]\n");
  const Json plain = Measured(Load(base));
  EXPECT_TRUE(plain.at("whitened").is_null());
  const Json sigmas = Measured(Load(base + "feature_sigmas: [0.5, 0.25]\n"));
  EXPECT_NEAR(sigmas.at("whitened").at("w_c").get<double>(), 8.0 * plain.at("w_c").get<double>(),
              1e-9 * plain.at("w_c").get<double>());
  const Json full = Measured(Load(base + "feature_covariance: [4, 1, 1, 4]\n"));
  EXPECT_NEAR(full.at("whitened").at("w_v").get<double>(),
              plain.at("w_v").get<double>() / std::sqrt(15.0),
              1e-9 * plain.at("w_v").get<double>());
  EXPECT_NE(ErrorOf(base + "feature_covariance: [1, 2, 2, 1]\n").find("positive definite"),
            std::string::npos);
  EXPECT_NE(ErrorOf(base + "feature_sigmas: [1]\n").find("feature_sigmas"), std::string::npos);
  EXPECT_NE(ErrorOf(base + "feature_sigmas: [1, 1]\nfeature_covariance: [1, 0, 0, 1]\n")
                .find("beside feature_sigmas"),
            std::string::npos);
}

TEST_F(MeasureFile, NormalisedUnitsAreThoseOfUnitFocalLength) {
  const std::string base =
      PlanarFile(std::string(kCameraAbove) + "points: [{position: [0, 0, 0]}]\n");
  const Json pixels = Measured(Load(base + "camera: {fx: 500}\n"));
  const Json normalised = Measured(Load(base + "camera: {units: normalised}\n"));
  EXPECT_NEAR(normalised.at("w_c").get<double>() * 500.0 * 500.0, pixels.at("w_c").get<double>(),
              1e-9 * pixels.at("w_c").get<double>());
  EXPECT_EQ(normalised.at("features")[0].at("unit"), "-");
}

TEST(MeasureUnits, FollowFromTheKind) {
  const auto unit = [](FeatureKind kind, int p = 0, int q = 0) {
    return UnitOf({kind, {0, 1, 2, 3}, p, q}, true);
  };
  EXPECT_EQ(unit(FeatureKind::kSegmentAngle), "rad");
  EXPECT_EQ(unit(FeatureKind::kMomentAlpha), "rad");
  EXPECT_EQ(unit(FeatureKind::kMomentBasic, 2, 1), "px^3");
  EXPECT_EQ(unit(FeatureKind::kMomentBasic, 0, 1), "px");
  EXPECT_EQ(unit(FeatureKind::kSegmentInverseLength), "1/px");
  EXPECT_EQ(unit(FeatureKind::kMomentAreaNormalised), "m");
  for (const FeatureKind kind : AllFeatureKinds()) {
    EXPECT_FALSE(unit(kind, 1, 1).empty()) << NameOf(kind);
  }
}

TEST_F(MeasureFile, ChoosesFeaturesAtTheJointsAndAlongThePath) {
  // Looked at from the side, the far point hardly shows the elbow until the arm has turned.
  const std::string base =
      "robot: puma560\njoints_deg: [10, 60, -110, 15, -60, 0]\n"
      "points: [{position: [0.12, 0.10, 0.02]}, {position: [-0.12, 0.10, 0.02]},"
      " {position: [-0.12, -0.10, 0.02]}, {position: [0.12, -0.10, 0.02]}]\n"
      "features: all_points\ncamera: {fx: 300}\n"
      "camera_pose: {position: [1.3, 0.75, 1.2], look_at: [0.63, -0.03, 1.29]}\n";
  const MeasureSetup here = Load(base);
  const FeatureChoice at = ChooseFeatures(here, 6, 50, {});
  ASSERT_EQ(at.selection.status, SelectionStatus::kOk);
  EXPECT_EQ(at.samples, 1);
  EXPECT_TRUE(at.selection.exhaustive);
  EXPECT_EQ(at.selection.sets, 28);
  const MeasureSetup along = Load(base +
                                  "path:\n  - joints_deg: [10, 60, -110, 15, -60, 0]\n"
                                  "  - joints_deg: [-5, 75, -120, -20, -40, 60]\n");
  const FeatureChoice path = ChooseFeatures(along, 6, 20, {});
  ASSERT_EQ(path.selection.status, SelectionStatus::kOk);
  EXPECT_EQ(path.samples, 20);
  // The value is the mean of w_c over the path.
  double mean = 0.0;
  for (int i = 0; i < 20; ++i) {
    const Measurement m = Evaluate(along, JointsAlong(along.waypoints, i / 19.0), along.q_c);
    ASSERT_EQ(m.rows.size(), 8);
    TaskJacobian chosen(6, 6);
    for (int r = 0; r < 6; ++r) chosen.row(r) = m.J_c.row(path.selection.rows[r]);
    mean += MeasureOf(chosen).w / 20.0;
  }
  EXPECT_NEAR(path.selection.value, mean, 1e-9 * mean);
  MeasureReport report = Report(along);
  report.choice = path;
  const Json json = Json::parse(ToJson(along, report)).at("selection");
  EXPECT_EQ(json.at("status"), "OK");
  EXPECT_EQ(json.at("features").size(), 6u);
  EXPECT_EQ(json.at("names").size(), 6u);
  EXPECT_EQ(json.at("samples"), 20);
  EXPECT_NE(ToTable(along, report).find("mean of 20 configurations along the path"),
            std::string::npos);
}

TEST(MeasureProgram, Selects) {
  const std::string oracle = " --json --oracle-case " VANTAGE_TEST_DATA "/oracles.json D06";
  const auto run = RunProgram(VANTAGE_MEASURE + oracle + " --select 6");
  ASSERT_EQ(run.exit_code, 0);
  const Json selection = Json::parse(run.output).at("selection");
  EXPECT_EQ(selection.at("features"), Json({4, 5, 8, 9, 10, 11}));
  EXPECT_EQ(selection.at("sets"), 924);
  for (const char* by : {"w_c", "sigma_min", "trace"}) {
    const auto other = RunProgram(VANTAGE_MEASURE + oracle + " --select 6 --by " + by);
    EXPECT_EQ(Json::parse(other.output).at("selection").at("criterion"), by);
  }
  const auto table = RunProgram(VANTAGE_MEASURE " ur5 --select 6 --by sigma_min");
  EXPECT_NE(table.output.find("Selection: 6 of 8 features by sigma_min"), std::string::npos);
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
  for (const char* arguments :
       {"", "no-such", "/no/such.yaml", "ur5 --oracle-case a b", "ur5 --select 9",
        "--oracle-case " VANTAGE_TEST_DATA "/oracles.json ZZ"}) {
    SCOPED_TRACE(arguments);
    const auto run = RunProgram(std::string(VANTAGE_MEASURE " ") + arguments);
    EXPECT_EQ(run.exit_code, 2);
    EXPECT_EQ(std::count(run.output.begin(), run.output.end(), '\n'), 1) << run.output;
  }
}

TEST(MeasureProgram, BadOptionsAreNamedAndExitCode2) {
  for (const char* arguments : {"--select 0", "--by trace", "--select 4 --by size",
                                "--select 4 --over all", "--select 4 --samples 1"}) {
    SCOPED_TRACE(arguments);
    const auto run = RunProgram(std::string(VANTAGE_MEASURE " ur5 ") + arguments);
    EXPECT_EQ(run.exit_code, 2);
    EXPECT_EQ(run.output.rfind("vantage-measure: --", 0), 0u) << run.output;
  }
}

TEST(MeasureProgram, HasHelpAndVersion) {
  EXPECT_EQ(RunProgram(VANTAGE_MEASURE " --help").exit_code, 0);
  EXPECT_EQ(RunProgram(VANTAGE_MEASURE " --version").output.rfind("vantage ", 0), 0u);
}

}  // namespace
}  // namespace vantage
