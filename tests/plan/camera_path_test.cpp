#include "vantage/plan/camera_path.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "cell.h"
#include "config_error.h"

namespace vantage::test {
namespace {

PlacementSearch Quick() {
  PlacementSearch search;
  search.grid = 1024;
  search.starts = 8;
  return search;
}

// A wide motion in 8 s; the camera's axes are slow enough to bind.
PlacementProblem Wide(double speed) {
  PlacementProblem problem = PumaProblem(6, 48);
  const ViewModel view = PumaView(6);
  JointVector from(6), to(6);
  from << -0.5, 0.3, -0.4, 0.2, 0.4, 0.0;
  to << 1.6, 0.8, 0.3, 0.5, 1.2, 0.4;
  problem.motion = MoveThroughJoints(view, {from, to}, 8.0, 48);
  for (RigAxis& axis : problem.rig.axes) axis.max_speed = speed;
  problem.rig.max_linear_speed = 0.1 + 1.5 * speed;
  return problem;
}

CameraPathSearch Small() {
  CameraPathSearch search;
  search.states = 400;
  search.rounds = 16;
  return search;
}

TEST(BestSequence, IsTheBestOfAll) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  constexpr int kSteps = 5, kStates = 4;
  Eigen::MatrixXd value(kSteps, kStates);
  for (int i = 0; i < kSteps; ++i) {
    for (int s = 0; s < kStates; ++s) value(i, s) = uniform(random);
  }
  std::vector<std::vector<int>> predecessor(kStates);
  for (int s = 0; s < kStates; ++s) {
    for (int p = std::max(0, s - 1); p <= std::min(kStates - 1, s + 1); ++p) {
      predecessor[s].push_back(p);
    }
  }
  double best = -INFINITY;
  for (int code = 0; code < 1024; ++code) {
    double sum = 0.0;
    int last = -1;
    bool allowed = true;
    for (int i = 0, c = code; i < kSteps; ++i, c /= kStates) {
      const int s = c % kStates;
      allowed = allowed && (last < 0 || std::abs(s - last) <= 1);
      sum += value(i, s);
      last = s;
    }
    if (allowed) best = std::max(best, sum);
  }
  const std::vector<int> sequence = BestSequence(value, predecessor);
  ASSERT_EQ(sequence.size(), 5u);
  double sum = 0.0;
  for (int i = 0; i < kSteps; ++i) sum += value(i, sequence[i]);
  EXPECT_NEAR(sum, best, 1e-12);
  value.setConstant(-INFINITY);
  EXPECT_TRUE(BestSequence(value, predecessor).empty());
}

TEST(CameraPath, KeepsSpeedsAndLimitsAndBeatsStandingStill) {
  const PlacementModel model(Wide(0.25));
  const PlacementResult fixed = PlaceCamera(model, Quick());
  ASSERT_TRUE(fixed.best.feasible);
  const CameraPathResult result = PlanCameraPath(model, fixed.best, Small());
  EXPECT_NEAR(result.fixed.value, fixed.best.value, 1e-9 * fixed.best.value);
  EXPECT_EQ(result.path.broken, 0);
  EXPECT_TRUE(KeepsSpeeds(model, result.path));
  EXPECT_GT(result.path.value, 1.05 * result.fixed.value);
  // Each sample by the controller's own code.
  ViewLimits limits;
  limits.margin = 20.0 - 1e-6;
  limits.min_semi_axis = 0.0;  // of no concern to a placement
  limits.max_incidence = model.problem().limits.max_incidence + 1e-8;
  for (int i = 0; i < model.problem().motion.size(); ++i) {
    const Eigen::Isometry3d X_WC = RigPose(model.problem().rig, result.path.q_c[i]);
    const ArmSample& sample = model.problem().motion.samples[i];
    for (const PlacedMarker& marker : sample.markers) {
      EXPECT_STREQ(Name(CheckMarker(CameraModel(), limits, X_WC, marker, sample.capsules)), "NONE")
          << i;
    }
  }
}

TEST(CameraPath, IsWorthMoreTheFasterTheCamera) {
  double last = 0.0;
  for (const double speed : {0.0, 0.1, 0.4}) {
    const PlacementModel model(Wide(speed));
    PlacementProblem problem = Wide(speed);
    const PlacementResult fixed = PlaceCamera(model, Quick());
    // Locked axes stay where the camera is.
    problem.q_c_start = fixed.best.q_c;
    const PlacementModel placed(problem);
    const CameraPathResult result = PlanCameraPath(placed, fixed.best, Small());
    EXPECT_GE(result.path.value, last * (1.0 - 1e-9)) << speed;
    if (speed == 0.0) {
      EXPECT_EQ(result.path.value, result.fixed.value);
      EXPECT_GT(result.evaluations, 0);
    }
    last = result.path.value;
  }
}

// So slow in depth that no state of a lattice can be followed by any: the path from the fixed camera is left.
TEST(CameraPath, IsFoundWhereNoLatticeHasOne) {
  PlacementProblem problem = Wide(0.25);
  problem.rig.axes[0].max_speed = 1e-9;
  problem.rig.axes[0].upper = 100.0;
  const PlacementModel model(problem);
  const PlacementResult fixed = PlaceCamera(model, Quick());
  ASSERT_TRUE(fixed.best.feasible);
  const CameraPathResult result = PlanCameraPath(model, fixed.best, Small());
  EXPECT_EQ(result.path.broken, 0);
  EXPECT_TRUE(KeepsSpeeds(model, result.path));
  EXPECT_GE(result.path.value, result.fixed.value);
}

TEST(CameraPath, AWindowGainsAndLeavesTheRest) {
  const PlacementModel model(Wide(0.25));
  const PlacementResult fixed = PlaceCamera(model, Quick());
  CameraPath path =
      JudgePath(model, std::vector<RigVector>(model.problem().motion.size(), fixed.best.q_c));
  const CameraPath before = path;
  const double gained = RefineWindow(model, 8, 16, 8, true, &path);
  EXPECT_GT(gained, 0.0);
  for (int i = 0; i < model.problem().motion.size(); ++i) {
    if (i <= 8 || i >= 24) {
      EXPECT_EQ(path.q_c[i], before.q_c[i]) << i;
    }
  }
  EXPECT_TRUE(KeepsSpeeds(model, path));
  const double value = JudgePath(model, path.q_c).value;
  EXPECT_GT(value, before.value);
  // What is said to be gained is, of an objective that is the sum itself.
  EXPECT_NEAR(gained, value - before.value, 1e-9 * value);
}

TEST(CameraPath, IsNotOfTheWorstCase) {
  PlacementProblem problem = PumaProblem(6, 16);
  problem.objective.aggregate = PlanAggregate::kWorst;
  const PlacementModel model(problem);
  const PlacedCamera camera = JudgeCamera(model, problem.q_c_start);
  EXPECT_EQ(ConfigErrorOf([&] { (void)PlanCameraPath(model, camera); }).find("objective.over"), 0u);
}

}  // namespace
}  // namespace vantage::test
