// The scenario suite: generators, strategies, and the quick suite in the fast projection model.

#include "sim/suite/suite.h"

#include <set>

#include <gtest/gtest.h>

#include "sim/goal_motion.h"
#include "sim/suite/run_task.h"
#include "vantage/math/error.h"
#include "vantage/observability/measures.h"

namespace vantage::sim {
namespace {

TEST(Suite, HasEveryScenarioOfTheTable) {
  std::set<std::string> scenarios;
  for (const SuiteEntry& entry : SuiteEntries("all")) scenarios.insert(entry.scenario);
  EXPECT_EQ(scenarios, (std::set<std::string>{"S1", "S2", "S3", "S4", "S5", "S6", "S7", "S8a",
                                              "S8b", "S9", "S10", "S11", "S12"}));
  EXPECT_EQ(SuiteEntries("all").size(), 34u);
  EXPECT_EQ(SuiteEntries("bad-starts").size(), 4u);
  EXPECT_EQ(SuiteEntries("S8").size(), 4u);
  ASSERT_EQ(SuiteEntries("S4/planar2").size(), 1u);
  EXPECT_EQ(Name(SuiteEntries("S4/planar2").front()), "S4/planar2");
  EXPECT_THROW((void)SuiteEntries("S13"), ConfigError);
}

TEST(Suite, TasksAreFunctionsOfTheSeed) {
  const SuiteEntry entry = SuiteEntries("S1/puma560").front();
  const SuiteTask a = MakeSuiteTask(entry, 3);
  const SuiteTask b = MakeSuiteTask(entry, 3);
  const SuiteTask c = MakeSuiteTask(entry, 4);
  EXPECT_EQ(a.q_goal, b.q_goal);
  EXPECT_EQ(a.scenario.q_c_start, b.scenario.q_c_start);
  EXPECT_EQ(a.scenario.sim.seed, b.scenario.sim.seed);
  EXPECT_NE(a.q_goal, c.q_goal);
  EXPECT_NE(a.scenario.sim.seed, c.scenario.sim.seed);
}

class EveryRow : public ::testing::TestWithParam<SuiteEntry> {};

// The start is what the scenario says, seen by the nominal model: markers in view, goal not yet reached.
TEST_P(EveryRow, StartsInViewAwayFromItsGoal) {
  const SuiteTask task = MakeSuiteTask(GetParam(), 1);
  const Scenario& s = task.scenario;
  const Eigen::Isometry3d X_WC = RigPose(s.rig, s.q_c_start);
  const ArmSample start = SampleArm(s.task.view, s.sim.q_start);
  for (const PlacedMarker& marker : start.markers) {
    EXPECT_EQ(
        CheckMarker(s.task.view.camera, s.active.planner.limits, X_WC, marker, start.capsules),
        ViewFault::kNone);
  }
  EXPECT_TRUE(WithinLimits(s.task.view.arm, s.sim.q_start));
  EXPECT_TRUE(WithinLimits(s.task.view.arm, task.q_goal));
  EXPECT_GT((task.q_goal - s.sim.q_start).lpNorm<Eigen::Infinity>(), 0.1);
  // The goal's points are where the arm's markers come to stand.
  const Eigen::Isometry3d X_WE = EndEffectorPose(s.task.view.arm, task.q_goal);
  for (std::size_t i = 0; i < s.p_WG_true.size(); ++i) {
    EXPECT_LT((X_WE * s.task.view.markers[i].p - s.p_WG_true[i]).norm(), 1e-12);
  }
}

std::string TestName(const ::testing::TestParamInfo<SuiteEntry>& info) {
  std::string name = Name(info.param);
  for (char& c : name) c = std::isalnum(static_cast<unsigned char>(c)) != 0 ? c : '_';
  return name;
}

INSTANTIATE_TEST_SUITE_P(Suite, EveryRow, ::testing::ValuesIn(SuiteEntries("all")), TestName);

TEST(Suite, HiddenAtTheGoalIsHiddenFromTheStart) {
  const SuiteTask task = MakeSuiteTask(SuiteEntries("S5/puma560").front(), 1);
  const Scenario& s = task.scenario;
  const Eigen::Vector3d p_WC = RigPose(s.rig, s.q_c_start).translation();
  const ArmSample goal = SampleArm(s.task.view, task.q_goal);
  int hidden = 0;
  for (const PlacedMarker& marker : goal.markers) hidden += IsHidden(p_WC, marker, goal.capsules);
  EXPECT_GT(hidden, 0);
}

TEST(Suite, PlacementSeesMoreThanTheStart) {
  const SuiteTask task = MakeSuiteTask(SuiteEntries("S1/puma3-xyx").front(), 1);
  const auto w_at = [&](const Scenario& s, const JointVector& q) {
    const ArmSample sample = SampleArm(s.task.view, q);
    return MeasureOf(CompositeJacobian(s.task.view, sample, RigPose(s.rig, s.q_c_start))).w;
  };
  for (const Strategy strategy : {Strategy::kPlanned, Strategy::kMinimax}) {
    const Scenario placed = WithStrategy(task.scenario, strategy);
    EXPECT_FALSE(placed.active.enabled);
    EXPECT_GT(w_at(placed, task.q_goal), w_at(task.scenario, task.q_goal)) << Name(strategy);
  }
}

TEST(Suite, UnknownNamesAreRefused) {
  EXPECT_EQ(StrategyOf("stop-and-go"), Strategy::kStopAndGo);
  EXPECT_THROW((void)StrategyOf("magic"), ConfigError);
  EXPECT_THROW((void)AblationOf("nothing"), ConfigError);
}

TaskResult Play(const SuiteEntry& entry, std::uint64_t seed, Strategy strategy) {
  const SuiteTask task = MakeSuiteTask(entry, seed);
  Scenario scenario = WithStrategy(task.scenario, strategy);
  scenario.sim.camera.kinematic = true;
  return RunTask(scenario, task);
}

// What the project is for, in small: where a fixed camera fails, the active one succeeds.
TEST(Suite, QuickSuiteIsWonByTheActiveCamera) {
  for (const SuiteEntry& entry : SuiteEntries("quick")) {
    int fixed = 0, active = 0;
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
      fixed += Play(entry, seed, Strategy::kFixed).success;
      const TaskResult result = Play(entry, seed, Strategy::kActive);
      active += result.success;
      EXPECT_EQ(result.limit_violations, 0) << Name(entry) << " " << seed;
    }
    EXPECT_GE(active, 4) << Name(entry);
    EXPECT_LT(fixed, active) << Name(entry);
  }
}

// A badly calibrated cell converges to where the image says; the truth is nearer to that where the
// calibration is found on the way.
TEST(Suite, FindsTheCalibrationOnTheWay) {
  const SuiteEntry entry = SuiteEntries("S9/planar2").front();
  int done = 0;
  double taken_as_it_is = 0.0, found = 0.0;  // [mm]
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const SuiteTask task = MakeSuiteTask(entry, seed);
    Scenario scenario = task.scenario;
    scenario.sim.camera.kinematic = true;
    const TaskResult result = RunTask(scenario, task);
    done += result.success;
    found += result.true_error_mm;
    scenario.servo.calibration.estimate = false;
    taken_as_it_is += RunTask(scenario, task).true_error_mm;
  }
  EXPECT_GE(done, 11);
  EXPECT_LT(found, 0.75 * taken_as_it_is);
}

// A goal that moves is followed by the active camera; its motion starts from rest and stays within the
// speed that the servo is told.
TEST(Suite, FollowsAGoalThatMoves) {
  const SuiteTask task = MakeSuiteTask(SuiteEntries("follow/puma560").front(), 1);
  ASSERT_TRUE(Follows(task.scenario));
  const GoalMotion& motion = task.scenario.sim.goal_motion;
  EXPECT_TRUE(GoalShift(motion, 0.0).isZero(0.0));
  constexpr double kStep = 1e-3;
  double way = 0.0;
  for (double t = 0.0; t < motion.period; t += kStep) {
    const double speed = (GoalShift(motion, t + kStep) - GoalShift(motion, t)).norm() / kStep;
    EXPECT_LE(speed, task.scenario.task.goal.max_speed + 1e-9) << t;
    way += speed * kStep;
  }
  EXPECT_GT(way, 0.2);
  Scenario scenario = task.scenario;
  scenario.sim.camera.kinematic = true;
  scenario.time_limit = 25.0;
  const TaskResult active = RunTask(scenario, task);
  EXPECT_TRUE(active.success) << active.true_error_mm;
  EXPECT_EQ(active.limit_violations, 0);
  EXPECT_NEAR(active.duration, 25.0, 0.1);
  const TaskResult fixed = RunTask(WithStrategy(scenario, Strategy::kFixed), task);
  EXPECT_GT(fixed.low_share, active.low_share);
}

// Ten goals; three of them are played here.
TEST(Suite, GoesThroughASequenceOfGoals) {
  SuiteTask task = MakeSuiteTask(SuiteEntries("sequence/puma560").front(), 1);
  ASSERT_EQ(task.next.size(), 9u);
  JointVector q = task.q_goal;
  for (const GoalStage& stage : task.next) {
    EXPECT_GT((stage.q_goal - q).lpNorm<Eigen::Infinity>(), 0.1);
    q = stage.q_goal;
  }
  task.next.resize(2);
  Scenario scenario = task.scenario;
  scenario.sim.camera.kinematic = true;
  const TaskResult result = RunTask(scenario, task);
  EXPECT_TRUE(result.success) << result.end;
  EXPECT_EQ(result.goals_reached, 3);
  EXPECT_EQ(result.limit_violations, 0);
  EXPECT_LT(result.true_error_mm, kSuccessMillimetres);
}

// Every strategy plays to an end, the same one each time.
TEST(Suite, RunsAreReproducible) {
  const SuiteEntry entry = SuiteEntries("S1/puma3-points").front();
  for (const Strategy strategy : AllStrategies()) {
    const TaskResult a = Play(entry, 2, strategy);
    const TaskResult b = Play(entry, 2, strategy);
    EXPECT_EQ(a.success, b.success) << Name(strategy);
    EXPECT_EQ(a.duration, b.duration) << Name(strategy);
    EXPECT_EQ(a.true_error_mm, b.true_error_mm) << Name(strategy);
    EXPECT_EQ(a.travel_m, b.travel_m) << Name(strategy);
  }
}

}  // namespace
}  // namespace vantage::sim
