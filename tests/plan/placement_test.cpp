#include "vantage/plan/placement.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "cell.h"
#include "config_error.h"
#include "vantage/math/angles.h"
#include "vantage/plan/grid_check.h"

namespace vantage::test {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

// Effort that suffices for these cells, in a fraction of a second.
PlacementSearch Quick() {
  PlacementSearch search;
  search.grid = 1024;
  search.starts = 8;
  return search;
}

// The objective from the definition: SVD of each sample's Jacobian, one at a time.
double Definition(const PlacementModel& model, const Isometry3d& X_WC) {
  const PlacementProblem& problem = model.problem();
  double sum = 0.0, least = INFINITY;
  for (int i = 0; i < problem.motion.size(); ++i) {
    const Measure m = MeasureOf(PlainJacobian(model.scene(), i, X_WC, 1.0, problem.lens));
    double value = 0.0;
    switch (problem.objective.measure) {
      case BatchMeasure::kW:
        value = m.w;
        break;
      case BatchMeasure::kLogW:
        value = m.log_w;
        break;
      case BatchMeasure::kSigmaMin:
        value = m.sigma_min;
        break;
      case BatchMeasure::kInverseCondition:
        value = m.inverse_condition();
        break;
      case BatchMeasure::kNegativeTrace:
        value = -m.inverse_trace();
        break;
    }
    sum += problem.motion.weight[i] * value;
    least = std::min(least, value);
  }
  return problem.objective.aggregate == PlanAggregate::kWorst ? least : sum;
}

// Every limit by the code that the controller itself uses.
void ExpectSeenThroughout(const PlacementProblem& problem, const CameraModel& camera,
                          const Isometry3d& X_WC) {
  ViewLimits limits;
  limits.margin = 20.0 - 1e-6;
  limits.min_semi_axis = 0.0;  // of no concern to a placement
  limits.min_depth = problem.limits.depth.min - 1e-8;
  limits.max_depth = problem.limits.depth.max;
  limits.max_incidence = problem.limits.max_incidence + 1e-8;
  for (const ArmSample& sample : problem.motion.samples) {
    for (const PlacedMarker& marker : sample.markers) {
      ASSERT_STREQ(Name(CheckMarker(camera, limits, X_WC, marker, sample.capsules)), "NONE");
    }
  }
}

class Placement : public ::testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Joints, Placement, ::testing::Values(3, 6));

TEST_P(Placement, KeepsEveryLimitAndBeatsEveryOtherCamera) {
  const PlacementModel model(PumaProblem(GetParam()));
  const PlacementResult result = PlaceCamera(model, Quick());
  ASSERT_TRUE(result.best.feasible);
  ExpectSeenThroughout(model.problem(), CameraModel(), result.best.X_WC);
  EXPECT_NEAR(result.best.value, Definition(model, result.best.X_WC), 1e-9 * result.best.value);
  const GridCheck check = CheckAgainstGrid(model, result.best, 20000);
  EXPECT_LT(check.gap, 1e-6);
  EXPECT_LE(check.best_on_grid, check.best.value);
  EXPECT_FALSE(result.active.empty());
  EXPECT_TRUE(result.worst.feasible);
  EXPECT_LT(result.worst.value, result.best.value);
}

TEST_P(Placement, IsTheSameAgainAndForAnotherSeedAsGood) {
  const PlacementModel model(PumaProblem(GetParam()));
  PlacementSearch search = Quick();
  const PlacementResult first = PlaceCamera(model, search);
  EXPECT_EQ(PlaceCamera(model, search).best.q_c, first.best.q_c);
  search.seed = 7;
  EXPECT_NEAR(PlaceCamera(model, search).best.value, first.best.value, 1e-6 * first.best.value);
}

class Measures : public ::testing::TestWithParam<BatchMeasure> {};
INSTANTIATE_TEST_SUITE_P(All, Measures,
                         ::testing::Values(BatchMeasure::kLogW, BatchMeasure::kSigmaMin,
                                           BatchMeasure::kInverseCondition,
                                           BatchMeasure::kNegativeTrace));

TEST_P(Measures, AreMadeGreatAsDefined) {
  for (const PlanAggregate aggregate : {PlanAggregate::kIntegral, PlanAggregate::kWorst}) {
    PlacementProblem problem = PumaProblem(6, 16);
    problem.objective.measure = GetParam();
    problem.objective.aggregate = aggregate;
    const PlacementModel model(std::move(problem));
    const PlacementResult result = PlaceCamera(model, Quick());
    ASSERT_TRUE(result.best.feasible);
    const double value = Definition(model, result.best.X_WC);
    EXPECT_NEAR(result.best.value, value, 1e-8 * std::abs(value));
    EXPECT_LT(CheckAgainstGrid(model, result.best, 6000).gap, 1e-5);
  }
}

TEST(PlacementObjective, OfViewAndArmIsTheirSum) {
  PlacementProblem problem = PumaProblem(6, 16);
  problem.objective.quantity = PlanQuantity::kWeightedSum;
  problem.objective.k_v = 1e-9;
  problem.objective.k_r = 50.0;
  const PlacementModel both(problem);
  problem.objective.quantity = PlanQuantity::kView;
  const PlacementModel view(problem);
  double arm = 0.0;
  for (int i = 0; i < problem.motion.size(); ++i) {
    const ArmJacobian J_r = problem.motion.samples[i].kinematics.J_WE_W;
    arm += problem.motion.weight[i] * MeasureOf(J_r).w;
  }
  const RigVector q_c = problem.q_c_start;
  EXPECT_NEAR(JudgeCamera(both, q_c).value, 1e-9 * JudgeCamera(view, q_c).value + 50.0 * arm,
              1e-9 * 50.0 * arm);
}

TEST(PlacementObjective, ProductIsTheCompositeWhereItMustBe) {
  // k = 8, m = 6, n = 6: w_c = w_v w_r.
  PlacementProblem problem = PumaProblem(6, 16);
  const PlacementModel composite(problem);
  problem.objective.quantity = PlanQuantity::kProduct;
  const PlacementModel product(problem);
  const double value = JudgeCamera(composite, problem.q_c_start).value;
  EXPECT_NEAR(JudgeCamera(product, problem.q_c_start).value, value, 1e-9 * value);
  problem.objective.measure = BatchMeasure::kLogW;
  const PlacementModel log_product(problem);
  problem.objective.quantity = PlanQuantity::kComposite;
  const PlacementModel log_composite(problem);
  EXPECT_NEAR(JudgeCamera(log_product, problem.q_c_start).value,
              JudgeCamera(log_composite, problem.q_c_start).value, 1e-8);
}

TEST(PlacementObjective, OfTheWorstCaseIsNotOfASum) {
  PlacementProblem problem = PumaProblem(6, 16);
  problem.objective.quantity = PlanQuantity::kWeightedSum;
  problem.objective.aggregate = PlanAggregate::kWorst;
  EXPECT_EQ(ConfigErrorOf([&] { PlacementModel model(problem); }).find("objective.over"), 0);
}

TEST(PlacementModel, RefusesAMotionWithoutMarkers) {
  PlacementProblem problem = PumaProblem(6, 16);
  for (ArmSample& sample : problem.motion.samples) sample.markers.clear();
  EXPECT_EQ(ConfigErrorOf([&] { PlacementModel model(problem); }).find("markers: needs"), 0);
}

TEST(PlacementModel, RefusesDepthsInTheWrongOrderWithBoth) {
  PlacementProblem problem = PumaProblem(6, 16);
  problem.limits.depth = {2.0, 1.0};
  const std::string error = ConfigErrorOf([&] { PlacementModel model(problem); });
  EXPECT_EQ(error.find("limits.max_depth"), 0);
  EXPECT_NE(error.find("1.000000 m and 2.000000 m"), std::string::npos) << error;
}

TEST(PlacementModel, HasObstaclesOfEverySampleOrNone) {
  PlacementProblem problem = PumaProblem(3, 16);
  EXPECT_EQ(PlacementModel(problem).sample_obstacles().size(), 16U);
  problem.limits.occlusion = false;
  EXPECT_EQ(PlacementModel(problem).sample_obstacles().size(), 16U);  // its markers have a face
  problem.limits.max_incidence = kPi;
  EXPECT_TRUE(PlacementModel(problem).sample_obstacles().empty());
}

TEST(PlacementWorstCase, OfAsManyRowsAsJointsIsSpurious) {
  PlacementProblem problem = PumaProblem(3);
  problem.objective.aggregate = PlanAggregate::kWorst;
  const PlacementModel model(problem);
  // From where det J_c has both signs along the motion the warning names the crossing.
  const PlacementResult result = PlaceCamera(model, Quick());
  int crossing = -1;
  double last = 0.0;
  for (int i = 0; i < problem.motion.size() && crossing < 0; ++i) {
    const double det =
        PlainJacobian(model.scene(), i, result.best.X_WC, 1.0, problem.lens).determinant();
    if (det * last < 0.0) crossing = i;
    last = det;
  }
  EXPECT_EQ(result.warning.sample, crossing);
  EXPECT_EQ(result.warning.kind == WorstCaseWarning::Kind::kChangesSign, crossing >= 0);
}

TEST(PlacementWorstCase, WarnsOfASignThatChangesForEveryCamera) {
  // The elbow goes through its stretched pose, where det J_r and so det J_c change sign.
  const ViewModel view = PumaView(3);
  PlacementProblem problem = PumaProblem(3);
  JointVector from(3), to(3);
  const double stretched = std::atan2(0.4318, 0.0203) - kPi;
  from << 0.1, 0.6, stretched - 0.4;
  to << 0.1, 0.6, stretched + 0.5;
  problem.motion = MoveThroughJoints(view, {from, to}, 1.0, 24);
  problem.objective.aggregate = PlanAggregate::kWorst;
  problem.limits.max_incidence = kPi;
  problem.limits.occlusion = false;
  const PlacementResult result = PlaceCamera(PlacementModel(problem), Quick());
  ASSERT_TRUE(result.best.feasible);
  EXPECT_EQ(result.warning.kind, WorstCaseWarning::Kind::kChangesSign);
}

TEST(PlacementLimits, BoxesHideAndKeepOut) {
  PlacementProblem problem = PumaProblem(6);
  const PlacementResult open = PlaceCamera(PlacementModel(problem), Quick());
  // A box round the best camera: it must go elsewhere, and keep its distance.
  BatchBox box;
  box.X_WB.translation() = open.best.X_WC.translation();
  box.half = {0.1, 0.15, 0.2};
  problem.limits.keep_out = {box};
  problem.limits.clearance = 0.05;
  const PlacementResult kept_out = PlaceCamera(PlacementModel(problem), Quick());
  ASSERT_TRUE(kept_out.best.feasible);
  EXPECT_GE(DistanceToBox(box, kept_out.best.X_WC.translation()), 0.05 - 1e-8);
  EXPECT_LT(kept_out.best.value, open.best.value);
  // A plate half-way between the work and that camera hides the work from it.
  problem.limits.keep_out.clear();
  BatchBox plate;
  plate.X_WB = open.best.X_WC;
  plate.X_WB.translation() += 0.3 * open.best.X_WC.linear().col(2);
  plate.half = {0.03, 0.03, 0.005};
  problem.limits.boxes = {plate};
  const PlacementModel hidden(problem);
  EXPECT_FALSE(JudgeCamera(hidden, open.best.q_c).feasible);
  EXPECT_TRUE(PlaceCamera(hidden, Quick()).best.feasible);
}

TEST(PlacementLimits, FocusBindsWhereItIsTighterAndIsNamed) {
  PlacementProblem problem = PumaProblem(6);
  problem.limits.focus = DepthLimits{1.6, 3.0};
  const PlacementResult result = PlaceCamera(PlacementModel(problem), Quick());
  ASSERT_TRUE(result.best.feasible);
  const auto named = [](const ActiveLimit& limit) { return limit.name == "focus, near end"; };
  EXPECT_TRUE(std::any_of(result.active.begin(), result.active.end(), named));
}

TEST(PlacementLimits, SceneMarkersMustBeSeenToo) {
  PlacementProblem problem = PumaProblem(6);
  problem.scene_markers = {{Vector3d(0.9, -0.2, 0.4), Vector3d::UnitZ(), 0.01}};
  const PlacementResult result = PlaceCamera(PlacementModel(problem), Quick());
  ASSERT_TRUE(result.best.feasible);
  ViewLimits limits;
  limits.margin = 20.0 - 1e-6;
  limits.min_semi_axis = 0.0;  // of no concern to a placement
  limits.max_incidence = problem.limits.max_incidence + 1e-8;
  for (const ArmSample& sample : problem.motion.samples) {
    EXPECT_STREQ(Name(CheckMarker(CameraModel(), limits, result.best.X_WC, problem.scene_markers[0],
                                  sample.capsules)),
                 "NONE");
  }
}

TEST(PlacementLimits, TheRimOfAMarkerIsInTheImage) {
  PlacementProblem problem = PumaProblem(6);
  problem.limits.rim = 0.05;
  const PlacementResult result = PlaceCamera(PlacementModel(problem), Quick());
  ASSERT_TRUE(result.best.feasible);
  const BatchLens& lens = problem.lens;
  double least = INFINITY;
  for (const ArmSample& sample : problem.motion.samples) {
    for (const PlacedMarker& marker : sample.markers) {
      const Vector3d p = result.best.X_WC.inverse() * marker.p_W;
      for (const Vector3d& a : {Vector3d(1, 0, -lens.x_min), Vector3d(-1, 0, lens.x_max),
                                Vector3d(0, 1, -lens.y_min), Vector3d(0, -1, lens.y_max)}) {
        least = std::min(least, a.normalized().dot(p));
      }
    }
  }
  EXPECT_GE(least, 0.05 - 1e-9);
}

TEST(PlacementDiagnosis, NamesTheLimitThatNoCameraKeeps) {
  PlacementProblem problem = PumaProblem(6);
  // The sphere ends before the least depth begins.
  problem.rig.axes[0].upper = 1.0;
  problem.q_c_start(0) = 1.0;
  problem.limits.depth = {2.0, 5.0};
  const PlacementResult result = PlaceCamera(PlacementModel(problem), Quick());
  ASSERT_FALSE(result.best.feasible);
  ASSERT_FALSE(result.diagnosis.empty());
  EXPECT_EQ(result.diagnosis[0].name, "least depth");
  // No marker can be deeper than the sphere's radius and its own distance from the centre.
  double deepest = INFINITY;
  for (const ArmSample& sample : problem.motion.samples) {
    for (const PlacedMarker& marker : sample.markers) {
      deepest = std::min(deepest, 1.0 + (marker.p_W - problem.rig.target_W).norm());
    }
  }
  EXPECT_LE(result.diagnosis[0].best_margin, deepest - 2.0);
  EXPECT_GT(result.diagnosis[0].best_margin, -2.0);
}

TEST(PlacementDiagnosis, NamesTheLimitWithoutWhichThereAreCameras) {
  PlacementProblem problem = PumaProblem(6);
  // A lid over the work that only a camera below could look past; the rig has none.
  BatchBox lid;
  lid.X_WB.translation() = Vector3d(0.3, 0.2, 2.2);
  lid.half = {3.0, 3.0, 0.45};
  problem.limits.keep_out = {lid};
  problem.rig.axes[1] = {"theta", 0.1, 0.3, 1.0, 1.0};
  problem.rig.axes[0].lower = 1.2;
  problem.rig.axes[0].upper = 1.4;
  problem.q_c_start << 1.3, 0.2, 0.0, 0.0;
  const PlacementResult result = PlaceCamera(PlacementModel(problem), Quick());
  ASSERT_FALSE(result.best.feasible);
  const auto lid_is_named = [](const LimitDiagnosis& d) {
    return d.name == "keep-out box" && d.margin_at_nearest < 0.0;
  };
  EXPECT_TRUE(std::any_of(result.diagnosis.begin(), result.diagnosis.end(), lid_is_named));
}

TEST(PlacementUncertainty, CountsThePerturbedPoses) {
  PlacementProblem problem = PumaProblem(6, 16);
  const PlacementModel sharp(problem);
  problem.uncertainty.position = 0.02;
  problem.uncertainty.rotation = 0.01;
  const PlacementModel mean(problem);
  problem.uncertainty.worst = true;
  const PlacementModel worst(problem);
  const RigVector q_c = problem.q_c_start;
  double least = INFINITY;
  for (const Isometry3d& offset : worst.offsets()) {
    least = std::min(least, Definition(sharp, RigPose(problem.rig, q_c) * offset));
  }
  const double sharp_value = JudgeCamera(sharp, q_c).value;
  EXPECT_NEAR(JudgeCamera(worst, q_c).value, least, 1e-9 * least);
  EXPECT_LT(least, sharp_value);
  // The cubature against the mean over many seeded draws.
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  constexpr int kDraws = 4000;
  double sum = 0.0;
  for (int i = 0; i < kDraws; ++i) {
    Twist step;
    for (int k = 0; k < 6; ++k) step(k) = (k < 3 ? 0.02 : 0.01) * normal(random);
    sum += Definition(sharp, Advance(RigPose(problem.rig, q_c), step));
  }
  EXPECT_NEAR(JudgeCamera(mean, q_c).value, sum / kDraws, 0.01 * sharp_value);
  // Every perturbed pose keeps the limits.
  const PlacementResult placed = PlaceCamera(worst, Quick());
  ASSERT_TRUE(placed.best.feasible);
  CameraScorer scorer(sharp);
  std::vector<Isometry3d> poses;
  for (const Isometry3d& offset : worst.offsets()) poses.push_back(placed.best.X_WC * offset);
  scorer.Load(poses);
  std::vector<PlanMargins> margins;
  scorer.Frustum(BatchPrecision::kDouble, &margins);
  scorer.Obstacles(BatchPrecision::kDouble, &margins);
  for (const PlanMargins& m : margins) {
    EXPECT_GE(*std::min_element(m.begin(), m.end()), -1e-8);
  }
}

TEST(PlacementRigs, AFreeCameraIsAtLeastAsGoodAsOneOnASphere) {
  PlacementProblem problem = PumaProblem(6, 16);
  problem.limits.occlusion = false;
  const PlacementResult sphere = PlaceCamera(PlacementModel(problem), Quick());
  ASSERT_TRUE(sphere.best.feasible);
  problem.rig = CameraRig();
  problem.rig.kind = RigKind::kFree;
  problem.rig.X_WC_fixed.linear() = sphere.best.X_WC.linear();
  problem.rig.X_WC_fixed.translation() = problem.motion.samples[8].markers[0].p_W;
  for (const char* name : {"x", "y", "z"}) problem.rig.axes.push_back({name, -4.0, 4.0, 1.0, 1.0});
  problem.rig.axes.push_back({"pan", -kPi, kPi, 1.0, 1.0});
  problem.rig.axes.push_back({"tilt", -1.4, 1.4, 1.0, 1.0});
  problem.rig.axes.push_back({"roll", -kPi, kPi, 1.0, 1.0});
  problem.q_c_start = RigVector::Zero(6);
  PlacementSearch search;
  search.generations = 40;
  const PlacementResult free = PlaceCamera(PlacementModel(problem), search);
  ASSERT_TRUE(free.best.feasible);
  EXPECT_GT(free.best.value, (1.0 - 1e-3) * sphere.best.value);
}

TEST(PlacementRigs, OnSixAxesTheClimbIsAsGoodAsTheEvolutionAndTheSameAgain) {
  PlacementProblem problem = PumaProblem(6, 16);
  for (const char* name : {"pan", "tilt"}) problem.rig.axes.push_back({name, -0.4, 0.4, 1.0, 1.0});
  problem.q_c_start.conservativeResize(6);
  problem.q_c_start.tail<2>().setZero();
  const PlacementModel model(problem);
  const PlacementResult climbed = PlaceCamera(model);
  ASSERT_TRUE(climbed.best.feasible);
  EXPECT_EQ(PlaceCamera(model).best.q_c, climbed.best.q_c);
  PlacementSearch evolution;
  evolution.generations = 80;
  evolution.starts = 32;
  EXPECT_GT(climbed.best.value, (1.0 - 1e-3) * PlaceCamera(model, evolution).best.value);
}

TEST(PlacementRigs, AFixedCameraIsJudged) {
  PlacementProblem problem = PumaProblem(6, 16);
  const PlacementResult sphere = PlaceCamera(PlacementModel(problem), Quick());
  problem.rig = CameraRig();
  problem.rig.X_WC_fixed = sphere.best.X_WC;
  problem.q_c_start.resize(0);
  const PlacementResult fixed = PlaceCamera(PlacementModel(problem), Quick());
  EXPECT_TRUE(fixed.best.feasible);
  EXPECT_NEAR(fixed.best.value, sphere.best.value, 1e-12 * sphere.best.value);
}

}  // namespace
}  // namespace vantage::test
