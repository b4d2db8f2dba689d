#include "vantage/servo/servo.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "vantage/math/error.h"

namespace vantage {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// A stamp this far ahead of our clock cannot be true.
constexpr Duration kFutureTolerance = std::chrono::milliseconds(5);
// State is carried forward by the model for at most this long [s].
constexpr double kMaxExtrapolation = 0.05;
// Time over which the camera's twist is read off its measured poses.
constexpr Duration kTwistWindow = std::chrono::milliseconds(50);
// A smaller error by this factor is progress.
constexpr double kProgress = 0.95;

JointVector Between(const JointVector& a, const JointVector& b, double fraction) {
  return a + fraction * (b - a);
}

Isometry3d PoseBetween(const Isometry3d& a, const Isometry3d& b, double fraction) {
  return Advance(a, fraction * Displacement(a, b));
}

Vector2d Pixel(const CameraModel& camera, const Vector2d& n) {
  return CalibrationJacobian(camera) * n + Vector2d(camera.u0, camera.v0);
}

Vector2d Normalised(const CameraModel& camera, const Vector2d& pixel) {
  const double y = (pixel.y() - camera.v0) / camera.fy;
  return {(pixel.x() - camera.u0 - camera.skew * y) / camera.fx, y};
}

double Age(Time now, Time stamp) {
  return ToSeconds(now - stamp);
}

void KeepCommonRows(FeatureRows* a, FeatureRows* b) {
  int kept = 0;
  int j = 0;
  for (int i = 0; i < a->size(); ++i) {
    while (j < b->size() && b->feature[j] < a->feature[i]) ++j;
    if (j == b->size() || b->feature[j] != a->feature[i]) continue;
    for (FeatureRows* rows : {a, b}) {
      const int from = rows == a ? i : j;
      rows->s(kept) = rows->s(from);
      rows->L.row(kept) = rows->L.row(from);
      rows->L_body.row(kept) = rows->L_body.row(from);
      rows->feature[kept] = rows->feature[from];
    }
    ++kept;
  }
  for (FeatureRows* rows : {a, b}) {
    rows->s.conservativeResize(kept);
    rows->L.conservativeResize(kept, 6);
    rows->L_body.conservativeResize(kept, 6);
  }
}

void CheckSizes(const ServoTask& task, const ServoOptions& options) {
  const std::size_t count = task.view.markers.size();
  const auto fail = [](const char* key, const std::string& reason) {
    throw ConfigError("", key, reason);
  };
  if (count == 0 || count > kMaxPoints) {
    fail("markers",
         "needs 1 to " + std::to_string(kMaxPoints) + " markers, has " + std::to_string(count));
  }
  if (task.view.features.num_points() != static_cast<int>(count)) {
    fail("features", "are over " + std::to_string(task.view.features.num_points()) +
                         " points, markers are " + std::to_string(count));
  }
  if (task.goal.p_WG.size() != count) fail("goal", "needs one point for each marker");
  if (!task.goal.marker_ids.empty() && task.goal.marker_ids.size() != count) {
    fail("goal", "needs one marker id for each marker, or none");
  }
  if (!(task.goal.prior_sigma > 0.0)) fail("goal.prior_sigma", "must be > 0 m");
  if (!(options.period >= 0.0005 && options.period <= 0.1)) {
    fail("servo.period", "must be in [0.0005, 0.1] s, is " + std::to_string(options.period));
  }
}

}  // namespace

Servo::Servo(ServoTask task, const ServoOptions& options, const TriggerOptions& trigger)
    : task_(std::move(task)), options_(options), trigger_(trigger) {
  CheckSizes(task_, options_);
  const std::size_t count = task_.view.markers.size();
  needed_.assign(count, false);
  for (const Feature& feature : task_.view.features.features()) {
    for (const int point : feature.points) needed_[static_cast<std::size_t>(point)] = true;
  }
  markers_needed_ = static_cast<int>(std::count(needed_.begin(), needed_.end(), true));
  for (const Vector3d& p_WG : task_.goal.p_WG) goal_.emplace_back(p_WG, task_.goal.prior_sigma);
  goal_offset_.fill(Vector2d::Zero());
  point_jacobians_.resize(count);
  current_.resize(count);
  wanted_.resize(count);
  const int n = task_.view.arm.size();
  qdot_ = JointVector::Zero(n);
  q_ = JointVector::Zero(n);
  output_.command.qdot = qdot_;
  output_.command.q = q_;
  output_.status.markers_needed = markers_needed_;
  snapshot_.goal_count = static_cast<int>(count);
}

bool Servo::Accept(const JointState& state, Time now) noexcept {
  const int n = task_.view.arm.size();
  const bool good = state.q.size() == n && state.qdot.size() == n && state.q.allFinite() &&
                    state.qdot.allFinite() && state.stamp <= now + kFutureTolerance;
  const bool first = joints_.empty();
  if (!good || !joints_.Push(state.stamp, state.q)) {
    ++output_.status.refused_messages;
    return false;
  }
  if (first) {
    // The arm may be moving already (a restart): the first commands ramp from what it does.
    qdot_ = state.qdot;
    output_.command.q = state.q;
  }
  return true;
}

bool Servo::Accept(const CameraPose& pose, Time now) noexcept {
  if (!IsPose(pose.X_WC) || pose.stamp > now + kFutureTolerance ||
      !poses_.Push(pose.stamp, pose.X_WC)) {
    ++output_.status.refused_messages;
    return false;
  }
  return true;
}

bool Servo::Accept(const ImageFeatures& features, Time now) noexcept {
  bool good = features.count >= 0 && features.count <= kMaxMarkers && IsPose(features.X_WC) &&
              features.exposure <= now + kFutureTolerance &&
              (!has_features_ || features.exposure > features_.exposure);
  for (int i = 0; good && i < features.count; ++i) {
    good = !features.markers[i].valid || features.markers[i].pixel.allFinite();
  }
  if (!good) {
    ++output_.status.refused_messages;
    return false;
  }
  features_ = features;
  has_features_ = true;
  image_is_new_ = true;
  return true;
}

void Servo::Accept(const ActiveOutput& active) noexcept {
  active_ = active;
}

HoldReason Servo::CheckInputs(Time now) const noexcept {
  const StalenessLimits& limits = options_.staleness;
  if (joints_.empty()) return HoldReason::kNoJointState;
  if (Age(now, joints_.newest_stamp()) > limits.joint_state) return HoldReason::kStaleJointState;
  if (poses_.empty()) return HoldReason::kNoCameraPose;
  if (Age(now, poses_.newest_stamp()) > limits.camera_pose) return HoldReason::kStaleCameraPose;
  if (!has_features_) return HoldReason::kNoFeatures;
  if (Age(now, features_.exposure) > limits.features) return HoldReason::kStaleFeatures;
  return HoldReason::kNone;
}

Twist Servo::CameraTwist() const noexcept {
  if (poses_.size() < 2) return Twist::Zero();
  // A pose is measured only when it changes or at the rig's own rate: the window may hold one value.
  const Time end = poses_.newest_stamp();
  const auto X_before = poses_.At(end - kTwistWindow, PoseBetween);
  return Displacement(*X_before, poses_.newest()) / ToSeconds(kTwistWindow);
}

void Servo::PredictState(Time now, const Twist& V_WC_C) noexcept {
  const double joint_age = std::clamp(Age(now, joints_.newest_stamp()), 0.0, kMaxExtrapolation);
  const double pose_age = std::clamp(Age(now, poses_.newest_stamp()), 0.0, kMaxExtrapolation);
  q_ = joints_.newest() + joint_age * qdot_;
  X_WC_ = Advance(poses_.newest(), pose_age * V_WC_C);
  kinematics_ = ComputeKinematics(task_.view.arm, q_);
}

// Compares the newest image with the model at its exposure. What differs is carried to now: that
// bridges the latency and the time between two images.
void Servo::UseImage() noexcept {
  const CameraModel& camera = task_.view.camera;
  const JointVector q = *joints_.At(features_.exposure, Between);
  const Isometry3d X_CE = features_.X_WC.inverse() * EndEffectorPose(task_.view.arm, q);
  markers_lost_ = 0;
  for (std::size_t i = 0; i < task_.view.markers.size(); ++i) {
    const Marker& marker = task_.view.markers[i];
    const MarkerMeasurement* measured = features_.Find(marker.id);
    const auto expected = Project(X_CE * marker.p);
    if (measured != nullptr && measured->valid && expected) {
      offset_[i] = measured->pixel - Pixel(camera, expected->n);
      last_seen_[i] = features_.exposure;
    } else if (needed_[i]) {
      ++markers_lost_;
    }
  }
  for (std::size_t i = 0; i < task_.goal.marker_ids.size(); ++i) {
    const MarkerMeasurement* measured = features_.Find(task_.goal.marker_ids[i]);
    if (measured == nullptr || !measured->valid) continue;
    goal_[i].Update(camera, features_.X_WC, measured->pixel, GoalSigma());
    // The estimate gives the depth; where the goal is in the image, the image says best. An error of the
    // camera's pose shifts goal and arm alike, and so leaves the difference of the two.
    const auto seen_at = Project(features_.X_WC.inverse() * goal_[i].p_WG());
    if (seen_at) goal_offset_[i] = measured->pixel - Pixel(camera, seen_at->n);
  }
  image_is_new_ = false;
}

double Servo::GoalSigma() const noexcept {
  return std::hypot(options_.feature_noise_px, options_.calibration_px);
}

bool Servo::Carried(std::size_t marker) const noexcept {
  return last_seen_[marker] &&
         Age(features_.exposure, *last_seen_[marker]) <= options_.staleness.marker;
}

HoldReason Servo::PredictRows() noexcept {
  const CameraModel& camera = task_.view.camera;
  const Isometry3d X_CW = X_WC_.inverse();
  const Isometry3d X_CE = X_CW * kinematics_.X_WE;
  bool behind = false;
  for (std::size_t i = 0; i < current_.size(); ++i) {
    const auto now = Project(X_CE * task_.view.markers[i].p);
    const auto goal = Project(X_CW * (goal_[i].p_WG() + task_.goal.offset_W));
    if (needed_[i] && (!now || !goal)) behind = true;
    const bool usable = Carried(i) && now && goal;
    current_[i].visible = wanted_[i].visible = usable;
    if (!usable) continue;
    current_[i].image = {Normalised(camera, Pixel(camera, now->n) + offset_[i]), now->depth};
    wanted_[i].image = {Normalised(camera, Pixel(camera, goal->n) + goal_offset_[i]), goal->depth};
    // The goal's points stand in the world; the end effector's are on the body.
    wanted_[i].on_body = false;
  }
  task_.view.features.Evaluate(camera, current_, &current_rows_);
  task_.view.features.Evaluate(camera, wanted_, &goal_rows_);
  KeepCommonRows(&current_rows_, &goal_rows_);
  if (current_rows_.size() < RowsNeeded()) {
    return behind ? HoldReason::kPointBehindCamera : HoldReason::kTooFewFeatures;
  }
  return HoldReason::kNone;
}

HoldReason Servo::Control(Time now, const Twist& V_WC_C) noexcept {
  const FeatureJacobian J_v =
      ImageJacobian(current_rows_.L_body, X_WC_, kinematics_.X_WE.translation());
  const TaskJacobian J_c = J_v * kinematics_.J_WE_W;
  output_.error = FeatureError(task_.view.features, current_rows_, goal_rows_);
  const SingularSystem system = Decompose(J_c);
  if (system.measure.status != MeasureStatus::kOk || !output_.error.allFinite()) {
    return HoldReason::kNotFinite;
  }
  output_.status.error_px =
      std::sqrt(output_.error.squaredNorm() / static_cast<double>(output_.error.size()));
  ReportMeasures(J_v, system);

  // Flow of the error under the camera's own motion: that of the features less that of their goals.
  const FeatureVector e_rate = (current_rows_.L - goal_rows_.L) * V_WC_C;
  const auto& limits = task_.view.arm.limits();
  const ServoLawResult law = ServoLaw(options_.law, output_.error, J_c, system, e_rate,
                                      ComputeVelocityBounds(limits, q_, qdot_, dt_));
  if (!law.finite) return HoldReason::kNotFinite;
  Command(now, law.qdot);
  return HoldReason::kNone;
}

void Servo::ReportMeasures(const FeatureJacobian& J_v, const SingularSystem& system) noexcept {
  const ViewModel& view = task_.view;
  const ArmJacobian& J_r = kinematics_.J_WE_W;
  const Measure observability = MeasureOf(J_v);
  const Measure manipulability = MeasureOf(J_r);
  ObservabilityReport& report = output_.observability;
  report.k = static_cast<int>(J_v.rows());
  report.n = static_cast<int>(J_r.cols());
  report.composite = system.measure;
  report.axes = system.axes;
  report.w_v = observability.w;
  report.w_r = manipulability.w;
  report.w_c = system.measure.w;
  report.sigma_min_v = observability.sigma_min;
  report.sigma_min_r = manipulability.sigma_min;
  for (std::size_t i = 0; i < view.markers.size(); ++i) {
    point_jacobians_[i] = PointJacobianOf(J_r, kinematics_.X_WE.linear() * view.markers[i].p);
  }
  report.mm_per_px = WorstMillimetresPerPixel(system, point_jacobians_);
  report.trigger_measure = trigger_.measure;
  report.threshold = trigger_.threshold;
  report.trigger_value = TriggerValue(trigger_.measure, system.measure);
  report.cause = DiagnoseLowMeasure(system, point_jacobians_, RowsNeeded(),
                                    report.trigger_value < trigger_.threshold);
}

int Servo::RowsNeeded() const noexcept {
  return std::min({static_cast<int>(task_.view.features.features().size()), task_.view.arm.size(),
                   kTaskDimension});
}

// Converged: small error for the settling time in a view that certifies it. Stalled: an error that no
// longer falls, or a small one in a view that hides too much.
void Servo::JudgeProgress(Time now) noexcept {
  const ConvergenceOptions& goal = options_.convergence;
  const double error = output_.status.error_px;
  const bool certified = output_.observability.mm_per_px <= goal.max_mm_per_px;
  const bool complete = markers_lost_ == 0;
  // A camera on its way to a better view will see better still: no verdict before it is there.
  const bool moving = active_.state == ActiveState::kMoving;
  if (error > goal.tolerance_px || !complete || moving) {
    below_since_.reset();
  } else if (!below_since_) {
    below_since_ = now;
  }
  if (!best_since_ || error < kProgress * best_error_ || moving) {
    best_error_ = error;
    best_since_ = now;
  }
  const bool settled = below_since_ && Age(now, *below_since_) >= goal.settle_time;
  const bool stands = Age(now, *best_since_) > options_.stall_time;
  stalled_ = (settled && !certified) || (stands && error > goal.tolerance_px);
  output_.status.reason = HoldReason::kNone;
  if (settled && certified) {
    output_.status.state = ServoState::kConverged;
  } else {
    output_.status.state = moving ? ServoState::kRepositioning : ServoState::kServoing;
  }
}

void Servo::Command(Time now, const JointVector& qdot) noexcept {
  qdot_ = qdot;
  output_.command.stamp = now;
  output_.command.qdot = qdot;
  // At rest the position command follows the arm, so that it never jumps when motion resumes.
  output_.command.q = qdot.isZero(0.0) && !joints_.empty()
                          ? joints_.newest()
                          : JointVector(output_.command.q + dt_ * qdot);
}

const ServoOutput& Servo::Step(Time now) noexcept {
  ServoStatus& status = output_.status;
  const ServoState before = status.state;
  ++status.seq;
  status.stamp = now;
  output_.error.resize(0);
  // A period that starts early, after a late one, must not use up a whole period's acceleration.
  dt_ = last_step_ == Time{} ? options_.period
                             : std::clamp(Age(now, last_step_), 0.0, options_.period);
  last_step_ = now;

  HoldReason reason = enabled_ ? CheckInputs(now) : HoldReason::kOperator;
  if (reason == HoldReason::kNone) {
    if (image_is_new_) UseImage();
    const Twist V_WC_C = CameraTwist();
    PredictState(now, V_WC_C);
    snapshot_.valid = true;
    reason = PredictRows();
    if (reason == HoldReason::kNone) reason = Control(now, V_WC_C);
  }
  if (reason == HoldReason::kNone) {
    JudgeProgress(now);
  } else {
    Command(now, RampToRest(task_.view.arm.limits(), qdot_, dt_));
    below_since_.reset();
    best_since_.reset();
    stalled_ = false;
    status.reason = reason;
    const bool waiting = before == ServoState::kIdle || before == ServoState::kAcquiring;
    status.state =
        !enabled_ ? ServoState::kIdle : (waiting ? ServoState::kAcquiring : ServoState::kHolding);
    const bool moved = before == ServoState::kServoing || before == ServoState::kRepositioning ||
                       before == ServoState::kConverged;
    if (moved) ++status.stops;
  }

  ObservabilityReport& report = output_.observability;
  report.stamp = now;
  report.seq = status.seq;
  report.triggered = active_.triggered;
  report.active_state = active_.state;
  report.active_reason = active_.reason;
  report.camera_moves = active_.moves;

  status.markers_seen = has_features_ ? markers_needed_ - markers_lost_ : 0;
  ActiveInputs& view = snapshot_.active;
  view.now = now;
  view.q = q_;
  view.qdot = qdot_;
  view.X_WC = X_WC_;
  view.composite = report.composite;
  view.cause = report.cause;
  view.markers_lost = markers_lost_;
  view.stalled = stalled_;
  view.error_px = status.error_px;
  for (std::size_t i = 0; i < goal_.size(); ++i) {
    snapshot_.p_marker[i] = goal_[i].p_WG();
    snapshot_.p_WG[i] = goal_[i].p_WG() + task_.goal.offset_W;
  }
  return output_;
}

}  // namespace vantage
