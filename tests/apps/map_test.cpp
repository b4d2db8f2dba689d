#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "config_error.h"
#include "map_plot.h"
#include "map_recipe.h"
#include "map_sweep.h"
#include "measure_print.h"
#include "oracle_arm.h"
#include "program.h"
#include "read_file.h"
#include "temporary_folder.h"
#include "vantage/config/config_text.h"
#include "vantage/math/angles.h"

namespace vantage {
namespace {

using Json = nlohmann::json;
using test::ConfigErrorOf;
using test::ReadFile;
using test::RunProgram;

// Lines of a table, cells as text.
std::vector<std::vector<std::string>> ReadTable(const std::string& path) {
  std::vector<std::vector<std::string>> lines;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    lines.emplace_back();
    std::istringstream cells(line + ",");
    for (std::string cell; std::getline(cells, cell, ',');) lines.back().push_back(cell);
  }
  return lines;
}

int ColumnOf(const std::vector<std::string>& header, const std::string& name) {
  const auto found = std::find(header.begin(), header.end(), name);
  return found == header.end() ? -1 : static_cast<int>(found - header.begin());
}

// (x, y, w_c) of a written table.
struct Row {
  double x, y, w_c;
};

std::vector<Row> TableOf(const MapRecipe& recipe, const test::TemporaryFolder& folder) {
  const std::string path = (folder.path() / "map.csv").string();
  WriteCsv(recipe, Sweep(recipe), path);
  const auto lines = ReadTable(path);
  const int w_c = ColumnOf(lines.at(0), "w_c");
  std::vector<Row> rows;
  for (std::size_t i = 1; i < lines.size(); ++i) {
    rows.push_back(
        {std::stod(lines[i].at(0)), std::stod(lines[i].at(1)), std::stod(lines[i].at(w_c))});
  }
  return rows;
}

// Relative to the value, where that is not zero to rounding.
void ExpectRelative(double actual, double expected, double tolerance, double scale) {
  EXPECT_NEAR(actual, expected, tolerance * std::max(std::abs(expected), 1e-3 * scale));
}

TEST(MapFigures, Figure3IsTheClosedFormInEveryLineOfItsTable) {
  const test::TemporaryFolder folder;
  const MapRecipe recipe = FindMapRecipe("fig3");
  const std::vector<Row> rows = TableOf(recipe, folder);
  ASSERT_EQ(rows.size(), 41u * 61u);
  Row least = rows[0], greatest = rows[0];
  for (const Row& row : rows) {
    const double depth = row.x * std::cos(row.y);
    EXPECT_NEAR(row.w_c, 100.0 / (depth * depth), 1e-12);
    if (row.w_c < least.w_c) least = row;
    if (row.w_c > greatest.w_c) greatest = row;
  }
  EXPECT_NEAR(greatest.w_c, 4.0 / 9.0, 1e-12);
  EXPECT_DOUBLE_EQ(greatest.x, 30.0);
  EXPECT_DOUBLE_EQ(greatest.y, kPi / 3.0);
  EXPECT_NEAR(least.w_c, 1.0 / 16.0, 1e-12);
  EXPECT_DOUBLE_EQ(least.x, 40.0);
  EXPECT_DOUBLE_EQ(least.y, 0.0);
}

TEST(MapFigures, Figure3HoldsTheOraclesSamples) {
  const MapRecipe recipe = FindMapRecipe("fig3");
  const Json oracles = test::ReadOracles();
  for (const Json& sample : oracles.at("planar").at("fig3").at("samples")) {
    const MapCell cell =
        EvaluateCell(recipe, sample.at("R").get<double>(), sample.at("theta").get<double>());
    EXPECT_NEAR(cell.w_c, sample.at("w_c").get<double>(), 1e-12);
    EXPECT_NEAR(cell.paper_product, cell.w_c, 1e-12);  // The product is exact for this arm.
    EXPECT_NEAR(cell.w_r_translation, 100.0, 1e-10);
  }
}

TEST(MapFigures, Figure4IsTheClosedFormInEveryLineOfItsTable) {
  const test::TemporaryFolder folder;
  const std::vector<Row> rows = TableOf(FindMapRecipe("fig4"), folder);
  ASSERT_EQ(rows.size(), 61u * 61u);
  Row greatest = rows[0];
  for (const Row& row : rows) {
    const double depth = 100.0 * std::cos(row.x);
    EXPECT_NEAR(row.w_c, 100.0 * std::abs(std::sin(row.y)) / (depth * depth), 1e-12);
    if (row.w_c > greatest.w_c) greatest = row;
  }
  EXPECT_NEAR(greatest.w_c, 0.04, 1e-12);
  EXPECT_DOUBLE_EQ(greatest.x, kPi / 3.0);
  EXPECT_DOUBLE_EQ(greatest.y, kPi / 2.0);
}

TEST(MapFigures, Figure4IsZeroWhereTheArmIsSingularAndItsRidgeIsTheBoundary) {
  const MapRecipe recipe = FindMapRecipe("fig4");
  EXPECT_NEAR(EvaluateCell(recipe, 0.0, kPi / 2.0).w_c, 0.01, 1e-12);
  const SweepAxis& theta = recipe.axes[0];
  for (int row = 0; row < recipe.axes[1].samples; ++row) {
    const double theta2 = ValueAt(recipe.axes[1], row);
    double before = -1.0;
    for (int i = 0; i < theta.samples; ++i) {
      const MapCell cell = EvaluateCell(recipe, ValueAt(theta, i), theta2);
      if (row == 0 || row == recipe.axes[1].samples - 1) {
        EXPECT_NEAR(cell.w_c, 0.0, 1e-12);
        EXPECT_EQ(cell.rank_c, 1);
      } else {
        EXPECT_GT(cell.w_c, before);  // It grows all the way to theta = pi/3.
        before = cell.w_c;
      }
    }
  }
}

// The sentence below the paper's Fig. 3: "observability would increase as either R or theta decreases",
// and theta = pi/2 is singular.
TEST(MapFigures, TheSentenceBelowFigure3IsHalfTrueOfThePapersCamera) {
  const MapRecipe recipe = FindMapRecipe("fig3");
  for (const double theta : {0.0, 0.3, 0.6, 1.0}) {
    for (const double R : {30.0, 33.0, 36.0, 39.0}) {
      const double here = EvaluateCell(recipe, R, theta).w_v_translation;
      EXPECT_GT(here, EvaluateCell(recipe, R + 1.0, theta).w_v_translation);   // True of R,
      EXPECT_LT(here, EvaluateCell(recipe, R, theta + 0.04).w_v_translation);  // false of theta:
    }
  }
  // it grows without bound towards pi/2 (a depth of 0.03 there, 30 at theta = 0).
  EXPECT_GT(EvaluateCell(recipe, 30.0, kPi / 2.0 - 1e-3).w_v_translation,
            1e5 * EvaluateCell(recipe, 30.0, 0.0).w_v_translation);
}

TEST(MapFigures, TheSentenceBelowFigure3IsTrueOfACameraThatLooksAtTheOrigin) {
  const MapRecipe recipe = FindMapRecipe("fig3-look-at");
  for (const double theta : {0.0, 0.3, 0.6, 1.0}) {
    for (const double R : {30.0, 33.0, 36.0, 39.0}) {
      const double here = EvaluateCell(recipe, R, theta).w_c;
      EXPECT_NEAR(here, 100.0 * std::cos(theta) / (R * R), 1e-12);
      EXPECT_GT(here, EvaluateCell(recipe, R + 1.0, theta).w_c);
      EXPECT_GT(here, EvaluateCell(recipe, R, theta + 0.04).w_c);
    }
  }
  const MapCell edge_on = EvaluateCell(recipe, 30.0, kPi / 2.0);
  EXPECT_NEAR(edge_on.w_c, 0.0, 1e-12);
  EXPECT_EQ(edge_on.rank_c, 1);
}

// docs/paper.md, Fig. 3, for any place of the camera and the point.
TEST(MapFigures, ACameraThatLooksAtTheOriginHasTheClosedForm) {
  MapRecipe recipe = FindMapRecipe("fig3-look-at");
  recipe.setup.translation_task = 2;
  for (const double phi : {-2.1, -0.7, 0.0, 0.9, 3.0}) {
    recipe.setup.q_c(2) = phi;
    for (const double theta1 : {-0.8, 0.0, 1.3}) {
      recipe.setup.q(0) = theta1;
      const double X = 10.0 * (std::sin(theta1) + std::sin(theta1 + kPi / 2.0));
      const double Y = 10.0 * (std::cos(theta1) + std::cos(theta1 + kPi / 2.0));
      for (const double theta : {0.1, 0.5, 1.0}) {
        const double depth = 35.0 - std::sin(theta) * (X * std::cos(phi) + Y * std::sin(phi));
        const double w_v = 35.0 * std::cos(theta) / (depth * depth * depth);
        EXPECT_NEAR(EvaluateCell(recipe, 35.0, theta).w_v_translation, w_v, 1e-12);
      }
    }
  }
}

// The oracle's variants of Figs 6 and 7: arm and second point.
struct Variant {
  const char* name;
  bool puma560;
  Eigen::Vector3d second_point;
};

std::ostream& operator<<(std::ostream& stream, const Variant& variant) {
  return stream << variant.name;
}

class PumaFigures : public ::testing::TestWithParam<Variant> {
 protected:
  static MapRecipe Recipe(const std::string& figure) {
    MapRecipe recipe = FindMapRecipe(figure);
    recipe.setup.points[1].marker.p = GetParam().second_point;
    if (!GetParam().puma560) return recipe;
    for (const Json& entry : Cases()) {
      if (entry.at("id") == "C01") recipe.setup.arm = test::OracleArm(entry.at("robot"));
    }
    recipe.setup.q_c(0) = 2.5;
    if (figure == "fig6b") {
      recipe.axes[0].from = 1.5;
      recipe.axes[0].to = 4.0;
    }
    return recipe;
  }

  static const Json& Oracles() {
    static const Json oracles = test::ReadOracles();
    return oracles;
  }
  static const Json& Cases() { return Oracles().at("cases"); }

  // The extremes must be the oracle's, and the greatest value must stand where it says.
  static void Check(const MapRecipe& recipe, const std::vector<double>& values,
                    const Json& expected) {
    const double max = expected.at("max").get<double>();
    const double min = expected.at("min").get<double>();
    ExpectRelative(*std::max_element(values.begin(), values.end()), max, 1e-9, max);
    EXPECT_NEAR(*std::min_element(values.begin(), values.end()), min, 1e-9 * min + 1e-12 * max);
    // Equal maxima may stand elsewhere too: the value at the oracle's place decides.
    const auto place = [&](const SweepAxis& axis) {
      const Json& at = expected.at("argmax");
      const bool joints = axis.kind == SweepAxis::Kind::kJoint;
      const double value = at.at(joints ? "t" : axis.name).get<double>();
      const double step = (axis.to - axis.from) / (axis.samples - 1);
      const double index = (value - axis.from) / step;
      EXPECT_NEAR(index, std::round(index), 1e-9);
      return static_cast<std::size_t>(std::lround(index));
    };
    const std::size_t cell = place(recipe.axes[1]) * recipe.axes[0].samples + place(recipe.axes[0]);
    ASSERT_LT(cell, values.size());
    ExpectRelative(values[cell], max, 1e-9, max);
  }

  static std::vector<double> Values(const MapRecipe& recipe, MapQuantity quantity) {
    std::vector<double> values;
    for (const MapCell& cell : Sweep(recipe).cells) {
      EXPECT_TRUE(cell.complete);
      values.push_back(ValueOf(cell, quantity).value_or(-1.0));
    }
    return values;
  }
};

TEST_P(PumaFigures, HaveTheOraclesStatistics) {
  for (const std::string figure : {"fig6a", "fig6b", "fig7"}) {
    SCOPED_TRACE(figure);
    const Json& expected = Oracles().at("puma").at("figures").at(GetParam().name).at(figure);
    MapRecipe recipe = Recipe(figure);
    const std::vector<double> level = Values(recipe, MapQuantity::kCompositeW);
    Check(recipe, level, expected.at("wc"));
    Check(recipe, Values(recipe, MapQuantity::kPaperProduct), expected.at("wc_tr"));

    // w_c(roll) = |A cos(roll) + B sin(roll)|: two rolls tell the greatest.
    recipe.setup.q_c(3) = kPi / 2.0;
    std::vector<double> best = Values(recipe, MapQuantity::kCompositeW);
    std::transform(best.begin(), best.end(), level.begin(), best.begin(),
                   [](double a, double b) { return std::hypot(a, b); });
    Check(recipe, best, expected.at("wc_rollmax"));

    recipe.setup.features = FeatureSet::AllPoints(2);
    Check(recipe, Values(recipe, MapQuantity::kCompositeW), expected.at("w4"));
  }
}

INSTANTIATE_TEST_SUITE_P(Variants, PumaFigures,
                         ::testing::Values(Variant{"S_inplane", false, {0, 2, 0}},
                                           Variant{"S_lateral", false, {0, 0, 2}},
                                           Variant{"S_along", false, {-4, 0, 0}},
                                           Variant{"P560_inplane", true, {0.1, 0, 0}},
                                           Variant{"P560_lateral", true, {0, 0.1, 0}}),
                         [](const auto& instance) { return std::string(instance.param.name); });

TEST(MapRecipes, AllBuiltInOnesLoadAndDescribeThemselves) {
  const std::vector<std::string> names = BuiltInConfigs(ConfigKind::kRecipe);
  for (const char* name : {"fig3", "fig3-look-at", "fig4", "fig6a", "fig6b", "fig7"}) {
    EXPECT_EQ(std::count(names.begin(), names.end(), name), 1) << name;
  }
  for (const std::string& name : names) {
    EXPECT_FALSE(FindMapRecipe(name).setup.description.empty()) << name;
  }
}

constexpr char kSetup[] =
    "robot: puma3\njoints_deg: [0, 40, -60]\nfeatures: all_points\n"
    "points: [{position: [0, 0, 0]}, {position: [-0.1, 0.05, 0]}]\n"
    "camera_sphere: {R: 2, theta_deg: 30, phi_deg: 20, target: [0.5, 0, 0.7]}\n";

class RecipeFile : public ::testing::Test {
 protected:
  MapRecipe Load(const std::string& text) const {
    return FindMapRecipe(folder_.Write("recipe.yaml", kSetup + text));
  }
  std::string ErrorOf(const std::string& text) const {
    return ConfigErrorOf([&] { (void)Load(text); });
  }
  test::TemporaryFolder folder_;
};

TEST_F(RecipeFile, APathSetsAllJoints) {
  const MapRecipe recipe = Load(
      "path: [{joints_deg: [0, 40, -60]}, {joints_deg: [10, 50, -40]}, {joints_deg: [20, 20, "
      "20]}]\n"
      "sweep: {x: {axis: path, samples: 5}, y: {axis: theta, from_deg: 10, to_deg: 50}}\n");
  const JointVector half = JointsAlong(recipe.setup.waypoints, 0.5);
  EXPECT_NEAR(half(1), 50.0 * kPi / 180.0, 1e-15);
  const JointVector three_quarters = JointsAlong(recipe.setup.waypoints, 0.75);
  EXPECT_NEAR(three_quarters(0), 15.0 * kPi / 180.0, 1e-15);
  EXPECT_EQ(JointsAlong(recipe.setup.waypoints, 1.0), recipe.setup.waypoints[2]);
  MeasureSetup setup = recipe.setup;
  setup.q_c(1) = 0.4;
  EXPECT_EQ(EvaluateCell(recipe, 0.75, 0.4).w_c,
            Evaluate(setup, three_quarters, setup.q_c).composite.measure.w);
}

TEST_F(RecipeFile, ASingleJointIsSetAfterAPath) {
  const MapRecipe recipe = Load(
      "path: [{joints_deg: [0, 40, -60]}, {joints_deg: [10, 50, -40]}]\n"
      "sweep: {x: {axis: elbow, from_deg: -90, to_deg: -20}, y: {axis: path, samples: 3}}\n");
  JointVector q = JointsAlong(recipe.setup.waypoints, 0.5);
  q(2) = -1.0;
  EXPECT_EQ(EvaluateCell(recipe, -1.0, 0.5).w_c,
            Evaluate(recipe.setup, q, recipe.setup.q_c).composite.measure.w);
}

// What an axis is follows from the rig, not from its name.
TEST_F(RecipeFile, ASlidingJointOfAnArmThatCarriesTheCameraIsALength) {
  const MapRecipe recipe = FindMapRecipe(folder_.Write(
      "carried.yaml",
      "robot: puma3\njoints_deg: [0, 40, -60]\nfeatures: all_points\n"
      "points: [{position: [0, 0, 0]}, {position: [-0.1, 0.05, 0]}]\n"
      "camera_rig:\n  kind: arm\n"
      "  pose: {position: [2, 0, 1.5], look_at: [0.5, 0, 0.7]}\n"
      "  joints: [{name: lift, prismatic: true, axis: [0, 0, 1]}, {name: s, axis: [0, 0, 1], "
      "point: [2, 0, 0]}]\n"
      "  axes:\n"
      "    lift: {lower: -1, upper: 1, start: 0, max_speed: 1, max_acceleration: 1}\n"
      "    s: {lower_deg: -90, upper_deg: 90, start_deg: 10, max_speed_deg_s: 9, "
      "max_acceleration_deg_s2: 9}\n"
      "sweep: {x: {axis: lift, from: -0.2, to: 0.2}, y: {axis: s, from_deg: -10, to_deg: 10}}\n"));
  EXPECT_EQ(recipe.axes[0].unit, "m");
  EXPECT_EQ(recipe.axes[1].unit, "rad");
  EXPECT_EQ(recipe.axes[0].to, 0.2);
  const std::string table = ToTable(recipe.setup, Report(recipe.setup));
  EXPECT_NE(table.find("lift 0 m, s 10 deg"), std::string::npos) << table;
}

TEST_F(RecipeFile, SweepHasExactEndsAndRunsXFastest) {
  const MapRecipe recipe = Load(
      "sweep: {x: {axis: R, from: 1.1, to: 2.3, samples: 4}, y: {axis: waist, from_deg: -30, "
      "to_deg: 30, samples: 3}}\n");
  int last = 0;
  const MapTable table = Sweep(recipe, [&](int done, int rows) {
    EXPECT_EQ(rows, 3);
    EXPECT_GE(done, last);
    last = done;
  });
  ASSERT_EQ(table.cells.size(), 12u);
  EXPECT_EQ(table.cells[3].x, 2.3);
  EXPECT_EQ(table.cells[3].y, table.cells[0].y);
  EXPECT_EQ(table.cells[11].y, 30.0 * (kPi / 180.0));
  for (const MapCell& cell : table.cells) {
    EXPECT_EQ(cell.w_c, EvaluateCell(recipe, cell.x, cell.y).w_c);
  }
}

TEST_F(RecipeFile, CellsThatDoNotSeeAllAreEmptyInTheTableAndHolesInThePictures) {
  // The camera passes below the points on its way round: they leave the image and fall behind it.
  const MapRecipe recipe = Load(
      "sweep: {x: {axis: R, from: 0.1, to: 1.5, samples: 8}, y: {axis: theta, from_deg: 0, to_deg: "
      "170, samples: 18}}\nplot: {show: sigma_min_c}\n");
  const MapTable table = Sweep(recipe);
  const auto complete = std::count_if(table.cells.begin(), table.cells.end(),
                                      [](const MapCell& cell) { return cell.complete; });
  ASSERT_GT(complete, 0);
  ASSERT_LT(complete, static_cast<std::ptrdiff_t>(table.cells.size()));
  const std::string csv = (folder_.path() / "map.csv").string();
  WriteCsv(recipe, table, csv);
  const auto lines = ReadTable(csv);
  const int w_c = ColumnOf(lines[0], "w_c"), w_r = ColumnOf(lines[0], "w_r");
  for (std::size_t i = 0; i < table.cells.size(); ++i) {
    EXPECT_EQ(lines[i + 1].at(w_c).empty(), !table.cells[i].complete);
    EXPECT_FALSE(lines[i + 1].at(w_r).empty());  // The arm's measure needs no camera.
  }
  EXPECT_EQ(ReadFile(csv).find("nan"), std::string::npos);
  const auto files =
      PlotMap(recipe, table, MapQuantity::kSigmaMin, (folder_.path() / "map").string());
  EXPECT_EQ(files.size(), 5u);
}

TEST_F(RecipeFile, PicturesArePngAndSvgWithTheirLabels) {
  const MapRecipe recipe = Load(
      "sweep: {x: {axis: R, from: 1.5, to: 2.5, samples: 5}, y: {axis: theta, from_deg: 0, to_deg: "
      "60, samples: 5}}\nplot: {title: 'A \"title\" with $, ` and \\\\', notes: chosen here}\n");
  const auto files =
      PlotMap(recipe, Sweep(recipe), MapQuantity::kCompositeW, (folder_.path() / "map").string());
  int png = 0, svg = 0;
  for (const std::string& file : files) {
    const std::string text = ReadFile(file);
    if (file.substr(file.size() - 4) == ".png") {
      EXPECT_EQ(text.substr(1, 3), "PNG");
      EXPECT_GT(text.size(), 10000u);
      ++png;
    }
    if (file.substr(file.size() - 4) == ".svg") {
      EXPECT_NE(text.find("</svg>"), std::string::npos);
      EXPECT_NE(text.find("R [m]"), std::string::npos);
      EXPECT_NE(text.find("θ [rad]"), std::string::npos);
      EXPECT_NE(text.find("chosen here"), std::string::npos);
      EXPECT_NE(text.find("(px/rad)"), std::string::npos);
      ++svg;
    }
  }
  EXPECT_EQ(png, 2);
  EXPECT_EQ(svg, 2);
}

TEST_F(RecipeFile, ErrorsNameTheKey) {
  const std::string y = ", y: {axis: theta, from_deg: 0, to_deg: 60}}\n";
  EXPECT_NE(ErrorOf("sweep: {x: {axis: wrist, from: 0, to: 1}" + y).find("neither an axis"),
            std::string::npos);
  EXPECT_NE(ErrorOf("sweep: {x: {axis: elbow, from: 0, to: 1}" + y).find("from_deg"),
            std::string::npos);
  EXPECT_NE(ErrorOf("sweep: {x: {axis: elbow, from_deg: 0, to_deg: 300}" + y)
                .find("the range of elbow must be in [-"),
            std::string::npos);
  EXPECT_NE(ErrorOf("sweep: {x: {axis: R, from: 1, to: 1}" + y).find("empty"), std::string::npos);
  EXPECT_NE(ErrorOf("sweep: {x: {axis: path}" + y).find("neither an axis"), std::string::npos);
  EXPECT_NE(ErrorOf("sweep: {x: {axis: R, from: 1, to: 2}" + y + "plot: {show: paper_product}\n")
                .find("translation_task"),
            std::string::npos);
}

TEST(MapProgram, WritesTableAndPictures) {
  const test::TemporaryFolder folder;
  const std::string out = folder.path().string();
  const auto run = RunProgram(VANTAGE_MAP " fig3 --samples 5 7 --out " + out);
  EXPECT_EQ(run.exit_code, 0) << run.output;
  EXPECT_NE(run.output.find("max 0.444444"), std::string::npos);
  EXPECT_EQ(ReadTable(out + "/fig3.csv").size(), 36u);
  for (const char* name : {"surface.png", "surface.svg", "heat.png", "heat.svg"}) {
    EXPECT_TRUE(std::filesystem::exists(out + "/fig3_w_c_" + name)) << name;
  }
}

TEST(MapProgram, BadInputIsOneLineAndExitCode2) {
  for (const char* arguments : {"", "no-such", "/no/such.yaml", "fig3 --out /proc/no"}) {
    SCOPED_TRACE(arguments);
    const auto run = RunProgram(std::string(VANTAGE_MAP " ") + arguments);
    EXPECT_EQ(run.exit_code, 2);
    EXPECT_EQ(std::count(run.output.begin(), run.output.end(), '\n'), 1) << run.output;
  }
}

}  // namespace
}  // namespace vantage
