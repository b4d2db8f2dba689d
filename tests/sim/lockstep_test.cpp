// The whole loop on rendered pixels, in simulated time: renderer, detector, servo, active camera.

#include "sim/lockstep.h"

#include <gtest/gtest.h>

namespace vantage::sim {
namespace {

class BuiltInScenario : public ::testing::TestWithParam<const char*> {};

TEST_P(BuiltInScenario, ConvergesWithTheActiveCamera) {
  const Scenario scenario = LoadScenario(GetParam());
  const LockstepRun run = RunLockstep(scenario);
  EXPECT_TRUE(run.summary.converged)
      << Name(run.summary.status.state) << " " << Name(run.summary.status.reason) << ", "
      << run.summary.status.error_px << " px, " << run.summary.observability.mm_per_px << " mm/px";
  EXPECT_LT(1e3 * run.truth.worst_error, 1.5) << "[mm]";
  EXPECT_EQ(run.summary.limit_violations, 0);
}

INSTANTIATE_TEST_SUITE_P(All, BuiltInScenario,
                         ::testing::Values("planar-good-view", "planar-grazing-view",
                                           "puma3-bad-view", "puma560-bad-view", "puma560-rail",
                                           "puma560-gantry", "puma560-two-arms", "ur5-bad-view",
                                           "panda-bad-view", "ur5-apriltag"),
                         [](const auto& test) {
                           std::string name = test.param;
                           for (char& c : name) c = c == '-' ? '_' : c;
                           return name;
                         });

TEST(Lockstep, GoesOnToTheTimeLimitWhereToldTo) {
  Scenario scenario = LoadScenario("planar-good-view");
  const double first = RunLockstep(scenario).summary.time_to_converge;
  scenario.time_limit = first + 1.0;
  const LockstepRun run = RunLockstep(scenario, {}, RunUntil::kTimeLimit);
  EXPECT_TRUE(run.summary.converged);
  EXPECT_EQ(run.summary.time_to_converge, first);
  EXPECT_NEAR(run.summary.duration, first + 1.0, 0.01);
}

TEST(Lockstep, ConvergesWithVispDots) {
  Scenario scenario = LoadScenario("planar-good-view");
  scenario.vision.kind = DetectorKind::kVispDot;
  const LockstepRun run = RunLockstep(scenario);
  EXPECT_TRUE(run.summary.converged) << run.summary.status.error_px;
  EXPECT_LT(1e3 * run.truth.worst_error, 1.5) << "[mm]";
}

TEST(Lockstep, ConvergesThroughBlurAndGainSteps) {
  Scenario scenario = LoadScenario("planar-good-view");
  scenario.sim.camera.blur = 0.7;
  scenario.sim.camera.gain_step = 0.2;
  scenario.sim.camera.gain_period = 0.3;
  scenario.sim.camera.drop_rate = 0.1;
  const LockstepRun run = RunLockstep(scenario);
  EXPECT_TRUE(run.summary.converged) << run.summary.status.error_px;
  EXPECT_LT(1e3 * run.truth.worst_error, 1.5) << "[mm]";
}

// The same seed gives the same numbers to the bit; another seed gives others.
TEST(Lockstep, IsDeterministic) {
  Scenario scenario = LoadScenario("puma3-bad-view");
  scenario.time_limit = 1.0;
  const LockstepRun a = RunLockstep(scenario);
  const LockstepRun b = RunLockstep(scenario);
  ASSERT_EQ(a.samples.size(), b.samples.size());
  ASSERT_FALSE(a.samples.empty());
  for (std::size_t i = 0; i < a.samples.size(); ++i) {
    ASSERT_EQ(a.samples[i].error_px, b.samples[i].error_px);
    ASSERT_EQ(a.samples[i].w_c, b.samples[i].w_c);
  }
  EXPECT_EQ(a.truth.q, b.truth.q);
  scenario.sim.seed += 1;
  EXPECT_NE(RunLockstep(scenario).truth.q, a.truth.q);
}

}  // namespace
}  // namespace vantage::sim
