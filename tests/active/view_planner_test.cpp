#include "vantage/active/view_planner.h"

#include <functional>
#include <random>
#include <string>

#include <gtest/gtest.h>

#include "cells.h"
#include "eigen_matchers.h"
#include "vantage/active/rig_on_arm.h"
#include "vantage/math/angles.h"
#include "vantage/math/error.h"

namespace vantage {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector4d;

PlanRequest RequestFor(const test::Task& task) {
  PlanRequest request;
  request.q = task.q;
  request.q_goal = task.q_goal;
  request.q_c = task.q_c;
  request.q_c_stay = task.q_c;
  return request;
}

// Mean over the motion of the logarithm of the measure, by Eigen's SVD.
double MeanLog(const test::Cell& cell, const std::vector<ArmSample>& motion, const RigVector& q_c,
               double cap) {
  double sum = 0.0;
  for (const ArmSample& sample : motion) {
    const TaskJacobian J = CompositeJacobian(cell.model, sample, RigPose(cell.rig, q_c));
    sum += std::log(std::min(cap, test::GeometricMean(J)));
  }
  return sum / static_cast<double>(motion.size());
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

// From bad views drawn at random: a plan is found nearly always, and each one is better by measures
// computed here, sees every marker all along the arm's motion, and loses none on the way.
TEST_P(EveryCell, PlansBetterViewsFromBadOnes) {
  const test::Cell cell = GetParam().make();
  const TriggerOptions trigger;
  const PlannerOptions options;
  std::mt19937 random(51);
  constexpr int kTrials = 60;
  int moves = 0, complete = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    const test::Task task = test::DrawTask(cell, 0.6 * trigger.threshold, &random);
    const ViewPlan plan = PlanView(cell.model, cell.rig, trigger, options, RequestFor(task));
    if (plan.verdict != PlanVerdict::kMove) continue;
    ++moves;
    const RigVector end = plan.path.end();
    EXPECT_TRUE(test::Near(end, ClampToLimits(cell.rig, end), 0.0));
    EXPECT_TRUE(test::Near(plan.path.start(), task.q_c, 0.0));
    EXPECT_GE(plan.gain, options.min_gain);

    const std::vector<ArmSample> motion =
        SampleMotion(cell.model, task.q, task.q_goal, options.path_samples);
    ASSERT_GE(plan.move.seen, 1);
    for (int i = 0; i < plan.move.seen; ++i) {
      EXPECT_TRUE(test::SeesAllByMarching(cell.model, motion[i], RigPose(cell.rig, end), 20.0))
          << "trial " << trial << " sample " << i;
    }
    if (plan.move.seen == options.path_samples) {
      ++complete;
      const double cap = options.cap * trigger.threshold;
      if (plan.stay.seen == options.path_samples) {
        EXPECT_GT(MeanLog(cell, motion, end, cap), MeanLog(cell, motion, task.q_c, cap));
      }
      // Good at the start, where the measure was below 0.6 of the threshold.
      const double then =
          test::GeometricMean(CompositeJacobian(cell.model, motion[0], RigPose(cell.rig, end)));
      EXPECT_GT(then, task.value) << "trial " << trial;
    }
    for (int i = 0; i <= 8; ++i) {
      const RigVector q_c = plan.path.At(i / 8.0);
      EXPECT_TRUE(test::Near(q_c, ClampToLimits(cell.rig, q_c), 1e-12));
      EXPECT_TRUE(test::SeesAllByMarching(cell.model, motion[0], RigPose(cell.rig, q_c), 20.0))
          << "trial " << trial << " station " << i;
    }
  }
  EXPECT_GE(moves, kTrials * 9 / 10);
  EXPECT_GE(complete, kTrials * 2 / 3);
  RecordProperty("moves", moves);
  RecordProperty("complete", complete);
}

TEST_P(EveryCell, SamePlanForSameRequest) {
  const test::Cell cell = GetParam().make();
  std::mt19937 random(52);
  const test::Task task = test::DrawTask(cell, 70.0, &random);
  const ViewPlan first = PlanView(cell.model, cell.rig, {}, {}, RequestFor(task));
  const ViewPlan second = PlanView(cell.model, cell.rig, {}, {}, RequestFor(task));
  EXPECT_EQ(first.verdict, second.verdict);
  EXPECT_EQ(first.move.score, second.move.score);
  EXPECT_TRUE(test::Near(first.path.end(), second.path.end(), 0.0));
}

// A second plan from the new view gains little: the camera does not wander.
TEST_P(EveryCell, SettlesAfterOneMove) {
  const test::Cell cell = GetParam().make();
  std::mt19937 random(53);
  int second_moves = 0, first_moves = 0;
  for (int trial = 0; trial < 20; ++trial) {
    const test::Task task = test::DrawTask(cell, 70.0, &random);
    PlanRequest request = RequestFor(task);
    const ViewPlan first = PlanView(cell.model, cell.rig, {}, {}, request);
    if (first.verdict != PlanVerdict::kMove || first.move.seen < 5) continue;
    ++first_moves;
    request.q_c = first.path.end();
    request.q_c_stay = first.path.end();
    if (PlanView(cell.model, cell.rig, {}, {}, request).verdict == PlanVerdict::kMove) {
      ++second_moves;
    }
  }
  EXPECT_GT(first_moves, 8);
  EXPECT_LE(second_moves, first_moves / 5);
}

// Rigs of every kind about the three-joint and the six-joint arm.
struct NamedRig {
  const char* name;
  int least_moves;  // of 24: some rigs have few good places
  std::function<CameraRig(const test::Cell&)> make;
};

class EveryRig : public ::testing::TestWithParam<NamedRig> {};

// A second puma faces the first one over the table, its camera on the flange.
CameraRig OnSecondArm(const test::Cell&) {
  const ArmModel puma = test::Puma560().model.arm;
  Isometry3d X_WBase = test::Translation(0.75, -1.0, 0.7);
  X_WBase.linear() = Eigen::AngleAxisd(kPi / 2.0, Vector3d::UnitZ()).toRotationMatrix();
  std::vector<JointLimits> limits(6, JointLimits{-2.9, 2.9, 1.0, 3.0});
  return RigOnArm(puma.WithBase(X_WBase).WithLimits(limits), Isometry3d::Identity(), 0.4);
}

INSTANTIATE_TEST_SUITE_P(
    Kinds, EveryRig,
    ::testing::Values(
        NamedRig{"SphericalWithHead", 20,
                 [](const test::Cell& c) { return test::SphereWithHead(c.rig); }},
        NamedRig{"Sector", 6, [](const test::Cell& c) { return test::Sector(c.rig); }},
        NamedRig{"Rail", 10, [](const test::Cell& c) { return test::RailBeside(c.rig.target_W); }},
        NamedRig{"Free", 18, [](const test::Cell& c) { return test::FreeAbout(c.rig.target_W); }},
        NamedRig{"OnArm", 10, OnSecondArm}),
    [](const auto& test) { return std::string(test.param.name); });

TEST_P(EveryRig, PlansBetterViewsFromBadOnes) {
  for (test::Cell cell : {test::Puma3Points(), test::Puma560()}) {
    cell.rig = GetParam().make(cell);
    TriggerOptions trigger;
    trigger.threshold = 150.0;
    std::mt19937 random(56);
    int moves = 0;
    for (int trial = 0; trial < 24; ++trial) {
      test::Task task = test::DrawTask(cell, 0.7 * trigger.threshold, &random);
      task.q_goal =
          0.6 * task.q + 0.4 * task.q_goal;  // Not every rig can follow the widest motions.
      const ViewPlan plan = PlanView(cell.model, cell.rig, trigger, {}, RequestFor(task));
      if (plan.verdict != PlanVerdict::kMove) continue;
      ++moves;
      const std::vector<ArmSample> motion = SampleMotion(cell.model, task.q, task.q_goal, 5);
      for (int i = 0; i < plan.move.seen; ++i) {
        EXPECT_TRUE(test::SeesAllByMarching(cell.model, motion[i],
                                            RigPose(cell.rig, plan.path.end()), 20.0));
      }
      if (plan.move.seen == 5 && plan.stay.seen == 5) {
        EXPECT_GT(MeanLog(cell, motion, plan.path.end(), 600.0),
                  MeanLog(cell, motion, task.q_c, 600.0));
      }
      for (int i = 0; i <= 30; ++i) {
        const RigVector q_c = plan.path.At(i / 30.0);
        EXPECT_TRUE(test::Near(q_c, ClampToLimits(cell.rig, q_c), 1e-12));
        EXPECT_TRUE(test::SeesAllByMarching(cell.model, motion[0], RigPose(cell.rig, q_c), 10.0))
            << cell.name << " trial " << trial << " station " << i;
      }
    }
    EXPECT_GE(moves, GetParam().least_moves) << cell.name;
    RecordProperty(std::string("moves_") + cell.name, moves);
  }
}

TEST(PlanView, PanTiltBringsMarkersToSight) {
  const test::Cell cell = test::Puma560();
  const JointVector q = 0.5 * (cell.q_lower + cell.q_upper);
  const ArmSample sample = SampleArm(cell.model, q);
  CameraRig rig;
  rig.kind = RigKind::kPanTilt;
  const Vector3d front = sample.markers[0].p_W + 1.2 * sample.markers[0].normal_W;
  rig.X_WC_fixed = test::LookingFrom(front, sample.markers[0].p_W);
  rig.axes = {{"pan", -1.5, 1.5, 1.2, 3.0}, {"tilt", -1.2, 1.2, 1.2, 3.0}};
  PlanRequest request;
  request.q = request.q_goal = q;
  request.q_c = request.q_c_stay = Vector2d(0.5, 0.3);
  const ViewPlan plan = PlanView(cell.model, rig, {}, {}, request);
  EXPECT_EQ(plan.stay.fault, ViewFault::kOutOfImage);
  ASSERT_EQ(plan.verdict, PlanVerdict::kMove);
  EXPECT_TRUE(test::SeesAllByMarching(cell.model, sample, RigPose(rig, plan.path.end()), 20.0));
}

// Above the cap a view is good enough, though nearer ones would measure more.
TEST(PlanView, KeepsGoodEnoughView) {
  const test::Cell cell = test::Planar2();
  PlanRequest request;
  request.q = Vector2d(0.2, 1.2);
  request.q_goal = Vector2d(0.4, 1.0);
  request.q_c = request.q_c_stay = Vector4d(2.2, 0.3, 0.0, 0.0);
  TriggerOptions trigger;
  trigger.threshold = 20.0;
  const ViewPlan plan = PlanView(cell.model, cell.rig, trigger, {}, request);
  EXPECT_EQ(plan.verdict, PlanVerdict::kNoGain);
  EXPECT_EQ(plan.stay.seen, 5);
  trigger.threshold = 200.0;
  EXPECT_EQ(PlanView(cell.model, cell.rig, trigger, {}, request).verdict, PlanVerdict::kMove);
}

TEST(PlanView, FixedRigCannotMove) {
  const test::Cell cell = test::Planar2();
  CameraRig rig;
  rig.X_WC_fixed = SphericalPose(RigOrientation::kLookAt, {0.4, 0, 0}, Vector4d(2.0, 1.2, 0, 0));
  PlanRequest request;
  request.q = request.q_goal = Vector2d(0.2, 1.2);
  request.q_c = request.q_c_stay = RigVector(0);
  EXPECT_EQ(PlanView(cell.model, rig, {}, {}, request).verdict, PlanVerdict::kRigCannotMove);
  rig = cell.rig;
  for (RigAxis& axis : rig.axes) axis.max_speed = 0.0;
  request.q_c = request.q_c_stay = Vector4d(2.0, 1.2, 0.0, 0.0);
  EXPECT_EQ(PlanView(cell.model, rig, {}, {}, request).verdict, PlanVerdict::kRigCannotMove);
}

TEST(PlanView, LockedAxesStay) {
  test::Cell cell = test::Planar2();
  cell.rig.axes[0].max_speed = 0.0;
  cell.rig.axes[2].max_speed = 0.0;
  PlanRequest request;
  request.q = Vector2d(0.2, 1.2);
  request.q_goal = Vector2d(0.4, 1.0);
  request.q_c = request.q_c_stay = Vector4d(1.6, 1.25, 0.7, 0.1);
  TriggerOptions trigger;
  trigger.threshold = 250.0;
  const ViewPlan plan = PlanView(cell.model, cell.rig, trigger, {}, request);
  ASSERT_EQ(plan.verdict, PlanVerdict::kMove);
  for (const double s : {0.0, 0.3, 0.7, 1.0}) {
    EXPECT_NEAR(plan.path.At(s)(0), 1.6, 1e-15);
    EXPECT_NEAR(plan.path.At(s)(2), 0.7, 1e-15);
  }
  EXPECT_LT(plan.path.end()(1), 0.8);  // from grazing towards the zenith
}

TEST(PlanView, NoViewWhereMarkersFaceAway) {
  test::Cell cell = test::Planar2();
  cell.model.markers[0].normal = -Vector3d::UnitZ();  // downwards; the rig is above
  PlanRequest request;
  request.q = Vector2d(0.2, 1.2);
  request.q_goal = Vector2d(0.4, 1.0);
  request.q_c = request.q_c_stay = Vector4d(1.2, 0.3, 0.0, 0.0);
  EXPECT_EQ(PlanView(cell.model, cell.rig, {}, {}, request).verdict, PlanVerdict::kNoView);
}

// The present view is excellent, but the arm will carry its marker out of the picture.
TEST(PlanView, LeavesViewThatWillLoseMarker) {
  test::Cell cell = test::Planar2();
  cell.rig.axes[0].upper = 3.5;
  PlanRequest request;
  request.q = Vector2d(0.3, 0.6);
  request.q_goal = Vector2d(2.4, 0.9);
  request.q_c = request.q_c_stay = Vector4d(1.2, 0.2, 0.0, 0.0);
  const ViewPlan plan = PlanView(cell.model, cell.rig, {}, {}, request);
  EXPECT_LT(plan.stay.seen, 5);
  EXPECT_EQ(plan.stay.fault, ViewFault::kOutOfImage);
  ASSERT_EQ(plan.verdict, PlanVerdict::kMove);
  EXPECT_EQ(plan.move.seen, 5);
}

TEST(PlanView, KeepsGoalMarkersInSight) {
  const test::Cell cell = test::Puma3Points();
  std::mt19937 random(54);
  int moves = 0;
  for (int trial = 0; trial < 20; ++trial) {
    const test::Task task = test::DrawTask(cell, 70.0, &random);
    PlanRequest request = RequestFor(task);
    const ArmSample goal = SampleArm(cell.model, task.q_goal);
    for (PlacedMarker marker : goal.markers) {
      marker.p_W += Vector3d(0.0, 0.0, 0.25);
      request.goal_markers.push_back(marker);
    }
    const ViewPlan plan = PlanView(cell.model, cell.rig, {}, {}, request);
    if (plan.verdict != PlanVerdict::kMove) continue;
    ++moves;
    const Isometry3d X_WC = RigPose(cell.rig, plan.path.end());
    const ArmSample now = SampleArm(cell.model, task.q);
    for (const PlacedMarker& marker : request.goal_markers) {
      EXPECT_TRUE(test::SeenByMarching(cell.model.camera, X_WC, marker, now.capsules, 20.0));
    }
  }
  EXPECT_GE(moves, 10);
}

// x1, y1, x2: for each camera position one roll is singular. Nothing but roll is free.
TEST(PlanView, TurnsAwayFromSingularRoll) {
  test::Cell cell = test::Puma3Xyx();
  for (int axis = 0; axis < 3; ++axis) cell.rig.axes[axis].max_speed = 0.0;
  PlanRequest request;
  request.q = request.q_goal = Vector3d(0.1, 0.7, -1.3);
  RigVector q_c = Vector4d(1.3, 1.3, -kPi / 2.0, 0.0);
  const ArmSample sample = SampleArm(cell.model, request.q);
  const auto measure = [&](double roll) {
    q_c(3) = roll;
    return test::GeometricMean(CompositeJacobian(cell.model, sample, RigPose(cell.rig, q_c)));
  };
  double worst = 0.0;
  for (double roll = -1.5; roll < 1.6; roll += 0.001) {
    if (measure(roll) < measure(worst)) worst = roll;
  }
  q_c(3) = worst;
  request.q_c = request.q_c_stay = q_c;
  const ViewPlan plan = PlanView(cell.model, cell.rig, {}, {}, request);
  ASSERT_EQ(plan.verdict, PlanVerdict::kMove);
  EXPECT_LT(measure(worst), 20.0);
  EXPECT_GT(measure(plan.path.end()(3)), 10.0 * measure(worst));
}

// A camera that looks down moves on a rail that descends. The near end is better, but a pillar stands
// before the middle of the way.
TEST(PlanView, NoPathBehindPillar) {
  test::Cell cell = test::Planar2();
  const auto with_pillar = [&](bool pillar) {
    std::vector<Capsule> capsules = cell.model.arm.capsules();
    if (pillar) capsules.push_back({-1, {0.7, -0.5, 0.5}, {0.7, 1.0, 0.5}, 0.03});
    DhRow row;
    row.a = 0.5;
    return ArmModel("planar2", DhConvention::kStandard, {row, row}, test::WideLimits(2),
                    Isometry3d::Identity(), Isometry3d::Identity(), capsules);
  };
  CameraRig rig;
  rig.kind = RigKind::kRail;
  rig.X_WC_fixed.linear() = Vector3d(1.0, -1.0, -1.0).asDiagonal();
  rig.X_WC_fixed.translation() = Vector3d(0.6, 0.2, 1.8);
  rig.rail_W = Vector3d(0.9, 0.0, -std::sqrt(1.0 - 0.81));
  rig.axes = {{"s", -0.8, 0.6, 0.4, 0.8}};
  PlanRequest request;
  request.q = request.q_goal = Vector2d(0.1, 0.9);
  request.q_c = request.q_c_stay = RigVector::Constant(1, -0.8);
  TriggerOptions trigger;
  trigger.threshold = 300.0;
  cell.model.arm = with_pillar(false);
  const ViewPlan without = PlanView(cell.model, rig, trigger, {}, request);
  ASSERT_EQ(without.verdict, PlanVerdict::kMove);
  EXPECT_GT(without.path.end()(0), 0.3);
  cell.model.arm = with_pillar(true);
  EXPECT_EQ(PlanView(cell.model, rig, trigger, {}, request).verdict, PlanVerdict::kNoPath);
}

// The planar arm, seen from 2.2 m at this polar angle.
PlanRequest PlanarRequest(double theta) {
  PlanRequest request;
  request.q = Vector2d(0.2, 1.2);
  request.q_goal = Vector2d(0.4, 1.0);
  request.q_c = request.q_c_stay = Vector4d(2.2, theta, 0.0, 0.0);
  return request;
}

TEST(PlanView, SpoiltViewIsLeftForAnotherPlace) {
  const test::Cell cell = test::Planar2();
  PlanRequest request = PlanarRequest(0.3);
  request.stay_is_spoiled = true;
  const ViewPlan plan = PlanView(cell.model, cell.rig, {}, {}, request);
  ASSERT_EQ(plan.verdict, PlanVerdict::kMove);
  const Isometry3d X =
      RigPose(cell.rig, request.q_c).inverse() * RigPose(cell.rig, plan.path.end());
  EXPECT_GE(X.translation().norm() + Eigen::AngleAxisd(X.linear()).angle(), 0.2);
}

TEST(PlanView, KeepsAwayFromEverySpoiltView) {
  const test::Cell cell = test::Planar2();
  PlanRequest request = PlanarRequest(0.3);
  request.stay_is_spoiled = true;
  for (int i = 0; i < 8; ++i) {
    const ViewPlan plan = PlanView(cell.model, cell.rig, {}, {}, request);
    ASSERT_EQ(plan.verdict, PlanVerdict::kMove) << i;
    const Isometry3d X_WEnd = RigPose(cell.rig, plan.path.end());
    for (const Isometry3d& X_WSpoiled : request.X_WSpoiled) {
      const Isometry3d X = X_WSpoiled.inverse() * X_WEnd;
      EXPECT_GE(X.translation().norm() + Eigen::AngleAxisd(X.linear()).angle(), 0.2) << i;
    }
    request.X_WSpoiled.push_back(X_WEnd);
  }
}

// A marker of the goal lies face down: no view sees it, and all that see the arm will do when it need not be.
TEST(PlanView, GoesOnWithoutTheGoalWhereItMay) {
  const test::Cell cell = test::Planar2();
  PlanRequest request = PlanarRequest(1.4);
  request.goal_markers.push_back({Vector3d(0.2, 0.6, 0.05), -Vector3d::UnitZ(), 0.015});
  EXPECT_EQ(PlanView(cell.model, cell.rig, {}, {}, request).verdict, PlanVerdict::kNoView);
  request.goal_optional = true;
  const ViewPlan plan = PlanView(cell.model, cell.rig, {}, {}, request);
  ASSERT_EQ(plan.verdict, PlanVerdict::kMove);
  const ArmSample sample = SampleArm(cell.model, request.q);
  EXPECT_TRUE(
      test::SeesAllByMarching(cell.model, sample, RigPose(cell.rig, plan.path.end()), 20.0));
}

// One of the arm's four markers faces the floor.
TEST(PlanView, SparesAMarkerWhereItMay) {
  test::Cell cell = test::Puma560();
  std::mt19937 random(56);
  const test::Task task = test::DrawTask(cell, 70.0, &random);
  cell.model.markers[2].normal = -cell.model.markers[2].normal;
  PlanRequest request = RequestFor(task);
  EXPECT_EQ(PlanView(cell.model, cell.rig, {}, {}, request).verdict, PlanVerdict::kNoView);
  request.spare_markers = 1;
  const ViewPlan plan = PlanView(cell.model, cell.rig, {}, {}, request);
  ASSERT_EQ(plan.verdict, PlanVerdict::kMove);
  const ArmSample sample = SampleArm(cell.model, task.q);
  const Isometry3d X_WC = RigPose(cell.rig, plan.path.end());
  for (const std::size_t i : {0, 1, 3}) {
    EXPECT_EQ(CheckMarkerAmong(cell.model.camera, PlannerOptions{}.limits, X_WC, sample.markers[i],
                               sample, {}),
              ViewFault::kNone)
        << i;
  }
}

// Each trigger measure is the one that its plan raises.
TEST(PlanView, RaisesTheMeasureNamed) {
  const test::Cell cell = test::Puma560();
  std::mt19937 random(55);
  int moves = 0;
  for (int trial = 0; trial < 5; ++trial) {
    test::Task task = test::DrawTask(cell, 70.0, &random);
    task.q_goal = task.q;
    const auto value = [&](TriggerMeasure measure, const RigVector& q_c) {
      return TriggerValue(measure,
                          MeasureOf(CompositeJacobian(cell.model, SampleArm(cell.model, task.q),
                                                      RigPose(cell.rig, q_c))));
    };
    for (const auto measure : {TriggerMeasure::kGeometricMean, TriggerMeasure::kCompositeW,
                               TriggerMeasure::kSigmaMin, TriggerMeasure::kInverseCondition}) {
      TriggerOptions trigger;
      trigger.measure = measure;
      const double now = value(measure, task.q_c);
      trigger.threshold = 2.0 * now;
      const ViewPlan plan = PlanView(cell.model, cell.rig, trigger, {}, RequestFor(task));
      if (plan.verdict != PlanVerdict::kMove) continue;
      ++moves;
      EXPECT_GT(value(measure, plan.path.end()), now) << static_cast<int>(measure);
    }
  }
  EXPECT_GE(moves, 10);
}

TEST(ScoreView, IsMeanLogarithmBetweenFloorAndCap) {
  const test::Cell cell = test::Planar2();
  const TriggerOptions trigger;
  PlannerOptions options;
  options.cap = 100.0;
  const std::vector<ArmSample> motion =
      SampleMotion(cell.model, Vector2d(0.2, 1.2), Vector2d(0.4, 0.9), 2);
  const Isometry3d X_WC = RigPose(cell.rig, Vector4d(1.5, 0.4, 0.2, 0.0));
  const double expected =
      0.5 * (std::log(test::GeometricMean(CompositeJacobian(cell.model, motion[0], X_WC))) +
             std::log(test::GeometricMean(CompositeJacobian(cell.model, motion[1], X_WC))));
  EXPECT_NEAR(ScoreView(cell.model, trigger, options, motion, {}, X_WC).score, expected, 1e-10);
  options.cap = 1.0001;
  EXPECT_NEAR(ScoreView(cell.model, trigger, options, motion, {}, X_WC).score,
              std::log(1.0001 * trigger.threshold), 1e-10);
}

TEST(ScoreView, CountsUnseenSamplesAsWorthless) {
  const test::Cell cell = test::Planar2();
  const std::vector<ArmSample> motion =
      SampleMotion(cell.model, Vector2d(0.3, 0.6), Vector2d(2.6, 0.9), 5);
  const ViewScore view =
      ScoreView(cell.model, {}, {}, motion, {}, RigPose(cell.rig, Vector4d(1.2, 0.2, 0.0, 0.0)));
  ASSERT_GT(view.seen, 0);
  ASSERT_LT(view.seen, 5);
  const double unseen = std::log(1e-3 * TriggerOptions{}.threshold);
  EXPECT_LT(view.score, std::log(4.0 * 120.0));
  EXPECT_GT(view.score, unseen);
}

// Between two samples det J_c changes its sign: w_c is 0 on the way, though neither sample shows it.
TEST(ScoreView, MarksDownCrossings) {
  const test::Cell cell = test::Planar2();
  PlannerOptions options;
  options.cap = 100.0;
  // The elbow passes through straight: the arm's own singularity, the same for each camera.
  const std::vector<ArmSample> motion =
      SampleMotion(cell.model, Vector2d(0.6, -0.5), Vector2d(0.1, 0.5), 2);
  const Isometry3d X_WC = RigPose(cell.rig, Vector4d(1.8, 0.3, 0.0, 0.0));
  double mean = 0.0;
  for (const ArmSample& sample : motion) {
    mean += 0.5 * std::log(test::GeometricMean(CompositeJacobian(cell.model, sample, X_WC)));
  }
  const ViewScore view = ScoreView(cell.model, {}, options, motion, {}, X_WC);
  ASSERT_EQ(view.seen, 2);
  EXPECT_NEAR(view.score, mean - 1.0, 1e-10);
}

TEST(ValidatePlanner, RefusesEachCause) {
  EXPECT_NO_THROW(Validate(PlannerOptions{}));
  const std::vector<std::function<void(PlannerOptions*)>> causes{
      [](PlannerOptions* o) { o->candidates = 7; },
      [](PlannerOptions* o) { o->path_samples = 0; },
      [](PlannerOptions* o) { o->path_samples = 17; },
      [](PlannerOptions* o) { o->travel_cost = -0.1; },
      [](PlannerOptions* o) { o->cap = 1.0; },
      [](PlannerOptions* o) { o->min_gain = -0.1; },
      [](PlannerOptions* o) { o->max_mm_per_px = 0.0; },
      [](PlannerOptions* o) { o->limits.margin = -1.0; },
      [](PlannerOptions* o) { o->limits.min_depth = 0.0; },
      [](PlannerOptions* o) { o->limits.max_depth = 0.2; },
      [](PlannerOptions* o) { o->limits.max_incidence = 1.6; },
      [](PlannerOptions* o) { o->limits.min_semi_axis = -1.0; },
      [](PlannerOptions* o) { o->limits.min_semi_axis = std::nan(""); }};
  for (std::size_t i = 0; i < causes.size(); ++i) {
    PlannerOptions options;
    causes[i](&options);
    EXPECT_THROW(Validate(options), ConfigError) << "cause " << i;
  }
}

}  // namespace
}  // namespace vantage
