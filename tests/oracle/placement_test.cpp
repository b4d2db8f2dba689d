// Placement problems of the oracle file: what they state is evaluated at the cameras they name. Finding
// those cameras is the planner's work, and tested with it.
#include <algorithm>
#include <cmath>
#include <functional>
#include <iostream>
#include <limits>
#include <map>
#include <regex>

#include "paper_cells.h"
#include "vantage/observability/selection.h"

namespace vantage::test {
namespace {

using Quantity = std::function<double(const Evaluated&)>;

// "placement": value <= expected + 1e-6 |expected|, polished 1e-7: at a given camera there is no
// search, and the value itself is asked for.
constexpr double kCostTolerance = 1e-9;
// Two optimisers' values of one optimum.
constexpr double kPolished = 1e-7;

double ViewOfPoint(const Evaluated& e) {
  return ProductOf(e, 2).view.w;
}
double Composite(const Evaluated& e) {
  return e.composite.w;
}

// A cell and the path of its arm, sampled.
struct Path {
  OracleCase cell;
  std::vector<JointVector> q;
  double step;

  // Eq. 13: -∫ w dt by the trapezoid rule.
  [[nodiscard]] double Cost(const Sphere& camera, const Quantity& w) const {
    std::vector<double> values;
    for (const JointVector& at : q) values.push_back(w(At(cell, at, camera)));
    return -Trapezoid(values, step);
  }
  // Eq. 16: max over the path of -w.
  [[nodiscard]] double Worst(const Sphere& camera, const Quantity& w) const {
    double least = std::numeric_limits<double>::infinity();
    for (const JointVector& at : q) least = std::min(least, w(At(cell, at, camera)));
    return -least;
  }
  // By how much every point keeps within the image and behind the least depth; < 0: it does not.
  struct Slack {
    double x_low{1e9}, x_high{1e9}, y_low{1e9}, y_high{1e9}, depth{1e9};
  };
  [[nodiscard]] Slack SlackOf(const Sphere& camera, double tan_half, double least_depth) const {
    Slack slack;
    for (const JointVector& at : q) {
      for (const PointView& view : At(cell, at, camera).views) {
        EXPECT_TRUE(view.visible);
        const Eigen::Vector2d& n = view.image.n;
        slack.x_low = std::min(slack.x_low, n.x() + tan_half);
        slack.x_high = std::min(slack.x_high, tan_half - n.x());
        slack.y_low = std::min(slack.y_low, n.y() + tan_half);
        slack.y_high = std::min(slack.y_high, tan_half - n.y());
        slack.depth = std::min(slack.depth, (view.image.depth - least_depth) / least_depth);
      }
    }
    return slack;
  }
};

Sphere SphereOf(const Node& x) {
  return {x.at("R"), x.at("theta"), x.at("phi")};
}
Sphere SphereOfList(const Node& x) {
  return {x.at(0), x.at(1), x.at(2)};
}

// theta1 = 0, theta2 from 0 to `end`.
Path PlanarPath(RigOrientation orientation, double end, int samples) {
  Path path{PointCell(PlanarArm(10, 10), orientation, 1.0), {}, end / (samples - 1)};
  for (const double theta2 : Linspace(0.0, end, samples)) path.q.push_back(Joints({0.0, theta2}));
  return path;
}

Path PumaPath(bool all_four) {
  Path path{TwoPointCell(SimplePuma(10, 10, 0), {0, 2, 0}, 1.0, all_four), {}, kPi / 180};
  for (const double t : Linspace(0.0, kPi, 181)) path.q.push_back(Joints({t, t, t}));
  return path;
}

// Value and x of one optimum, and the second optimiser's where the file has it.
void ExpectCost(const Node& optimum, const std::function<double(const Sphere&)>& cost) {
  EXPECT_TRUE(RelativelyNear(cost(SphereOf(optimum.at("x"))), optimum.at("value"), kCostTolerance));
  if (optimum.contains("de_x")) {
    EXPECT_TRUE(RelativelyNear(cost(SphereOfList(optimum.at("de_x"))), optimum.at("de_value"),
                               kCostTolerance));
  }
  if (optimum.contains("slsqp_value")) {
    EXPECT_TRUE(RelativelyNear(optimum.at("slsqp_value"), optimum.at("value"), kPolished));
  }
  if (optimum.contains("grid_best")) {
    EXPECT_LE(optimum.at("value").get<double>(), optimum.at("grid_best").get<double>());
  }
}

// The constraints hold at the optimum, and those called active are met with equality.
void ExpectConstraints(const Node& optimum, const Path& path, double tan_half, double least_depth) {
  constexpr double kActive = 1e-6;
  const Path::Slack slack = path.SlackOf(SphereOf(optimum.at("x")), tan_half, least_depth);
  const std::map<std::string, double> slacks{{"x>=", slack.x_low},
                                             {"x<=", slack.x_high},
                                             {"y>=", slack.y_low},
                                             {"y<=", slack.y_high},
                                             {"z>=", slack.depth}};
  for (const auto& [name, value] : slacks) EXPECT_GE(value, -kActive) << name;
  if (!optimum.contains("active")) return;
  for (const Node& name : optimum.at("active").elements()) {
    EXPECT_NEAR(slacks.at(name.get<std::string>()), 0.0, kActive) << name;
  }
}

void PlanarFixedOrientation(const Node& problem) {
  // The integrand is smooth: Simpson's rule on 2001 samples is exact to 1e-13.
  const Path path = PlanarPath(RigOrientation::kFixedDown, kPi, 2001);
  const auto integral = [&](const Sphere& camera, const Quantity& w) {
    double sum = 0.0;
    for (std::size_t i = 0; i < path.q.size(); ++i) {
      const bool end = i == 0 || i + 1 == path.q.size();
      sum += (end ? 1.0 : i % 2 == 1 ? 4.0 : 2.0) * w(At(path.cell, path.q[i], camera));
    }
    return -sum * path.step / 3.0;
  };
  const Node x = problem.at("optimum");
  const Sphere best{x.at("R"), x.at("theta"), 0.3};
  EXPECT_TRUE(RelativelyNear(integral(best, ViewOfPoint), problem.at("cost13_wv"), kCostTolerance));
  EXPECT_TRUE(RelativelyNear(integral(best, Composite), problem.at("cost13_wc"), kCostTolerance));
  EXPECT_TRUE(
      RelativelyNear(path.Worst(best, ViewOfPoint), problem.at("minimax16_wv"), kCostTolerance));
  EXPECT_EQ(problem.at("minimax16_wc").get<double>(), 0.0);
  EXPECT_NEAR(path.Worst(best, Composite), 0.0, 1e-12);
  for (const double R : Linspace(30, 40, 5)) {
    for (const double theta : Linspace(0, kPi / 3, 5)) {
      EXPECT_GE(integral({R, theta, 0.3}, Composite),
                problem.at("cost13_wc").get<double>() * (1 + kCostTolerance));
    }
  }
}

void PlanarFixedOrientationInTheImage(const Node& problem) {
  const Path path = PlanarPath(RigOrientation::kFixedDown, kPi, 181);
  const Node optimum = problem.at("optimum");
  constexpr double kHalf = 0.3;
  const auto check = [&](const Sphere& camera, double w_v, double least_slack) {
    for (const JointVector& q : path.q) {
      EXPECT_TRUE(RelativelyNear(ViewOfPoint(At(path.cell, q, camera)), w_v, kCostTolerance));
    }
    const Path::Slack slack = path.SlackOf(camera, kHalf, 1.0);
    EXPECT_NEAR(std::min({slack.x_low, slack.x_high, slack.y_low, slack.y_high}), least_slack,
                1e-9);
  };
  check(SphereOf(optimum.at("example")), problem.at("w_v"), 0.0);
  if (problem.contains("de_check")) {
    check(SphereOfList(problem.at("de_check").at("x")), problem.at("de_check").at("w_v"),
          problem.at("de_check").at("slack"));
  }
  const Sphere best = SphereOf(optimum.at("example"));
  EXPECT_NEAR(best.R * std::cos(best.theta), optimum.at("height_Rcos"), 1e-9);
  EXPECT_NEAR(best.R * std::sin(best.theta) * std::sin(best.phi), optimum.at("Yc"), 1e-9);
  // Twice the largest half-extent of the path: its y runs from 0 to 20.
  EXPECT_TRUE(RelativelyNear(problem.at("w_v"), kHalf * kHalf / 100.0, kCostTolerance));
  EXPECT_TRUE(
      RelativelyNear(path.Cost(best, ViewOfPoint), problem.at("cost13_wv"), kCostTolerance));
  EXPECT_TRUE(
      RelativelyNear(path.Worst(best, ViewOfPoint), problem.at("minimax16_wv"), kCostTolerance));
  // ∫ |sin| over the path is 2 exactly; the trapezoid rule of 181 samples misses it by 5e-5.
  const double trapezoid = path.Cost(best, Composite);
  EXPECT_NEAR(trapezoid, problem.at("cost13_wc"), 1e-4 * std::abs(trapezoid));
}

void PlanarLookAt(const Node& problem) {
  const Path path = PlanarPath(RigOrientation::kLookAt, kPi, 181);
  ExpectCost(problem.at("cost13_wv"), [&](const Sphere& c) { return path.Cost(c, ViewOfPoint); });
  ExpectCost(problem.at("cost13_wc"), [&](const Sphere& c) { return path.Cost(c, Composite); });
  ExpectCost(problem.at("minimax16_wv"),
             [&](const Sphere& c) { return path.Worst(c, ViewOfPoint); });
}

void PlanarLookAtInTheImage(const Node& problem) {
  PlanarLookAt(problem);
  const Path path = PlanarPath(RigOrientation::kLookAt, kPi, 181);
  for (const char* name : {"cost13_wv", "cost13_wc", "minimax16_wv"}) {
    SCOPED_TRACE(name);
    ExpectConstraints(problem.at(name), path, 0.4, 15.0);
  }
}

void PumaInTheImage(const Node& problem, bool all_four) {
  const Path path = PumaPath(all_four);
  const Node optimum = problem.at("cost13_wc");
  ExpectCost(optimum, [&](const Sphere& c) { return path.Cost(c, Composite); });
  ExpectConstraints(optimum, path, 0.5, 10.0);
  for (const Node& local : optimum.at("distinct_local_values").elements()) {
    EXPECT_GE(local.get<double>(), optimum.at("value").get<double>() - 1e-11);
  }
  // The folded arm at the end of the path is seen by no camera.
  EXPECT_EQ(problem.at("minimax16_wc").at("value").get<double>(), 0.0);
  for (const Sphere& camera : {Sphere{34, 0.4, 2.6}, Sphere{50, 1.2, -1.0}, Sphere{40, 0.3, 1.0}}) {
    const Evaluated e = At(path.cell, path.q.back(), camera);
    EXPECT_LE(e.composite.w, kZeroTolerance * std::pow(e.composite.sigma(0), 3));
    EXPECT_LT(e.composite.rank, 3);
  }
}

void CameraTrajectory(const Node& problem) {
  const Path path = PlanarPath(RigOrientation::kLookAt, 2 * kPi, 73);
  constexpr int kStates = 72;
  const auto phi_of = [](int state) { return (-180.0 + 5.0 * state) * kPi / 180.0; };
  const auto samples = static_cast<int>(path.q.size());
  // w[i][s]: weight times w_v of sample i seen from state s.
  std::vector<std::vector<double>> w(samples, std::vector<double>(kStates));
  for (int i = 0; i < samples; ++i) {
    const double weight = (i == 0 || i + 1 == samples ? 0.5 : 1.0) * path.step;
    for (int s = 0; s < kStates; ++s) {
      w[i][s] = weight * ViewOfPoint(At(path.cell, path.q[i], {30.0, 0.8, phi_of(s)}));
    }
  }
  const auto fixed_value = [&](int state) {
    double sum = 0.0;
    for (int i = 0; i < samples; ++i) sum -= w[i][state];
    return sum;
  };
  const auto state_of = [&](double degrees) {
    return (static_cast<int>(std::lround((degrees + 180.0) / 5.0)) % kStates + kStates) % kStates;
  };
  const Node fixed = problem.at("fixed");
  double best_fixed = 0.0;
  for (int s = 0; s < kStates; ++s) best_fixed = std::min(best_fixed, fixed_value(s));
  EXPECT_TRUE(RelativelyNear(fixed_value(state_of(fixed.at("phi_deg"))), fixed.at("value"),
                             kCostTolerance));
  EXPECT_TRUE(RelativelyNear(best_fixed, fixed.at("value"), kCostTolerance));
  double unlimited = 0.0;
  for (const auto& row : w) unlimited -= *std::max_element(row.begin(), row.end());
  EXPECT_TRUE(RelativelyNear(unlimited, problem.at("unlimited"), kCostTolerance));

  for (const auto& [limit, run] : problem.at("rate_limited").items()) {
    SCOPED_TRACE("limit " + limit);
    const Node degrees = run.at("one_optimal_path_deg");
    ASSERT_EQ(degrees.size(), path.q.size());
    double value = 0.0;
    for (int i = 0; i < samples; ++i) {
      const int here = state_of(degrees.at(i));
      value -= w[i][here];
      if (i == 0) continue;
      const int apart = std::abs(here - state_of(degrees.at(i - 1)));
      EXPECT_LE(std::min(apart, kStates - apart), std::stoi(limit)) << "step " << i;
    }
    EXPECT_TRUE(RelativelyNear(value, run.at("value"), kCostTolerance));
    EXPECT_LE(run.at("value").get<double>(), best_fixed * (1 - kCostTolerance));
    EXPECT_GE(run.at("value").get<double>(), unlimited * (1 + kCostTolerance));
  }
}

// Eq. 23 on a straight path of the planar arm: elbow angle by the law of cosines.
void ManipulabilityAndObservability(const Node& problem) {
  const OracleCase cell = PointCell(PlanarArm(10, 10), RigOrientation::kLookAt, 1.0);
  const std::vector<double> y = Linspace(-3, 3, 121);
  const auto joints_for = [](double px, double py) {
    const double r2 = px * px + py * py;
    const double theta2 = std::acos((r2 - 200.0) / 200.0);
    const double theta1 =
        std::atan2(px, py) - std::atan2(10 * std::sin(theta2), 10 + 10 * std::cos(theta2));
    return Joints({theta1, theta2});
  };
  const auto cost = [&](double s, const Sphere& camera,
                        const std::function<double(double, double)>& f) {
    std::vector<double> values;
    for (const double at : y) {
      const Evaluated e = At(cell, joints_for(s, at), camera);
      EXPECT_NEAR(e.kinematics.X_WE.translation().x(), s, 1e-12);
      EXPECT_NEAR(e.kinematics.X_WE.translation().y(), at, 1e-12);
      const PaperProduct paper = ProductOf(e, 2);
      values.push_back(f(paper.view.w, paper.arm.w));
    }
    return -Trapezoid(values, 6.0 / 120);
  };
  for (const auto& [name, run] : problem.at("runs").items()) {
    SCOPED_TRACE(name);
    const double kv = run.at("kv");
    const double kr = run.at("kr");
    const bool product = name == "product";
    const double value =
        cost(run.at("x").at("s"), SphereOf(run.at("x")),
             [&](double w_v, double w_r) { return product ? w_v * w_r : kv * w_v + kr * w_r; });
    EXPECT_TRUE(RelativelyNear(value, run.at("value"), kCostTolerance));
    if (run.contains("de_value")) {
      EXPECT_TRUE(RelativelyNear(run.at("de_value"), run.at("value"), kPolished));
    }
  }
}

// As the camera draws back and zooms, w_c falls to what a telecentric camera sees.
void Scale(const Node& problem) {
  for (const auto& [name, part] : problem.items()) EXPECT_EQ(name, "dolly_zoom") << "not judged";
  const Node zoom = problem.at("dolly_zoom");
  ASSERT_EQ(zoom.at("columns").raw(),
            Json({"R", "f", "w_c_exact", "w_c_translation_only", "w_v_twist"}));
  constexpr double kPose = kPi / 4;
  for (const Node& row : zoom.at("rows").elements()) {
    const double R = row.at(0);
    const double f = row.at(1);
    SCOPED_TRACE(R);
    EXPECT_TRUE(RelativelyNear(f, R / 30, 1e-15));
    const Evaluated e = At(TwoPointCell(SimplePuma(10, 10, 0), {0, 2, 0}, f),
                           Joints({kPose, kPose, kPose}), {R, 0.8, 2.4});
    EXPECT_TRUE(WNear(e.composite, row.at(2)));
    EXPECT_TRUE(RelativelyNear(ProductOf(e, 3).product, row.at(3), kMeasureTolerance));
    EXPECT_TRUE(WNear(e.view, row.at(4)));
  }
}

// Of all rows of one case's J_c the best k: by trying all, by exchange, and what the file names besides.
void FeatureSelection(const Node& problem) {
  // "case D06 (...)": the entry whose rows are the candidates.
  std::smatch match;
  const auto words = problem.at("problem").raw().get<std::string>();
  ASSERT_TRUE(std::regex_search(words, match, std::regex("case (\\w+)"))) << words;
  const std::vector<Entry> cases = Entries("/cases");
  const auto named = std::find_if(cases.begin(), cases.end(),
                                  [&](const Entry& entry) { return entry.id == match[1].str(); });
  ASSERT_NE(named, cases.end()) << "there is no case " << match[1].str();
  const std::vector<TaskJacobian> J{Evaluate(ParseOracleCase(named->node.raw())).J_c};
  const auto near = [&](const std::vector<int>& rows, const Node& w) {
    EXPECT_TRUE(RelativelyNear(SelectionValue(J, rows), w, kMeasureTolerance));
  };
  const auto rows_of = [](const Node& rows) { return rows.get<std::vector<int>>(); };
  for (const auto& [count, result] : problem.at("results").items()) {
    SCOPED_TRACE(count + " rows");
    const int k = std::stoi(count);
    const std::vector<int> best = rows_of(result.at("best"));
    const std::vector<int> second = rows_of(result.at("second"));
    for (const bool all : {true, false}) {
      SelectionOptions options;
      if (!all) options.exhaustive_limit = 0;
      const Selection selection = SelectFeatures(J, k, options);
      ASSERT_EQ(selection.status, SelectionStatus::kOk);
      EXPECT_EQ(selection.exhaustive, all);
      EXPECT_EQ(selection.rows, best);
      EXPECT_TRUE(RelativelyNear(selection.value, result.at("w_c"), kMeasureTolerance));
    }
    near(second, result.at("w_c_second"));
    const Node backward = result.at("backward_elimination");
    near(rows_of(backward.at("rows")), backward.at("w_c"));

    // Every other set is worse than the second, and none is worse than the worst.
    std::vector<char> chosen(J.front().rows(), 0);
    std::fill(chosen.end() - k, chosen.end(), 1);
    Measure worst;
    worst.w = std::numeric_limits<double>::infinity();
    const double w_second = result.at("w_c_second");
    do {
      std::vector<int> rows;
      TaskJacobian block(k, J.front().cols());
      for (int i = 0; i < J.front().rows(); ++i) {
        if (chosen[i] == 0) continue;
        block.row(static_cast<Eigen::Index>(rows.size())) = J.front().row(i);
        rows.push_back(i);
      }
      const Measure measure = MeasureOf(block);
      if (rows != best) {
        EXPECT_LE(measure.w, w_second * (1.0 + kMeasureTolerance));
      }
      if (measure.w < worst.w) worst = measure;
    } while (std::next_permutation(chosen.begin(), chosen.end()));
    // Where the worst set has lost its rank, rounding is all that either value tells.
    const double w_worst = result.at("worst_w_c");
    if (worst.rank < worst.size()) {
      EXPECT_LE(w_worst, kZeroTolerance * std::pow(worst.sigma(0), worst.size()));
    } else {
      EXPECT_TRUE(RelativelyNear(worst.w, w_worst, kMeasureTolerance));
    }
  }
}

const std::map<std::string, std::function<void(const Node&)>>& Judges() {
  static const std::map<std::string, std::function<void(const Node&)>> judges{
      {"O1_planar_fixed_orientation", PlanarFixedOrientation},
      {"O2_planar_fixed_orientation_fov", PlanarFixedOrientationInTheImage},
      {"O3_planar_lookat", PlanarLookAt},
      {"O3b_planar_lookat_fov", PlanarLookAtInTheImage},
      {"O4a_puma_simple_3feat", [](const Node& problem) { PumaInTheImage(problem, false); }},
      {"O4b_puma_simple_4feat", [](const Node& problem) { PumaInTheImage(problem, true); }},
      {"O6_camera_trajectory_dp", CameraTrajectory},
      {"O7_eq23", ManipulabilityAndObservability},
      {"O8_feature_selection", FeatureSelection},
      {"scale", Scale}};
  return judges;
}

// Problems are stated in words. Those this test has words for:
std::vector<Entry> Judged() {
  std::vector<Entry> judged;
  for (const Entry& entry : Entries("/placement")) {
    if (Judges().count(entry.id) == 1) {
      judged.push_back(entry);
    } else {
      std::cout << "[   NOTE   ] placement " << entry.id << " is not judged here\n";
    }
  }
  return judged;
}

class Placement : public ::testing::TestWithParam<Entry> {};

GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(Placement);
INSTANTIATE_TEST_SUITE_P(Oracle, Placement, ::testing::ValuesIn(Judged()), NameOf);

TEST_P(Placement, ValuesAtTheStatedCameras) {
  Judges().at(GetParam().id)(GetParam().node);
}

}  // namespace
}  // namespace vantage::test
