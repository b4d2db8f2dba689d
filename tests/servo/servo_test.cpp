#include "vantage/servo/servo.h"

#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "allocation_guard.h"
#include "eigen_matchers.h"
#include "test_arm.h"
#include "vantage/math/error.h"

namespace vantage {
namespace {

using Eigen::Isometry3d;

Time At(double seconds) {
  return Time(FromSeconds(seconds));
}

// What of a command an arm obeys.
enum class Takes { kVelocities, kPositions, kPositionsSlowly };

// A noise-free cell: the arm obeys at once, images come at 50 Hz with a latency, projected by the model.
class Cell {
 public:
  Cell(const ViewModel& view, const JointVector& q)
      : view_(view), q_(q), qdot_(JointVector::Zero(q.size())) {}

  void Advance(const JointCommand& command, const Isometry3d& X_WC) {
    command_ = command;
    X_WC_ = X_WC;
    GoOn();
  }
  /// A period by the last command.
  void GoOn() {
    const JointVector before = q_;
    if (takes == Takes::kVelocities) q_ += test::kPeriod * command_.qdot;
    if (takes == Takes::kPositions) q_ = command_.q;
    if (takes == Takes::kPositionsSlowly) q_ += test::kPeriod / kSlowness * (command_.q - q_);
    qdot_ = (q_ - before) / test::kPeriod;
    ++tick_;
  }
  [[nodiscard]] Time now() const { return At(1.0 + tick_ * test::kPeriod); }
  [[nodiscard]] JointState Joints() const { return {now(), q_, qdot_}; }
  [[nodiscard]] CameraPose Pose() const { return {now(), X_WC_}; }
  [[nodiscard]] bool ImageDue() const { return tick_ % 10 == 0; }
  [[nodiscard]] ImageFeatures Image() const {
    ImageFeatures image;
    image.stamp = image.exposure = now();
    image.X_WC = X_WC_;
    const Isometry3d X_CE = X_WC_.inverse() * EndEffectorPose(view_.arm, q_);
    for (const Marker& marker : view_.markers) {
      const auto point = Project(X_CE * marker.p);
      MarkerMeasurement& m = image.markers[image.count++];
      m.id = marker.id;
      m.valid = point.has_value();
      if (point) m.pixel = ToPixel(view_.camera, point->n);
    }
    return image;
  }
  [[nodiscard]] const JointVector& q() const { return q_; }

  static constexpr double kSlowness = 0.05;  // [s].
  Takes takes{Takes::kVelocities};

 private:
  ViewModel view_;
  JointVector q_, qdot_;
  JointCommand command_;
  Isometry3d X_WC_{test::LookFrom({1.2, -1.5, 1.0})};
  int tick_{0};
};

// From this camera one pixel hides 18 mm along the line of sight.
ServoOptions Options(double max_mm_per_px = 25.0) {
  ServoOptions options;
  options.convergence.max_mm_per_px = max_mm_per_px;
  return options;
}

Servo MakeServo(const ViewModel& view, const JointVector& q_goal,
                const ServoOptions& options = Options()) {
  ServoTask task{view, {}};
  task.goal.p_WG = test::MarkersAt(view, q_goal);
  return {task, options, TriggerOptions()};
}

const JointVector kStart = test::Joints({-0.3, 0.5, -0.9});
const JointVector kGoal = test::Joints({0.3, 0.8, -1.3});

struct Session {
  ViewModel view = test::PumaView();
  Cell cell{view, kStart};
  Servo servo = MakeServo(view, kGoal);
  Isometry3d X_WC = test::LookFrom({1.2, -1.5, 1.0});

  void Feed() {
    servo.Accept(cell.Joints(), cell.now());
    servo.Accept(cell.Pose(), cell.now());
    if (cell.ImageDue()) servo.Accept(cell.Image(), cell.now());
  }
  const ServoOutput& Tick() {
    Feed();
    const ServoOutput& out = servo.Step(cell.now());
    cell.Advance(out.command, X_WC);
    return out;
  }
  void For(double seconds) {
    for (int i = 0; i < seconds / test::kPeriod; ++i) (void)Tick();
  }
};

TEST(Servo, ConvergesToTheGoal) {
  Session run;
  run.For(6.0);
  const ServoOutput& out = run.Tick();
  EXPECT_EQ(out.status.state, ServoState::kConverged)
      << Name(out.status.state) << " " << Name(out.status.reason) << " "
      << out.observability.mm_per_px << " mm/px";
  EXPECT_LT(out.status.error_px, 0.1);
  EXPECT_TRUE(test::Near(run.cell.q(), kGoal, 2e-3));
}

// The camera flies round while the arm servoes: the error's flow is fed forward, so it still arrives.
TEST(Servo, ConvergesWhileTheCameraMoves) {
  Session run;
  double angle = 0.0;
  double late_error = 0.0;
  for (int i = 0; i < 4000; ++i) {
    angle += 0.25 * test::kPeriod;
    run.X_WC =
        test::LookFrom({0.5 + 1.8 * std::sin(0.4 + angle), -1.8 * std::cos(0.4 + angle), 1.0});
    const ServoOutput& out = run.Tick();
    if (i > 3000) late_error = std::max(late_error, out.status.error_px);
  }
  EXPECT_LT(late_error, 0.5);
  EXPECT_TRUE(test::Near(run.cell.q(), kGoal, 2e-3));
}

TEST(Servo, EveryCommandKeepsTheLimits) {
  Session run;
  JointVector last = JointVector::Zero(3);
  for (int i = 0; i < 2000; ++i) {
    const JointVector qdot = run.Tick().command.qdot;
    for (int j = 0; j < 3; ++j) {
      ASSERT_LE(std::abs(qdot(j)), 1.5 + 1e-12);
      ASSERT_LE(std::abs(qdot(j) - last(j)), 8.0 * test::kPeriod + 1e-12);
    }
    last = qdot;
  }
}

// A busy machine misses every third period of a long and slow motion. The position command stays with the arm,
// whichever of the two commands the arm takes, and neither runs ahead of what the arm can have done nor jumps back.
TEST(Servo, MissedPeriodsDoNotPartTheCommandFromTheArm) {
  for (const Takes takes : {Takes::kVelocities, Takes::kPositions, Takes::kPositionsSlowly}) {
    SCOPED_TRACE(static_cast<int>(takes));
    Session run;
    run.cell.takes = takes;
    constexpr double kSlow = 0.15;  // [rad/s]
    std::vector<JointLimits> limits = run.view.arm.limits();
    for (JointLimits& limit : limits) limit.velocity = kSlow;
    run.view.arm = run.view.arm.WithLimits(limits);
    run.servo = MakeServo(run.view, kGoal);
    const double periods = takes == Takes::kPositions ? 1.0 : 2.0;
    const double lag = takes == Takes::kPositionsSlowly ? 2.0 * Cell::kSlowness : 0.0;
    const double step = periods * kSlow * test::kPeriod + 1e-12;
    JointVector last = kStart;
    double apart = 0.0;
    ServoOutput out;
    for (int i = 0; i < 4000; ++i) {
      out = run.Tick();
      ASSERT_NE(out.status.state, ServoState::kFault) << "after " << i;
      apart = std::max(apart, (out.command.q - run.cell.q()).lpNorm<Eigen::Infinity>());
      const JointVector moved = out.command.q - last;
      ASSERT_LE(moved.lpNorm<Eigen::Infinity>(), step) << "after " << i;
      if (!out.command.qdot.isZero(0.0)) {
        ASSERT_GE(moved.cwiseProduct(out.command.qdot).minCoeff(), -1e-12) << "after " << i;
      }
      last = out.command.q;
      if (i % 2 == 1) {
        run.cell.GoOn();
        run.Feed();
      }
    }
    EXPECT_LE(apart, step + lag * kSlow);
    EXPECT_EQ(out.status.state, ServoState::kConverged);
    EXPECT_TRUE(test::Near(run.cell.q(), kGoal, 2e-3));
  }
}

TEST(Servo, WaitsForItsInputsAndNamesTheMissingOne) {
  Session run;
  EXPECT_EQ(run.servo.Step(run.cell.now()).status.reason, HoldReason::kNoJointState);
  run.servo.Accept(run.cell.Joints(), run.cell.now());
  EXPECT_EQ(run.servo.Step(run.cell.now()).status.reason, HoldReason::kNoCameraPose);
  run.servo.Accept(run.cell.Pose(), run.cell.now());
  EXPECT_EQ(run.servo.Step(run.cell.now()).status.reason, HoldReason::kNoFeatures);
  EXPECT_EQ(run.servo.Step(run.cell.now()).status.state, ServoState::kAcquiring);
  run.servo.Accept(run.cell.Image(), run.cell.now());
  EXPECT_EQ(run.servo.Step(run.cell.now()).status.state, ServoState::kServoing);
}

enum class Input { kJoints, kPose, kImage };

// One input stops: the servo holds within its limit, ramps down, says why, and resumes when it returns.
void LoseInput(Input lost, HoldReason expected) {
  Session run;
  run.For(0.4);
  const double before = run.Tick().command.qdot.norm();
  ASSERT_GT(before, 0.05);
  ServoOutput out;
  for (int i = 0; i < 300; ++i) {
    if (lost != Input::kJoints) run.servo.Accept(run.cell.Joints(), run.cell.now());
    if (lost != Input::kPose) run.servo.Accept(run.cell.Pose(), run.cell.now());
    if (lost != Input::kImage && run.cell.ImageDue())
      run.servo.Accept(run.cell.Image(), run.cell.now());
    const JointVector last = out.command.qdot;
    out = run.servo.Step(run.cell.now());
    if (last.size() == 3) {
      ASSERT_LE((out.command.qdot - last).lpNorm<Eigen::Infinity>(), 8.0 * test::kPeriod + 1e-12);
    }
    run.cell.Advance(out.command, run.X_WC);
  }
  EXPECT_EQ(out.status.state, ServoState::kHolding);
  EXPECT_EQ(out.status.reason, expected) << Name(out.status.reason);
  EXPECT_TRUE(out.command.qdot.isZero(0.0));
  EXPECT_EQ(out.status.stops, 1);
  EXPECT_EQ(DescribeStops(out.status), std::string("1 ") + Name(expected));
  run.For(0.1);
  EXPECT_EQ(run.Tick().status.state, ServoState::kServoing);
}

TEST(Servo, HoldsOnStaleJoints) {
  LoseInput(Input::kJoints, HoldReason::kStaleJointState);
}
TEST(Servo, HoldsOnStaleCameraPose) {
  LoseInput(Input::kPose, HoldReason::kStaleCameraPose);
}
TEST(Servo, HoldsOnStaleFeatures) {
  LoseInput(Input::kImage, HoldReason::kStaleFeatures);
}

// A marker that goes missing is carried on by the model for a moment; then the servo holds, and goes on
// when it is back.
TEST(Servo, CarriesALostMarkerForAMomentThenHoldsAndResumes) {
  Session run;
  run.For(0.3);
  double lost_for = 0.0;
  double held_after = 0.0;
  for (int i = 0; i < 200; ++i) {
    run.servo.Accept(run.cell.Joints(), run.cell.now());
    run.servo.Accept(run.cell.Pose(), run.cell.now());
    if (run.cell.ImageDue()) {
      ImageFeatures blind = run.cell.Image();
      blind.markers[0].valid = false;
      ASSERT_TRUE(run.servo.Accept(blind, run.cell.now()));
    }
    const ServoOutput& out = run.servo.Step(run.cell.now());
    run.cell.Advance(out.command, run.X_WC);
    lost_for += test::kPeriod;
    if (held_after == 0.0 && out.status.state == ServoState::kHolding) {
      held_after = lost_for;
      EXPECT_EQ(out.status.reason, HoldReason::kTooFewFeatures);
      EXPECT_EQ(out.status.markers_seen, 1);
    }
  }
  EXPECT_NEAR(held_after, ServoOptions().staleness.marker, 0.025);
  run.For(0.1);
  EXPECT_EQ(run.Tick().status.state, ServoState::kServoing);
}

TEST(Servo, RefusesBadInputsOneByOne) {
  Session run;
  run.For(0.1);
  run.Feed();
  const Time now = run.cell.now();
  const Time next = now + FromSeconds(0.001);
  const double nan = std::numeric_limits<double>::quiet_NaN();

  JointState joints = run.cell.Joints();
  joints.stamp = next;
  joints.q(1) = nan;
  EXPECT_FALSE(run.servo.Accept(joints, next)) << "NaN position";
  joints = run.cell.Joints();
  joints.stamp = next;
  joints.qdot(1) = nan;
  EXPECT_FALSE(run.servo.Accept(joints, next)) << "NaN velocity";
  joints = run.cell.Joints();
  joints.stamp = now - FromSeconds(0.01);
  EXPECT_FALSE(run.servo.Accept(joints, next)) << "reordered";
  joints.stamp = now + FromSeconds(10.0);
  EXPECT_FALSE(run.servo.Accept(joints, next)) << "from the future";
  joints.stamp = next;
  joints.q = JointVector::Zero(4);
  EXPECT_FALSE(run.servo.Accept(joints, next)) << "one joint too many";

  CameraPose pose = run.cell.Pose();
  pose.stamp = next;
  pose.X_WC.linear() *= 1.1;
  EXPECT_FALSE(run.servo.Accept(pose, next)) << "not a rotation";

  ImageFeatures image = run.cell.Image();
  image.exposure = next;
  image.markers[0].pixel.x() = nan;
  EXPECT_FALSE(run.servo.Accept(image, next)) << "NaN pixel";
  image = run.cell.Image();
  image.exposure = next;
  image.count = kMaxMarkers + 1;
  EXPECT_FALSE(run.servo.Accept(image, next)) << "too many markers";
  const ServoStatus& status = run.servo.Step(next).status;
  EXPECT_EQ(status.refused_messages, 8);
  EXPECT_EQ(DescribeRefused(status),
            "2 WRONG_SIZE, 3 NOT_FINITE, 1 OUT_OF_RANGE, 1 REORDERED, 1 FUTURE");
}

TEST(Servo, TheOperatorStopsIt) {
  Session run;
  run.For(0.3);
  run.servo.SetEnabled(false);
  run.For(0.5);
  const ServoOutput& out = run.Tick();
  EXPECT_EQ(out.status.state, ServoState::kIdle);
  EXPECT_EQ(out.status.reason, HoldReason::kOperator);
  EXPECT_TRUE(out.command.qdot.isZero(0.0));
}

// A view that hides the error must not be called success, however small the error in the image.
TEST(Servo, DoesNotCertifyAGrazingView) {
  Session run;
  run.servo = MakeServo(run.view, kGoal, Options(10.0));
  run.For(6.0);
  const ServoOutput& out = run.Tick();
  EXPECT_LT(out.status.error_px, 0.1);
  EXPECT_NE(out.status.state, ServoState::kConverged);
  EXPECT_GT(out.observability.mm_per_px, 10.0);
  EXPECT_TRUE(run.servo.snapshot().active.stalled);
}

// A whole period with a new image, from messages to command: 10 allocations for each of two points, the same
// for their goals while the camera moves; none with closed forms.
TEST(Servo, AllocatesNothingButViSPsMatrices) {
  if (!test::AllocationGuard::kSupported) GTEST_SKIP();
  for (const auto source : {InteractionSource::kVisp, InteractionSource::kClosedForm}) {
    for (const bool camera_moves : {false, true}) {
      Session run;
      ServoOptions options = Options();
      options.interaction = source;
      run.servo = MakeServo(run.view, kGoal, options);
      for (int i = 0; i < 200 || !run.cell.ImageDue(); ++i) {
        if (camera_moves) run.X_WC = test::LookFrom({1.2, -1.5 + 1e-4 * i, 1.0});
        (void)run.Tick();
      }
      const test::AllocationGuard guard;
      run.Feed();
      const ServoOutput& out = run.servo.Step(run.cell.now());
      const std::size_t matrices = camera_moves ? 4 : 2;
      EXPECT_EQ(guard.count(), source == InteractionSource::kVisp ? 10 * matrices : 0u);
      EXPECT_EQ(out.status.state, ServoState::kServoing);
    }
  }
}

// A rehearsal on a copy goes through a whole period and allocates nothing, and the servo does not notice.
TEST(Servo, IsRehearsedOnACopy) {
  if (!test::AllocationGuard::kSupported) GTEST_SKIP();
  Session run, alone;
  ServoOptions options = Options();
  options.interaction = InteractionSource::kClosedForm;
  run.servo = MakeServo(run.view, kGoal, options);
  alone.servo = MakeServo(alone.view, kGoal, options);
  Servo understudy = run.servo;
  understudy.Rehearse(run.cell.now());  // nothing has come in
  EXPECT_EQ(understudy.Step(run.cell.now()).status.reason, HoldReason::kNoJointState);
  for (int i = 0; i < 100; ++i) {
    const ServoOutput& out = run.Tick();
    const test::AllocationGuard guard;
    understudy = run.servo;
    understudy.Rehearse(run.cell.now());
    EXPECT_EQ(guard.count(), 0U);
    EXPECT_EQ(out.command.qdot, alone.Tick().command.qdot);
  }
  EXPECT_EQ(understudy.snapshot().active.now, run.cell.now());
  EXPECT_EQ(understudy.Step(run.cell.now()).status.refused_messages, 0);
}

// However it is come by, w_v is that of J_v.
TEST(Servo, ReportsTheMeasuresOfItsJacobians) {
  Session run;
  for (int i = 0; i < 20; ++i) {
    run.For(0.1);
    const ServoOutput& out = run.Tick();
    const TaskJacobian J_c = out.J_v * out.J_r;
    ObservabilityReport report = out.observability;
    CompleteReport(out.J_v, out.J_r, &report);
    EXPECT_NEAR(report.w_v, MeasureOf(out.J_v).w, 1e-9 * report.w_v);
    EXPECT_NEAR(report.w_r, MeasureOf(out.J_r).w, 1e-9 * report.w_r);
    EXPECT_NEAR(report.w_c, MeasureOf(J_c).w, 1e-9 * report.w_c);
    EXPECT_EQ(report.sigma_min_v, MeasureOf(out.J_v).sigma_min);
    EXPECT_EQ(report.sigma_min_r, MeasureOf(out.J_r).sigma_min);
  }
}

// Five joints, three dots, six features. The dots in `hidden` are not in the images.
ServoOutput RunWithHidden(const std::vector<int>& hidden, double seconds, double hidden_marker) {
  ViewModel view{test::PumaArm(5), CameraModel(), FeatureSet::AllPoints(3), {}};
  view.markers = {{0, {0.0, 0.0, 0.1}}, {1, {0.1, 0.0, 0.1}}, {2, {0.0, 0.1, 0.1}}};
  const JointVector q = test::Joints({-0.3, 0.5, -0.9, 0.2, 0.1});
  Cell cell(view, q);
  ServoOptions options = Options();
  options.convergence.max_mm_per_px = 1e3;
  options.staleness.hidden_marker = hidden_marker;
  Servo servo = MakeServo(view, q + test::Joints({0.3, 0.2, -0.2, 0.2, 0.3}), options);
  const Isometry3d X_WC = test::LookFrom({1.2, -1.5, 1.0});
  ServoOutput last;
  for (int i = 0; i < (0.2 + seconds) / test::kPeriod; ++i) {
    servo.Accept(cell.Joints(), cell.now());
    servo.Accept(cell.Pose(), cell.now());
    if (cell.ImageDue()) {
      ImageFeatures image = cell.Image();
      for (const int id : hidden) {
        if (i * test::kPeriod > 0.2) image.markers[static_cast<std::size_t>(id)].valid = false;
      }
      servo.Accept(image, cell.now());
    }
    last = servo.Step(cell.now());
    cell.Advance(last.command, X_WC);
  }
  return last;
}

// Two dots that are seen confirm where the model puts the third, for a while; one does not, and what is hidden
// for good stops the arm.
TEST(Servo, HiddenMarkersAreCarriedWhileOthersConfirmTheModel) {
  const ServoOutput carried = RunWithHidden({1}, 1.5, 5.0);
  EXPECT_EQ(carried.status.state, ServoState::kServoing) << Name(carried.status.reason);
  EXPECT_EQ(carried.status.markers_seen, 2);
  EXPECT_EQ(carried.error.size(), 6);
  EXPECT_EQ(RunWithHidden({1}, 6.0, 5.0).status.reason, HoldReason::kTooFewFeatures);
  EXPECT_EQ(RunWithHidden({1}, 1.5, 0.0).status.reason, HoldReason::kTooFewFeatures);
  EXPECT_EQ(RunWithHidden({1, 2}, 1.5, 5.0).status.reason, HoldReason::kTooFewFeatures);
}

// Nobody calls a task done while a marker is hidden, however small the error by the model.
TEST(Servo, DoesNotConvergeOnHiddenMarkers) {
  EXPECT_NE(RunWithHidden({1}, 12.0, 60.0).status.state, ServoState::kConverged);
  EXPECT_EQ(RunWithHidden({}, 12.0, 60.0).status.state, ServoState::kConverged);
}

ServoTask MakeTask() {
  ServoTask task{test::PumaView(), {}};
  task.goal.p_WG = test::MarkersAt(task.view, kGoal);
  return task;
}

// A zero that is off by half a degree is looked for among the joints of its kind.
TEST(Servo, TellsWhichKindOfEncoderIsOff) {
  Session run;
  for (int i = 0; i < 2000; ++i) {
    JointState joints = run.cell.Joints();
    joints.q(1) += 0.01;
    run.servo.Accept(joints, run.cell.now());
    run.servo.Accept(run.cell.Pose(), run.cell.now());
    if (run.cell.ImageDue()) run.servo.Accept(run.cell.Image(), run.cell.now());
    run.cell.Advance(run.servo.Step(run.cell.now()).command, run.X_WC);
  }
  const CalibrationFound& found = run.Tick().status.calibration;
  EXPECT_GT(found.revolute, 0.001);
  EXPECT_LT(found.revolute, 0.02);
  EXPECT_EQ(found.prismatic, 0.0);
}

TEST(ServoReport, DescribesWhatIsOffOfTheCalibration) {
  const std::string camera = "camera off by 3.1 mm and 0.42 deg, focal length by -0.50 %, ";
  EXPECT_EQ(Describe(CalibrationFound{0.0031, 0.0073, -0.005, 0.0054, 0.0}),
            camera + "encoders by up to 0.31 deg");
  EXPECT_EQ(Describe(CalibrationFound{0.0031, 0.0073, -0.005, 0.0, 0.0012}),
            camera + "encoders by up to 1.2 mm");
  EXPECT_EQ(Describe(CalibrationFound{0.0031, 0.0073, -0.005, 0.0054, 0.0012}),
            camera + "encoders by up to 0.31 deg and 1.2 mm");
}

// What the headers ask of options and goal is asked when a servo is made, with the key.
TEST(Servo, RefusesOptionsOutOfTheirBounds) {
  const ServoTask task = MakeTask();
  EXPECT_NO_THROW(Servo(task, ServoOptions(), TriggerOptions()));
  const std::map<std::string, std::function<void(ServoOptions*)>> causes{
      {"servo.period", [](ServoOptions* o) { o->period = 0.0; }},
      {"servo.gain_at_zero", [](ServoOptions* o) { o->law.gain_at_zero = 0.0; }},
      {"servo.damping", [](ServoOptions* o) { o->law.damping = -1.0; }},
      {"servo.self_motion", [](ServoOptions* o) { o->law.self_motion = 1.5; }},
      {"servo.path.reach", [](ServoOptions* o) { o->path.reach = 0.0; }},
      {"servo.staleness.features", [](ServoOptions* o) { o->staleness.features = -1.0; }},
      {"servo.convergence.tolerance_mm",
       [](ServoOptions* o) { o->convergence.tolerance_mm = 0.0; }},
      {"servo.stall_time", [](ServoOptions* o) { o->stall_time = std::nan(""); }},
      {"servo.calibration.rotation", [](ServoOptions* o) { o->calibration.rotation = -0.1; }}};
  for (const auto& [key, spoil] : causes) {
    ServoOptions options;
    spoil(&options);
    try {
      const Servo servo(task, options, TriggerOptions());
      ADD_FAILURE() << key << " is let in";
    } catch (const ConfigError& error) {
      EXPECT_EQ(error.key(), key) << error.what();
    }
  }
}

TEST(Servo, RefusesGoalMarkersWithoutNormals) {
  ServoTask task = MakeTask();
  for (std::size_t i = 0; i < task.goal.p_WG.size(); ++i) {
    task.goal.marker_ids.push_back(static_cast<int>(10 + i));
  }
  task.goal.normals.clear();
  EXPECT_THROW(Servo(task, ServoOptions(), TriggerOptions()), ConfigError);
  task.goal.normals.assign(task.goal.p_WG.size(), Eigen::Vector3d(0.0, 0.0, 2.0));
  EXPECT_THROW(Servo(task, ServoOptions(), TriggerOptions()), ConfigError);
  task.goal.normals.assign(task.goal.p_WG.size(), Eigen::Vector3d::UnitZ());
  EXPECT_NO_THROW(Servo(task, ServoOptions(), TriggerOptions()));
}

}  // namespace
}  // namespace vantage
