// Placement problems of the oracle file, solved: the planner must reach the optima they state.
#include <cmath>
#include <functional>
#include <map>

#include "paper_cells.h"
#include "vantage/plan/camera_path.h"
#include "vantage/plan/placement.h"

namespace vantage::test {
namespace {

// "placement": a polished optimiser is within 1e-7 relative; x within 1e-4 where unique.
constexpr double kValueTolerance = 1e-7;
constexpr double kPlaceTolerance = 1e-4;

ViewModel ViewOfCell(const OracleCase& cell) {
  std::vector<Marker> markers;
  for (const OraclePoint& point : cell.points) {
    Marker marker;
    marker.id = static_cast<int>(markers.size());
    marker.p = point.p;
    markers.push_back(marker);
  }
  return {cell.arm, cell.camera.model, cell.features, markers};
}

std::vector<BatchRow> RowsOfCell(const OracleCase& cell) {
  std::vector<BatchRow> rows;
  for (const Feature& feature : cell.features.features()) {
    rows.push_back({feature.points[0], feature.kind == FeatureKind::kPointX ? 0 : 1});
  }
  return rows;
}

// Samples of a path of joints with the weights of the trapezoid rule, or of Simpson's.
ArmMotion MotionAlong(const OracleCase& cell, const std::vector<JointVector>& path, double step,
                      bool simpson = false) {
  const ViewModel view = ViewOfCell(cell);
  ArmMotion motion;
  for (std::size_t i = 0; i < path.size(); ++i) {
    const bool end = i == 0 || i + 1 == path.size();
    motion.samples.push_back(SampleArm(view, path[i]));
    motion.time.push_back(step * static_cast<double>(i));
    motion.weight.push_back(simpson ? step / 3.0 *
                                          (end          ? 1.0
                                           : i % 2 == 1 ? 4.0
                                                        : 2.0)
                                    : step * (end ? 0.5 : 1.0));
  }
  return motion;
}

struct Bounds {
  double lower, upper;
};

PlacementProblem ProblemOf(const OracleCase& cell, ArmMotion motion, RigOrientation orientation,
                           Bounds R, Bounds theta) {
  PlacementProblem problem;
  problem.rig.kind = RigKind::kSpherical;
  problem.rig.orientation = orientation;
  problem.rig.axes = {{"R", R.lower, R.upper, 1.0, 1.0},
                      {"theta", theta.lower, theta.upper, 1.0, 1.0},
                      {"phi", -kPi, kPi, 1.0, 1.0},
                      {"roll", 0.0, 0.0, 0.0, 0.0}};
  problem.q_c_start.resize(4);
  problem.q_c_start << R.lower, theta.lower, 0.0, 0.0;
  problem.lens.fx = problem.lens.fy = cell.camera.model.fx;
  problem.motion = std::move(motion);
  problem.rows = RowsOfCell(cell);
  problem.limits.occlusion = false;
  return problem;
}

void SeeWithin(double tan_half, double least_depth, PlacementProblem* problem) {
  problem->lens.x_min = problem->lens.y_min = -tan_half;
  problem->lens.x_max = problem->lens.y_max = tan_half;
  problem->limits.depth.min = least_depth;
}

PlanObjective ViewInPlane(PlanAggregate aggregate) {
  PlanObjective objective;
  objective.quantity = PlanQuantity::kView;
  objective.task = ViewTask::kPlane;
  objective.aggregate = aggregate;
  return objective;
}

PlacementResult Solve(PlacementProblem problem, const PlanObjective& objective) {
  problem.objective = objective;
  const PlacementModel model(std::move(problem));
  PlacementResult result = PlaceCamera(model);
  EXPECT_TRUE(result.best.feasible);
  return result;
}

void ExpectReached(const PlacementResult& result, double cost) {
  EXPECT_LE(-result.best.value, cost + kValueTolerance * std::abs(cost));
  // Nor may it be better than what was found twice by other routes.
  EXPECT_GE(-result.best.value, cost - 1e-6 * std::abs(cost));
}

void ExpectAt(const PlacementResult& result, const Json& x) {
  const RigVector& q_c = result.best.q_c;
  const double phi = std::remainder(q_c(2) - x.at("phi").get<double>(), 2.0 * kPi);
  EXPECT_NEAR(q_c(0), x.at("R").get<double>(), kPlaceTolerance);
  EXPECT_NEAR(q_c(1), x.at("theta").get<double>(), kPlaceTolerance);
  EXPECT_NEAR(phi, 0.0, kPlaceTolerance);
}

std::vector<JointVector> PlanarJoints(double end, int samples) {
  std::vector<JointVector> path;
  for (const double theta2 : Linspace(0.0, end, samples)) path.push_back(Joints({0.0, theta2}));
  return path;
}

void PlanarFixedOrientation(const Json& problem) {
  const OracleCase cell = PointCell(PlanarArm(10, 10), RigOrientation::kFixedDown, 1.0);
  const PlacementProblem p =
      ProblemOf(cell, MotionAlong(cell, PlanarJoints(kPi, 1001), kPi / 1000, true),
                RigOrientation::kFixedDown, {30, 40}, {0, kPi / 3});
  const auto expect_x = [&](const PlacementResult& result) {
    EXPECT_NEAR(result.best.q_c(0), problem.at("optimum").at("R").get<double>(), kPlaceTolerance);
    EXPECT_NEAR(result.best.q_c(1), problem.at("optimum").at("theta").get<double>(),
                kPlaceTolerance);
  };
  const PlacementResult view = Solve(p, ViewInPlane(PlanAggregate::kIntegral));
  ExpectReached(view, problem.at("cost13_wv"));
  expect_x(view);
  const PlacementResult composite = Solve(p, PlanObjective());
  ExpectReached(composite, problem.at("cost13_wc"));
  expect_x(composite);
  const PlacementResult worst = Solve(p, ViewInPlane(PlanAggregate::kWorst));
  ExpectReached(worst, problem.at("minimax16_wv"));
  expect_x(worst);
  PlanObjective minimax;
  minimax.aggregate = PlanAggregate::kWorst;
  const PlacementResult none = Solve(p, minimax);
  EXPECT_NEAR(none.best.value, problem.at("minimax16_wc").get<double>(), 1e-12);
  EXPECT_EQ(none.warning.kind, WorstCaseWarning::Kind::kArmSingular);
  EXPECT_EQ(none.warning.sample, 0);
}

void PlanarFixedOrientationInTheImage(const Json& problem) {
  const OracleCase cell = PointCell(PlanarArm(10, 10), RigOrientation::kFixedDown, 1.0);
  PlacementProblem p = ProblemOf(cell, MotionAlong(cell, PlanarJoints(kPi, 181), kPi / 180),
                                 RigOrientation::kFixedDown, {30, 60}, {0, kPi / 3});
  SeeWithin(0.3, 1.0, &p);
  ExpectReached(Solve(p, ViewInPlane(PlanAggregate::kIntegral)), problem.at("cost13_wv"));
  ExpectReached(Solve(p, ViewInPlane(PlanAggregate::kWorst)), problem.at("minimax16_wv"));
  // The file integrates w_c exactly.
  p.motion = MotionAlong(cell, PlanarJoints(kPi, 181), kPi / 180, true);
  ExpectReached(Solve(p, PlanObjective()), problem.at("cost13_wc"));
}

void PlanarLookAt(const Json& problem, bool in_the_image) {
  const OracleCase cell = PointCell(PlanarArm(10, 10), RigOrientation::kLookAt, 1.0);
  PlacementProblem p =
      ProblemOf(cell, MotionAlong(cell, PlanarJoints(kPi, 181), kPi / 180), RigOrientation::kLookAt,
                in_the_image ? Bounds{12, 80} : Bounds{30, 40},
                in_the_image ? Bounds{0, 1.4} : Bounds{0, kPi / 3});
  if (in_the_image) SeeWithin(0.4, 15.0, &p);
  const PlacementResult view = Solve(p, ViewInPlane(PlanAggregate::kIntegral));
  ExpectReached(view, problem.at("cost13_wv").at("value"));
  ExpectAt(view, problem.at("cost13_wv").at("x"));
  const PlacementResult composite = Solve(p, PlanObjective());
  ExpectReached(composite, problem.at("cost13_wc").at("value"));
  ExpectAt(composite, problem.at("cost13_wc").at("x"));
  const PlacementResult worst = Solve(p, ViewInPlane(PlanAggregate::kWorst));
  ExpectReached(worst, problem.at("minimax16_wv").at("value"));
}

void PumaInTheImage(const Json& problem, bool all_four) {
  const OracleCase cell = TwoPointCell(SimplePuma(10, 10, 0), {0, 2, 0}, 1.0, all_four);
  std::vector<JointVector> path;
  for (const double t : Linspace(0.0, kPi, 181)) path.push_back(Joints({t, t, t}));
  PlacementProblem p = ProblemOf(cell, MotionAlong(cell, path, kPi / 180), RigOrientation::kLookAt,
                                 {15, 80}, {0, 1.4});
  SeeWithin(0.5, 10.0, &p);
  const PlacementResult composite = Solve(p, PlanObjective());
  ExpectReached(composite, problem.at("cost13_wc").at("value"));
  ExpectAt(composite, problem.at("cost13_wc").at("x"));
  PlanObjective minimax;
  minimax.aggregate = PlanAggregate::kWorst;
  const PlacementResult none = Solve(p, minimax);
  EXPECT_NEAR(none.best.value, problem.at("minimax16_wc").at("value").get<double>(), 1e-12);
  EXPECT_EQ(none.warning.kind, WorstCaseWarning::Kind::kArmSingular);
}

// Eq. 15 over the file's lattice: what dynamic programming finds is the optimum itself.
void CameraTrajectory(const Json& problem) {
  constexpr int kStates = 72;
  const OracleCase cell = PointCell(PlanarArm(10, 10), RigOrientation::kLookAt, 1.0);
  PlacementProblem p = ProblemOf(cell, MotionAlong(cell, PlanarJoints(2 * kPi, 73), 2 * kPi / 72),
                                 RigOrientation::kLookAt, {30, 30}, {0.8, 0.8});
  p.objective = ViewInPlane(PlanAggregate::kIntegral);
  const PlacementModel model(std::move(p));
  const ArmMotion& motion = model.problem().motion;
  Eigen::MatrixXd value(motion.size(), kStates);
  BatchCameras cameras;
  cameras.Resize(kStates);
  for (int s = 0; s < kStates; ++s) {
    RigVector q_c(4);
    q_c << 30.0, 0.8, (-180.0 + 5.0 * s) * kPi / 180.0, 0.0;
    cameras.Set(s, RigPose(model.problem().rig, q_c));
  }
  BatchScores scores;
  for (int i = 0; i < motion.size(); ++i) {
    BatchEvaluator().Score(model.sample_views()[i].scene, cameras, 0, kStates, model.problem().lens,
                           BatchMeasure::kW, BatchPrecision::kDouble, false, &scores);
    for (int s = 0; s < kStates; ++s) value(i, s) = motion.weight[i] * scores.sum[s];
  }
  for (const auto& [limit, run] : problem.at("rate_limited").items()) {
    SCOPED_TRACE("limit " + limit);
    std::vector<std::vector<int>> predecessor(kStates);
    for (int s = 0; s < kStates; ++s) {
      for (int by = -std::stoi(limit); by <= std::stoi(limit); ++by) {
        predecessor[s].push_back((s + by + kStates) % kStates);
      }
    }
    double sum = 0.0;
    const std::vector<int> sequence = BestSequence(value, predecessor);
    ASSERT_EQ(static_cast<int>(sequence.size()), motion.size());
    for (int i = 0; i < motion.size(); ++i) sum += value(i, sequence[i]);
    EXPECT_TRUE(RelativelyNear(-sum, run.at("value"), 1e-9));
  }
  // The best camera that stands still: phi is the one free axis.
  const PlacementResult fixed = PlaceCamera(model);
  EXPECT_LE(-fixed.best.value, problem.at("fixed").at("value").get<double>() * (1 - 1e-9));
}

const std::map<std::string, std::function<void(const Json&)>>& Solvers() {
  static const std::map<std::string, std::function<void(const Json&)>> solvers{
      {"O1_planar_fixed_orientation", PlanarFixedOrientation},
      {"O2_planar_fixed_orientation_fov", PlanarFixedOrientationInTheImage},
      {"O3_planar_lookat", [](const Json& problem) { PlanarLookAt(problem, false); }},
      {"O3b_planar_lookat_fov", [](const Json& problem) { PlanarLookAt(problem, true); }},
      {"O4a_puma_simple_3feat", [](const Json& problem) { PumaInTheImage(problem, false); }},
      {"O4b_puma_simple_4feat", [](const Json& problem) { PumaInTheImage(problem, true); }},
      {"O6_camera_trajectory_dp", CameraTrajectory}};
  return solvers;
}

std::vector<Entry> Solved() {
  std::vector<Entry> solved;
  for (const Entry& entry : Entries("/placement")) {
    if (Solvers().count(entry.id) == 1) solved.push_back(entry);
  }
  return solved;
}

class Optimum : public ::testing::TestWithParam<Entry> {};

GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(Optimum);
INSTANTIATE_TEST_SUITE_P(Oracle, Optimum, ::testing::ValuesIn(Solved()), NameOf);

TEST_P(Optimum, IsReached) {
  Solvers().at(GetParam().id)(GetParam().node.raw());
}

}  // namespace
}  // namespace vantage::test
