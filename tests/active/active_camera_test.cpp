#include "vantage/active/active_camera.h"

#include <functional>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "cells.h"
#include "eigen_matchers.h"
#include "vantage/math/error.h"

namespace vantage {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector4d;

constexpr double kPeriod = 1.0 / 60.0;

// An arm that runs to its goal as a servo would drive it, and a camera that obeys: what the active
// camera is told of them, step by step.
class Loop {
 public:
  Loop(const test::Cell& cell, const test::Task& task, const ActiveOptions& options = {})
      : cell_(cell), task_(task), camera_(cell.model, cell.rig, task.q_c, options) {
    inputs_.now = Time(std::chrono::seconds(5));
    inputs_.q = task.q;
    inputs_.q_goal = task.q_goal;
    inputs_.qdot = JointVector::Zero(task.q.size());
    inputs_.X_WC = RigPose(cell.rig, task.q_c);
  }

  const ActiveOutput& Step() {
    if (arm_moves) {
      inputs_.qdot = 0.8 * (task_.q_goal - inputs_.q);
      inputs_.q += kPeriod * inputs_.qdot;
    }
    sample_ = SampleArm(cell_.model, inputs_.q);
    inputs_.composite = MeasureOf(CompositeJacobian(cell_.model, sample_, inputs_.X_WC));
    if (change_inputs) change_inputs(&inputs_);
    output_ = camera_.Step(inputs_);
    inputs_.X_WC = output_.X_WC;
    inputs_.now += FromSeconds(kPeriod);
    return output_;
  }

  bool arm_moves{false};
  std::function<void(ActiveInputs*)> change_inputs;
  const test::Cell cell_;
  const test::Task task_;
  ActiveCamera camera_;
  ActiveInputs inputs_;
  ActiveOutput output_;
  ArmSample sample_;
};

test::Task TaskOf(const JointVector& q, const JointVector& q_goal, const RigVector& q_c) {
  return {q, q_goal, q_c, 0.0};
}

// The planar arm at rest seen at a grazing angle: below the threshold, with better views all round.
test::Task GrazingTask() {
  return TaskOf(Vector2d(0.2, 1.2), Vector2d(0.2, 1.2), Vector4d(2.0, 1.25, 0.5, 0.0));
}

struct NamedCell {
  const char* name;
  std::function<test::Cell()> make;
};

class EveryCell : public ::testing::TestWithParam<NamedCell> {};
INSTANTIATE_TEST_SUITE_P(Arms, EveryCell,
                         ::testing::Values(NamedCell{"Planar2", test::Planar2},
                                           NamedCell{"Puma3Xyx", test::Puma3Xyx},
                                           NamedCell{"Puma3Points", test::Puma3Points},
                                           NamedCell{"Puma560", test::Puma560}),
                         [](const auto& test) { return std::string(test.param.name); });

TEST_P(EveryCell, LeavesBadViewsWithinEveryBound) {
  const test::Cell cell = GetParam().make();
  std::mt19937 random(61);
  int improved = 0;
  constexpr int kTrials = 12;
  for (int trial = 0; trial < kTrials; ++trial) {
    Loop loop(cell, test::DrawTask(cell, 70.0, &random));
    loop.arm_moves = true;
    RigVector last = loop.task_.q_c, last_step = RigVector::Zero(cell.rig.size());
    for (int i = 0; i < 1500; ++i) {
      const ActiveOutput& output = loop.Step();
      const RigVector step = output.q_c - last;
      for (int a = 0; a < cell.rig.size(); ++a) {
        const RigAxis& axis = cell.rig.axes[a];
        ASSERT_LE(std::abs(step(a)), axis.max_speed * kPeriod * (1 + 1e-6));
        ASSERT_LE(std::abs(step(a) - last_step(a)),
                  axis.max_acceleration * kPeriod * kPeriod * (1 + 1e-6) + 1e-13);
        ASSERT_GE(output.q_c(a), axis.lower - 1e-12);
        ASSERT_LE(output.q_c(a), axis.upper + 1e-12);
      }
      const double moved =
          (output.X_WC.translation() - RigPose(cell.rig, last).translation()).norm();
      ASSERT_LE(moved, cell.rig.max_linear_speed * kPeriod * (1 + 1e-6));
      last = output.q_c;
      last_step = step;
    }
    EXPECT_EQ(loop.output_.state, ActiveState::kWatching);
    EXPECT_LE(loop.output_.moves, 6);
    if (loop.output_.trigger_value > 120.0) ++improved;
  }
  EXPECT_GE(improved, kTrials * 3 / 4);
}

// The camera never gives away what it sees: with the arm at rest, markers that are seen stay seen.
TEST_P(EveryCell, LosesNoMarkerOnTheWay) {
  const test::Cell cell = GetParam().make();
  std::mt19937 random(62);
  int moves = 0;
  for (int trial = 0; trial < 12; ++trial) {
    Loop loop(cell, test::DrawTask(cell, 70.0, &random));
    for (int i = 0; i < 600; ++i) {
      loop.Step();
      if (i % 10 == 0) {
        ASSERT_TRUE(test::SeesAllByMarching(cell.model, loop.sample_, loop.output_.X_WC, 10.0))
            << "trial " << trial << " step " << i;
      }
    }
    moves += static_cast<int>(loop.output_.moves);
  }
  EXPECT_GE(moves, 8);
}

TEST_P(EveryCell, IsDeterministic) {
  const test::Cell cell = GetParam().make();
  std::mt19937 random(63);
  const test::Task task = test::DrawTask(cell, 70.0, &random);
  Loop first(cell, task), second(cell, task);
  first.arm_moves = second.arm_moves = true;
  for (int i = 0; i < 300; ++i) {
    ASSERT_TRUE(test::Near(first.Step().q_c, second.Step().q_c, 0.0));
  }
}

TEST_P(EveryCell, PoseIsThatOfTheCoordinates) {
  const test::Cell cell = GetParam().make();
  std::mt19937 random(64);
  Loop loop(cell, test::DrawTask(cell, 60.0, &random));
  int moving = 0;
  for (int i = 0; i < 600; ++i) {
    const ActiveOutput& output = loop.Step();
    EXPECT_TRUE(test::Near(output.X_WC.matrix(), RigPose(cell.rig, output.q_c).matrix(), 0.0));
    moving += output.state == ActiveState::kMoving ? 1 : 0;
  }
  EXPECT_GT(moving, 20);
}

TEST(ActiveCamera, MovesOnLowMeasureAndSettles) {
  Loop loop(test::Planar2(), GrazingTask());
  const double before = loop.Step().trigger_value;
  EXPECT_LT(before, 120.0);
  EXPECT_EQ(loop.output_.state, ActiveState::kWatching);  // Debouncing.
  loop.Step();
  loop.Step();
  EXPECT_EQ(loop.output_.state, ActiveState::kMoving);
  EXPECT_EQ(loop.output_.reason, ActiveReason::kLowMeasure);
  EXPECT_GT(loop.output_.gain, 0.15);
  for (int i = 0; i < 600; ++i) loop.Step();
  EXPECT_EQ(loop.output_.state, ActiveState::kWatching);
  EXPECT_EQ(loop.output_.refusal, ActiveRefusal::kNone);
  EXPECT_FALSE(loop.output_.triggered);
  EXPECT_GT(loop.output_.trigger_value, 144.0);
  const Isometry3d at_rest = loop.output_.X_WC;
  EXPECT_TRUE(test::Near(loop.Step().X_WC.matrix(), at_rest.matrix(), 0.0));
}

TEST(ActiveCamera, ArmCauseDoesNotMoveAndSaysSo) {
  Loop loop(test::Planar2(), GrazingTask());
  loop.change_inputs = [](ActiveInputs* inputs) { inputs->cause = LowCause::kArm; };
  for (int i = 0; i < 120; ++i) loop.Step();
  EXPECT_EQ(loop.output_.moves, 0);
  EXPECT_EQ(loop.output_.plans, 0);
  EXPECT_TRUE(loop.output_.triggered);
  EXPECT_EQ(loop.output_.reason, ActiveReason::kLowMeasure);
  EXPECT_EQ(loop.output_.refusal, ActiveRefusal::kArm);
  EXPECT_TRUE(test::Near(loop.output_.q_c, loop.task_.q_c, 0.0));
}

TEST(ActiveCamera, FixedRigNeverMoves) {
  test::Cell cell = test::Planar2();
  test::Task task = GrazingTask();
  CameraRig rig;
  rig.X_WC_fixed = RigPose(cell.rig, task.q_c);
  cell.rig = rig;
  task.q_c = RigVector(0);
  Loop loop(cell, task);
  for (int i = 0; i < 120; ++i) loop.Step();
  EXPECT_EQ(loop.output_.moves, 0);
  EXPECT_EQ(loop.output_.refusal, ActiveRefusal::kRigCannotMove);
  EXPECT_TRUE(test::Near(loop.output_.X_WC.matrix(), rig.X_WC_fixed.matrix(), 0.0));
}

TEST(ActiveCamera, DisabledMeasuresButNeverMoves) {
  ActiveOptions options;
  options.enabled = false;
  Loop loop(test::Planar2(), GrazingTask(), options);
  for (int i = 0; i < 120; ++i) loop.Step();
  EXPECT_EQ(loop.output_.state, ActiveState::kDisabled);
  EXPECT_TRUE(loop.output_.triggered);
  EXPECT_GT(loop.output_.trigger_value, 0.0);
  EXPECT_EQ(loop.output_.plans, 0);
  EXPECT_TRUE(test::Near(loop.output_.q_c, loop.task_.q_c, 0.0));
}

// A measure that hovers at the threshold: no to and fro.
TEST(ActiveCamera, DoesNotChatterRoundTheThreshold) {
  for (const test::Cell& cell : test::AllCells()) {
    std::mt19937 random(65);
    std::normal_distribution<double> noise(1.0, 0.05);
    Loop loop(cell, test::DrawTask(cell, 70.0, &random));
    loop.change_inputs = [&](ActiveInputs* inputs) {
      // Whatever the camera does, the measure stays about the threshold.
      const double value = 120.0 * noise(random);
      inputs->composite.sigma.setConstant(value);
      inputs->composite.log_w = inputs->composite.size() * std::log(value);
    };
    for (int i = 0; i < 60 * 60; ++i) loop.Step();
    EXPECT_LE(loop.output_.moves, 2) << cell.name;
  }
}

// Where nothing helps the camera thinks less and less often, and stays.
TEST(ActiveCamera, FruitlessPlansBecomeRare) {
  test::Cell cell = test::Planar2();
  for (int axis : {0, 1, 3}) cell.rig.axes[axis].max_speed = 0.0;
  cell.rig.axes[2].lower = 0.4;
  cell.rig.axes[2].upper = 0.6;
  // The marker is well above the least size that can be found: a nearer view gains nothing by that.
  for (Marker& marker : cell.model.markers) marker.radius *= 2.0;
  Loop loop(cell, GrazingTask());
  for (int i = 0; i < 60 * 60; ++i) loop.Step();
  EXPECT_EQ(loop.output_.moves, 0);
  EXPECT_EQ(loop.output_.refusal, ActiveRefusal::kNoBetterView);
  EXPECT_EQ(loop.output_.fruitless, loop.output_.plans);
  EXPECT_GE(loop.output_.plans, 10);
  EXPECT_LE(loop.output_.plans, 20);
}

TEST(ActiveCamera, PlansAreSpaced) {
  Loop loop(test::Planar2(), GrazingTask());
  std::int64_t plans = 0;
  int last = -1000;
  for (int i = 0; i < 600; ++i) {
    loop.Step();
    if (loop.output_.plans == plans) continue;
    EXPECT_GE(i - last, 30);
    last = i;
    plans = loop.output_.plans;
  }
  EXPECT_GE(plans, 2);
}

TEST(ActiveCamera, MovesWhenMarkerIsLost) {
  Loop loop(test::Planar2(),
            TaskOf(Vector2d(0.2, 1.2), Vector2d(0.2, 1.2), Vector4d(2.2, 0.3, 0.0, 0.0)));
  loop.Step();
  ASSERT_FALSE(loop.output_.triggered);
  loop.change_inputs = [&](ActiveInputs* inputs) {
    // Something stands before the camera until it has moved by a foot.
    const Isometry3d start = RigPose(loop.cell_.rig, loop.task_.q_c);
    inputs->markers_lost = (inputs->X_WC.translation() - start.translation()).norm() < 0.3 ? 1 : 0;
  };
  for (int i = 0; i < 900; ++i) loop.Step();
  EXPECT_EQ(loop.output_.reason, ActiveReason::kMarkerLost);
  EXPECT_GE(loop.output_.moves, 1);
  EXPECT_EQ(loop.inputs_.markers_lost, 0);
}

TEST(ActiveCamera, OneLostImageIsNoReason) {
  Loop loop(test::Planar2(),
            TaskOf(Vector2d(0.2, 1.2), Vector2d(0.2, 1.2), Vector4d(2.2, 0.3, 0.0, 0.0)));
  int i = 0;
  loop.change_inputs = [&](ActiveInputs* inputs) { inputs->markers_lost = ++i % 3 == 0 ? 1 : 0; };
  for (int k = 0; k < 120; ++k) loop.Step();
  EXPECT_EQ(loop.output_.plans, 0);
}

// The arm runs towards the edge of a good picture: the camera moves before the marker is gone.
TEST(ActiveCamera, MovesBeforeMarkerIsLost) {
  test::Cell cell = test::Planar2();
  cell.rig.axes[0].upper = 3.5;
  Loop loop(cell, TaskOf(Vector2d(0.3, 0.6), Vector2d(2.0, 0.9), Vector4d(1.7, 0.2, 0.0, 0.0)));
  loop.arm_moves = true;
  bool lost = false;
  for (int i = 0; i < 600; ++i) {
    loop.Step();
    lost = lost || !test::SeesAllByMarching(cell.model, loop.sample_, loop.output_.X_WC, 0.0);
  }
  EXPECT_EQ(loop.output_.reason, ActiveReason::kMarkerAtRisk);
  EXPECT_GE(loop.output_.moves, 1);
  EXPECT_FALSE(lost);
}

TEST(ActiveCamera, StalledServoGetsAnotherView) {
  Loop loop(test::Planar2(),
            TaskOf(Vector2d(0.2, 1.2), Vector2d(0.2, 1.2), Vector4d(2.2, 0.3, 0.0, 0.0)));
  loop.change_inputs = [](ActiveInputs* inputs) { inputs->stalled = true; };
  for (int i = 0; i < 60; ++i) loop.Step();
  EXPECT_EQ(loop.output_.reason, ActiveReason::kStalled);
  EXPECT_EQ(loop.output_.moves, 1);
}

// On the way the arm swings a link before the marker that the camera goes past: it waits.
TEST(ActiveCamera, GuardStopsBeforeLosingMarker) {
  test::Cell cell = test::Planar2();
  cell.rig.axes[0].max_speed = cell.rig.axes[3].max_speed = 0.0;
  Loop loop(cell, GrazingTask());
  for (int i = 0; i < 20; ++i) loop.Step();
  ASSERT_EQ(loop.output_.state, ActiveState::kMoving);
  // A goal marker appears in the scene, seen from here but not from where the camera is going: it
  // faces sideways.
  const Isometry3d X_WC = loop.output_.X_WC;
  PlacedMarker marker{{0.3, 0.3, 0.1}, Vector3d::UnitX(), 0.03};
  const Vector3d ray = (X_WC.translation() - marker.p_W).normalized();
  Loop next = loop;
  const Vector3d ahead = (next.Step().X_WC.translation() - X_WC.translation()).normalized();
  // Oblique by almost the limit, and more so further on.
  marker.normal_W =
      (std::cos(1.25) * ray - std::sin(1.25) * (ahead - ahead.dot(ray) * ray).normalized());
  loop.change_inputs = [&](ActiveInputs* inputs) { inputs->goal_markers = {marker}; };
  bool held = false;
  for (int i = 0; i < 120; ++i) {
    loop.Step();
    held = held || loop.output_.refusal == ActiveRefusal::kGuard;
    ASSERT_EQ(CheckMarker(cell.model.camera, ViewLimits{}, loop.output_.X_WC, marker, {}),
              ViewFault::kNone);
  }
  EXPECT_TRUE(held);
}

TEST(ActiveCamera, BadInputsBringCameraToRest) {
  Loop loop(test::Planar2(), GrazingTask());
  for (int i = 0; i < 30; ++i) loop.Step();
  ASSERT_EQ(loop.output_.state, ActiveState::kMoving);
  const std::vector<std::function<void(ActiveInputs*)>> causes{
      [](ActiveInputs* in) { in->q(0) = std::numeric_limits<double>::quiet_NaN(); },
      [](ActiveInputs* in) { in->qdot.resize(0); },
      [](ActiveInputs* in) { in->q_goal(1) = std::numeric_limits<double>::infinity(); },
      [](ActiveInputs* in) { in->X_WC.linear()(0, 0) = std::numeric_limits<double>::quiet_NaN(); }};
  for (const auto& spoil : causes) {
    ActiveCamera camera = loop.camera_;
    ActiveInputs inputs = loop.inputs_;
    spoil(&inputs);
    ActiveOutput output;
    RigVector before;
    for (int i = 0; i < 60; ++i) {
      before = output.q_c;
      inputs.now += FromSeconds(kPeriod);
      output = camera.Step(inputs);
      EXPECT_EQ(output.refusal, ActiveRefusal::kBadInputs);
      EXPECT_TRUE(output.q_c.allFinite());
    }
    EXPECT_TRUE(test::Near(output.q_c, before, 0.0));
  }
}

TEST(ActiveCamera, TimeThatRunsBackwardsCountsAsStanding) {
  Loop loop(test::Planar2(), GrazingTask());
  for (int i = 0; i < 30; ++i) loop.Step();
  const RigVector q_c = loop.output_.q_c;
  loop.inputs_.now -= FromSeconds(3.0);
  EXPECT_TRUE(test::Near(loop.Step().q_c, q_c, 0.0));
  loop.inputs_.now += FromSeconds(1000.0);
  const RigVector after = loop.Step().q_c;
  EXPECT_LE((after - q_c).cwiseAbs().maxCoeff(), 0.1 * 0.8);
}

// Started beside a rig that stands elsewhere than configured, the camera goes on from there.
TEST(ActiveCamera, StartsWhereTheRigIs) {
  const test::Cell cell = test::Planar2();
  const RigVector actual = Vector4d(1.9, 0.4, -0.7, 0.2);
  Loop loop(cell, TaskOf(Vector2d(0.2, 1.2), Vector2d(0.2, 1.2), Vector4d(2.2, 0.3, 0.0, 0.0)));
  loop.inputs_.X_WC = RigPose(cell.rig, actual);
  EXPECT_TRUE(test::Near(loop.Step().q_c, actual, 1e-9));
}

TEST(ActiveCamera, FollowsRigThatDidNotObey) {
  const test::Cell cell = test::Planar2();
  const RigVector actual = Vector4d(1.9, 0.4, -0.7, 0.2);
  Loop loop(cell, TaskOf(Vector2d(0.2, 1.2), Vector2d(0.2, 1.2), Vector4d(2.2, 0.3, 0.0, 0.0)));
  loop.Step();
  loop.change_inputs = [&](ActiveInputs* inputs) { inputs->X_WC = RigPose(cell.rig, actual); };
  for (int i = 0; i < 50; ++i) loop.Step();
  EXPECT_TRUE(test::Near(loop.output_.q_c, loop.task_.q_c, 0.0));  // Not at once.
  for (int i = 0; i < 30; ++i) loop.Step();
  EXPECT_TRUE(test::Near(loop.output_.q_c, actual, 1e-9));
}

TEST(PredictJoints, DoesNotPassTheGoal) {
  const JointVector q = Vector3d(0.0, 0.0, 0.0);
  const JointVector goal = Vector3d(0.1, 1.0, -0.5);
  const JointVector qdot = Vector3d(0.5, 0.5, 0.5);
  EXPECT_TRUE(test::Near(PredictJoints(q, qdot, goal, 0.6), Vector3d(0.1, 0.3, 0.3), 1e-15));
}

TEST(ActiveCameraOptions, RefusesEachCause) {
  const test::Cell cell = test::Planar2();
  const RigVector start = Vector4d(2.0, 0.3, 0.0, 0.0);
  EXPECT_NO_THROW(ActiveCamera(cell.model, cell.rig, start, {}));
  EXPECT_THROW(ActiveCamera(cell.model, cell.rig, RigVector(0), {}), ConfigError);
  EXPECT_THROW(ActiveCamera(cell.model, cell.rig, Vector4d(9.0, 0.3, 0.0, 0.0), {}), ConfigError);
  const std::vector<std::function<void(ActiveOptions*)>> causes{
      [](ActiveOptions* o) { o->replan_interval = 0.0; },
      [](ActiveOptions* o) { o->look_ahead = -0.1; },
      [](ActiveOptions* o) { o->trigger.threshold = -1.0; },
      [](ActiveOptions* o) { o->planner.candidates = 1; }};
  for (const auto& spoil : causes) {
    ActiveOptions options;
    spoil(&options);
    EXPECT_THROW(ActiveCamera(cell.model, cell.rig, start, options), ConfigError);
  }
  test::Cell bad = cell;
  bad.rig.axes.pop_back();
  EXPECT_THROW(ActiveCamera(bad.model, bad.rig, start, {}), ConfigError);
  bad = cell;
  bad.model.markers.clear();
  EXPECT_THROW(ActiveCamera(bad.model, bad.rig, start, {}), ConfigError);
}

}  // namespace
}  // namespace vantage
