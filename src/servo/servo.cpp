#include "vantage/servo/servo.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "vantage/math/error.h"
#include "vantage/math/spatial.h"
#include "vantage/servo/layout_fit.h"

namespace vantage {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// A goal that moves at its greatest speed is off by what it does in this time from one image to the next, if
// its turns are taken for noise [s].
constexpr double kDriftTime = 0.02;
// A stamp this far ahead of our clock cannot be true.
constexpr Duration kFutureTolerance = std::chrono::milliseconds(5);
// State is carried forward by the model for at most this long [s].
constexpr double kMaxExtrapolation = 0.05;
// Time over which the camera's twist is read off its measured poses.
constexpr Duration kTwistWindow = std::chrono::milliseconds(50);
// A goal marker that the last images do not show no longer says where the goal is [s].
constexpr double kGoalMemory = 1.0;
// An image's difference to the model that changes by more than this is no slow change [px].
constexpr double kOffsetJump = 15.0;
// From nearer than this to where it looked from last, a camera sees nothing new of a goal at rest: its
// errors of calibration are the same [m], [rad].
constexpr double kNewViewDistance = 0.03;
constexpr double kNewViewAngle = 0.03;
// How well an arm that stands at its goal in the image knows the depth of the goal's markers: a part for
// the calibration of arm and camera [m], and one for the way from the goal point to its marker [-].
constexpr double kArrivalSigma = 0.01;
constexpr double kArrivalLever = 0.1;
// What the estimate of a goal's marker may be off by for errors of calibration, however many views: at
// least so much [m], and this many times what the image says it is off by across the ray.
constexpr double kEstimateFloor = 0.015;
constexpr double kDepthFactor = 2.0;
// What is left of a single image's noise in where a marker of the goal is on average.
constexpr double kAveragedShare = 0.35;
// Share of a change of that weighing that one image makes.
constexpr double kArrivalBlend = 0.1;
// Slower than this the arm counts as standing [rad/s or m/s]; averages then take this many times longer.
constexpr double kStandingSpeed = 0.1;
constexpr double kStandingAverage = 4.0;
// An arm that stands this many times the tolerance from its goal, and gets no nearer, is there.
constexpr double kReachedShare = 2.0;
// Ahead of now, the goal of a moving target is looked at to know its features' rate [s].
constexpr double kSoon = 0.01;
// An arm that is further from where it was told to be than it goes in this time at its greatest speed does
// not follow [s].
constexpr double kMaxLead = 0.5;
// A joint is at a limit within this share of its range.
constexpr double kAtLimit = 1e-3;
// An arm that is asked for less than this share of its speed stands.
constexpr double kStands = 0.01;
// The calibration is compared with a marker again once that has moved so far before the camera [m], or the
// camera has turned so far [rad]; one such comparison is good to this [px].
constexpr double kCalibrationWay = 0.02;
constexpr double kCalibrationTurn = 0.04;
constexpr double kCalibrationNoise = 0.5;
// So many markers that are seen confirm the model of the body for those that are not.
constexpr int kConfirming = 2;
// A smaller error by this factor is progress.
constexpr double kProgress = 0.95;

JointVector Between(const JointVector& a, const JointVector& b, double fraction) {
  return a + fraction * (b - a);
}

double Age(Time now, Time stamp) {
  return ToSeconds(now - stamp);
}

// The average over about `time` seconds after one more value, `age` seconds after the last one. The value itself
// after a long gap, and where it is off by more than `jump`.
Vector2d Averaged(const Vector2d& average, const Vector2d& measured, double age, double time,
                  double jump) {
  if (age > 3.0 * time || (measured - average).norm() > jump) return measured;
  return average + age / (age + time) * (measured - average);
}

// Matrices of `b` without rows stay so: only its values were asked for.
void KeepCommonRows(FeatureRows* a, FeatureRows* b) {
  if (a->size() == b->size() &&
      std::equal(a->feature.begin(), a->feature.begin() + a->size(), b->feature.begin())) {
    return;
  }
  const bool values_only = b->L.rows() == 0;
  int kept = 0;
  int j = 0;
  for (int i = 0; i < a->size(); ++i) {
    while (j < b->size() && b->feature[j] < a->feature[i]) ++j;
    if (j == b->size() || b->feature[j] != a->feature[i]) continue;
    for (FeatureRows* rows : {a, b}) {
      const int from = rows == a ? i : j;
      rows->s(kept) = rows->s(from);
      rows->feature[kept] = rows->feature[from];
      if (rows == b && values_only) continue;
      rows->L.row(kept) = rows->L.row(from);
      rows->L_body.row(kept) = rows->L_body.row(from);
    }
    ++kept;
  }
  for (FeatureRows* rows : {a, b}) {
    rows->s.conservativeResize(kept);
    if (rows == b && values_only) continue;
    rows->L.conservativeResize(kept, 6);
    rows->L_body.conservativeResize(kept, 6);
  }
}

// J_v J_r, column by column, which is faster than Eigen's product of matrices of bounded size.
TaskJacobian ProductByColumns(const FeatureJacobian& J_v, const ArmJacobian& J_r) noexcept {
  TaskJacobian J_c(J_v.rows(), J_r.cols());
  for (Eigen::Index j = 0; j < J_r.cols(); ++j) {
    const Twist twist = J_r.col(j);
    J_c.col(j) = twist(0) * J_v.col(0) + twist(1) * J_v.col(1) + twist(2) * J_v.col(2) +
                 twist(3) * J_v.col(3) + twist(4) * J_v.col(4) + twist(5) * J_v.col(5);
  }
  return J_c;
}

// w_v. Where features and joints cover the task, w_c = w_v w_r (docs/paper.md), which saves a decomposition;
// not near a singularity, where the quotient loses its digits.
double ObservabilityOf(const FeatureJacobian& J_v, const Measure& composite, const Volume& arm) {
  constexpr double kWellConditioned = 1e-4;
  const bool covered = J_v.rows() >= kTaskDimension && composite.size() == kTaskDimension &&
                       arm.rank == kTaskDimension;
  if (covered && composite.inverse_condition() > kWellConditioned) return composite.w / arm.w;
  return VolumeOf(J_v).w;
}

void Validate(const ServoTask& task) {
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
  if (task.goal.p_WG.size() != count) {
    fail("goal", "needs one point for each of the " + std::to_string(count) + " markers, has " +
                     std::to_string(task.goal.p_WG.size()));
  }
  if (!task.goal.marker_ids.empty() && task.goal.marker_ids.size() != count) {
    fail("goal", "needs one marker id for each of the " + std::to_string(count) +
                     " markers, or none, has " + std::to_string(task.goal.marker_ids.size()));
  }
  if (!(task.goal.prior_sigma > 0.0)) {
    fail("goal.prior_sigma", "must be > 0 m, is " + std::to_string(task.goal.prior_sigma));
  }
  if (task.goal.marker_ids.empty()) return;
  if (task.goal.normals.size() != count) {
    fail("goal.normals", "needs one for each of the " + std::to_string(count) + " markers, has " +
                             std::to_string(task.goal.normals.size()));
  }
  for (const Vector3d& normal : task.goal.normals) {
    if (!(std::abs(normal.norm() - 1.0) < 1e-6)) {
      fail("goal.normals", "must be of length 1, one is of " + std::to_string(normal.norm()));
    }
  }
  if (!(task.goal.marker_radius > 0.0)) {
    fail("goal.marker_radius", "must be > 0 m, is " + std::to_string(task.goal.marker_radius));
  }
}

}  // namespace

Servo::Servo(ServoTask task, const ServoOptions& options, const TriggerOptions& trigger)
    : task_(std::move(task)),
      options_(options),
      trigger_(trigger),
      calibration_(options.calibration, task_.view.arm.size()),
      camera_(task_.view.camera) {
  Validate(task_);
  Validate(options_);
  const std::size_t count = task_.view.markers.size();
  needed_ = std::vector<bool>(count, false);
  for (const Feature& feature : task_.view.features.features()) {
    for (const int point : feature.points) needed_[static_cast<std::size_t>(point)] = true;
  }
  markers_needed_ = static_cast<int>(std::count(needed_.begin(), needed_.end(), true));
  for (const Vector3d& p_WG : task_.goal.p_WG) goal_.emplace_back(p_WG, task_.goal.prior_sigma);
  std::copy(task_.goal.p_WG.begin(), task_.goal.p_WG.end(), p_WMarker_.begin());
  p_WLayout_ = p_WMarker_;
  goal_offset_.fill(Vector2d::Zero());
  limits_ = task_.view.arm.limits();
  for (JointLimits& limit : limits_) {
    const double margin = std::min(options_.limit_margin, 0.1 * (limit.upper - limit.lower));
    limit.lower += margin;
    limit.upper -= margin;
  }
  p_EM_W_.resize(count);
  current_.resize(count);
  wanted_soon_.resize(count);
  wanted_.resize(count);
  ahead_.resize(count);
  const int n = task_.view.arm.size();
  qdot_ = JointVector::Zero(n);
  q_ = JointVector::Zero(n);
  q_true_ = q_;
  output_.command.qdot = qdot_;
  output_.command.q = q_;
  output_.status.markers_needed = markers_needed_;
  snapshot_.goal_count = static_cast<int>(count);
}

bool Servo::Refuse(InputFault fault) noexcept {
  output_.status.CountRefused(fault);
  return false;
}

bool Servo::Accept(const JointState& state, Time now) noexcept {
  const int n = task_.view.arm.size();
  if (state.q.size() != n || state.qdot.size() != n) return Refuse(InputFault::kWrongSize);
  if (!state.q.allFinite() || !state.qdot.allFinite()) return Refuse(InputFault::kNotFinite);
  if (state.stamp > now + kFutureTolerance) return Refuse(InputFault::kFuture);
  const bool first = joints_.empty();
  if (!joints_.Push(state.stamp, state.q)) return Refuse(InputFault::kReordered);
  if (first) {
    // The arm may be moving already (a restart): the first commands ramp from what it does.
    qdot_ = state.qdot;
    output_.command.q = state.q;
  }
  return true;
}

bool Servo::Accept(const CameraPose& pose, Time now) noexcept {
  if (!pose.X_WC.matrix().allFinite()) return Refuse(InputFault::kNotFinite);
  if (!IsPose(pose.X_WC)) return Refuse(InputFault::kOutOfRange);
  if (pose.stamp > now + kFutureTolerance) return Refuse(InputFault::kFuture);
  if (!poses_.Push(pose.stamp, pose.X_WC)) return Refuse(InputFault::kReordered);
  V_WC_C_ = CameraTwist();
  return true;
}

bool Servo::Accept(const ImageFeatures& features, Time now) noexcept {
  if (features.count < 0 || features.count > kMaxMarkers) return Refuse(InputFault::kWrongSize);
  if (!features.X_WC.matrix().allFinite()) return Refuse(InputFault::kNotFinite);
  if (!IsPose(features.X_WC)) return Refuse(InputFault::kOutOfRange);
  for (int i = 0; i < features.count; ++i) {
    const MarkerMeasurement& marker = features.markers[i];
    if (marker.valid && !marker.pixel.allFinite()) return Refuse(InputFault::kNotFinite);
  }
  if (features.exposure > now + kFutureTolerance) return Refuse(InputFault::kFuture);
  if (has_features_ && features.exposure <= features_.exposure) {
    return Refuse(InputFault::kReordered);
  }
  features_ = features;
  has_features_ = true;
  image_is_new_ = true;
  return true;
}

void Servo::Accept(const ActiveOutput& active) noexcept {
  const bool new_goal = active.q_goal.size() == q_.size() &&
                        (active_.q_goal.size() != q_.size() || active.q_goal != active_.q_goal);
  active_ = active;
  if (new_goal) X_WE_goal_ = EndEffectorPose(task_.view.arm, active.q_goal);
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
  if (X_before->matrix() == poses_.newest().matrix()) return Twist::Zero();
  return Displacement(*X_before, poses_.newest()) / ToSeconds(kTwistWindow);
}

void Servo::PredictState(Time now) noexcept {
  const double joint_age = std::clamp(Age(now, joints_.newest_stamp()), 0.0, kMaxExtrapolation);
  const double pose_age = std::clamp(Age(now, poses_.newest_stamp()), 0.0, kMaxExtrapolation);
  q_ = joints_.newest() + joint_age * qdot_;
  X_WC_measured_ = camera_moves_ ? Advance(poses_.newest(), pose_age * V_WC_C_) : poses_.newest();
  X_WC_ = X_WC_measured_ * calibration_.X_CTrue();
  q_true_ = q_ - calibration_.joint_bias();
  kinematics_ = ComputeKinematics(task_.view.arm, q_true_);
}

// Compares the newest image with the model at its exposure. What differs is carried to now: that
// bridges the latency and the time between two images.
void Servo::UseImage() noexcept {
  const bool standing = qdot_.lpNorm<Eigen::Infinity>() < kStandingSpeed && !camera_moves_;
  const double time = (standing ? kStandingAverage : 1.0) * options_.offset_time;
  const Isometry3d X_WE = UpdateCalibration(*joints_.At(features_.exposure, Between));
  const Isometry3d X_CE = X_WC_exposure_.inverse() * X_WE;
  markers_lost_ = 0;
  for (std::size_t i = 0; i < task_.view.markers.size(); ++i) {
    const Marker& marker = task_.view.markers[i];
    const MarkerMeasurement* measured = features_.Find(marker.id);
    const auto expected = Project(X_CE * marker.p);
    if (measured != nullptr && measured->valid && expected) {
      seen_at_[i] = FromUndistortedPixel(camera_, measured->pixel);
      const Vector2d offset = seen_at_[i] - expected->n;
      offset_[i] = last_seen_[i]
                       ? Averaged(offset_[i], offset, Age(features_.exposure, *last_seen_[i]),
                                  options_.offset_time, kOffsetJump / camera_.fx)
                       : offset;
      last_seen_[i] = features_.exposure;
    } else if (needed_[i]) {
      ++markers_lost_;
    }
  }
  goals_lost_ = 0;
  for (std::size_t i = 0; i < task_.goal.marker_ids.size(); ++i) {
    const MarkerMeasurement* measured = features_.Find(task_.goal.marker_ids[i]);
    if (measured != nullptr && measured->valid) {
      UseGoalImage(i, measured->pixel, time);
    } else if (needed_[i] && (!goal_last_seen_[i] ||
                              Age(features_.exposure, *goal_last_seen_[i]) >= kGoalMemory)) {
      ++goals_lost_;
    }
  }
  FitGoalLayout();
  X_WC_image_ = X_WC_exposure_;
  image_is_new_ = false;
}

// Compares the markers of the arm with where the calibration puts them, where that says something new, and
// moves the differences that are kept by what the correction explains. The corrected pose of the end
// effector at joints that are read as q.
Isometry3d Servo::UpdateCalibration(const JointVector& q) noexcept {
  const ViewModel& view = task_.view;
  Isometry3d X_WEBefore = EndEffectorPose(view.arm, q - calibration_.joint_bias());
  const Isometry3d X_WCBefore = features_.X_WC * calibration_.X_CTrue();
  const Isometry3d X_CWBefore = X_WCBefore.inverse();
  const CameraModel before = camera_;
  bool corrected = false;
  for (std::size_t i = 0; i < view.markers.size(); ++i) {
    const MarkerMeasurement* measured = features_.Find(view.markers[i].id);
    if (measured == nullptr || !measured->valid) continue;
    const Vector3d p_CM = X_CWBefore * (X_WEBefore * view.markers[i].p);
    std::optional<CalibrationView>& last = calibrated_at_[i];
    if (last && (p_CM - last->p_CM).norm() < kCalibrationWay &&
        AngleBetween(last->R_WC, X_WCBefore.linear()) < kCalibrationTurn) {
      continue;
    }
    last = CalibrationView{p_CM, X_WCBefore.linear()};
    const double sigma = std::hypot(options_.feature_noise_px, kCalibrationNoise);
    if (calibration_.Update(view.camera, features_.X_WC, view.arm, q, view.markers[i].p,
                            measured->pixel, sigma)) {
      corrected = true;
    }
  }
  X_WC_exposure_ = features_.X_WC * calibration_.X_CTrue();
  if (!corrected) return X_WEBefore;
  const Isometry3d& X_CTrue = calibration_.X_CTrue();
  const auto largest = [&](JointKind kind) {
    double bias = 0.0;
    for (int i = 0; i < view.arm.size(); ++i) {
      if (view.arm.joint_kinds()[static_cast<std::size_t>(i)] == kind) {
        bias = std::max(bias, std::abs(calibration_.joint_bias()(i)));
      }
    }
    return bias;
  };
  output_.status.calibration = {X_CTrue.translation().norm(),
                                Eigen::AngleAxisd(X_CTrue.linear()).angle(),
                                calibration_.focal_factor() - 1.0, largest(JointKind::kRevolute),
                                largest(JointKind::kPrismatic)};
  camera_ = WithFocalFactor(view.camera, calibration_.focal_factor());
  Isometry3d X_WE = EndEffectorPose(view.arm, q - calibration_.joint_bias());
  const auto shift = [&](int id, const Vector3d& p_WBefore, const Vector3d& p_W, Vector2d* offset) {
    const MarkerMeasurement* measured = features_.Find(id);
    const auto at_before = Project(X_CWBefore * p_WBefore);
    const auto at_now = Project(X_WC_exposure_.inverse() * p_W);
    if (measured == nullptr || !measured->valid || !at_before || !at_now) return;
    *offset += FromUndistortedPixel(camera_, measured->pixel) - at_now->n -
               (FromUndistortedPixel(before, measured->pixel) - at_before->n);
  };
  for (std::size_t i = 0; i < view.markers.size(); ++i) {
    shift(view.markers[i].id, X_WEBefore * view.markers[i].p, X_WE * view.markers[i].p,
          &offset_[i]);
  }
  for (std::size_t i = 0; i < task_.goal.marker_ids.size(); ++i) {
    shift(task_.goal.marker_ids[i], p_WMarker_[i], p_WMarker_[i], &goal_offset_[i]);
  }
  return X_WE;
}

void Servo::UseGoalImage(std::size_t i, const Vector2d& measured, double time) noexcept {
  const CameraModel& camera = camera_;
  const Isometry3d X_CW = X_WC_exposure_.inverse();
  const bool moves = task_.goal.max_speed > 0.0;
  const auto seen_before = Project(X_CW * p_WMarker_[i]);
  Vector2d place = FromUndistortedPixel(camera, measured);
  if (moves) {
    // What the camera's motion alone would have done to it since.
    ImageTrack& track = goal_tracks_[i];
    const auto before = Project(X_WC_image_.inverse() * p_WMarker_[i]);
    const bool known = before && seen_before && track.last();
    track.Update(features_.exposure, place,
                 known ? Vector2d(seen_before->n - before->n) : Vector2d(0.0, 0.0));
    place = track.place();
    goal_[i].Drift(task_.goal.max_speed * kDriftTime);
  }
  if (moves || NewView(i)) goal_[i].Update(camera, X_WC_exposure_, measured, GoalSigma());
  PlaceGoalMarker(i);
  // The estimate gives the depth; where the goal is in the image, the image says best. An error of the
  // camera's pose shifts goal and arm alike, and so leaves the difference of the two.
  const auto seen_at = Project(X_CW * p_WMarker_[i]);
  if (!seen_at || !seen_before) return;
  const Vector2d offset = place - seen_at->n;
  // What the estimate has moved by is no longer an offset.
  const Vector2d before = goal_offset_[i] - (seen_at->n - seen_before->n);
  std::optional<Time>& last_seen = goal_last_seen_[i];
  goal_offset_[i] = last_seen && !moves
                        ? Averaged(before, offset, Age(features_.exposure, *last_seen), time,
                                   kOffsetJump / camera.fx)
                        : offset;
  last_seen = features_.exposure;
}

// True when the camera looks at a goal's marker from elsewhere than last time.
bool Servo::NewView(std::size_t marker) noexcept {
  std::optional<Isometry3d>& X_WLast = goal_seen_from_[marker];
  const Isometry3d& X_WC = X_WC_exposure_;
  if (X_WLast && (X_WLast->translation() - X_WC.translation()).norm() < kNewViewDistance &&
      AngleBetween(X_WLast->linear(), X_WC.linear()) < kNewViewAngle) {
    return false;
  }
  X_WLast = X_WC;
  return true;
}

// Where a marker of the goal stands: as estimated; in depth also as the size of the goal in the image says,
// and once the arm stands at its goal in the image as the arm knows, each weighed by what it is good for.
void Servo::PlaceGoalMarker(std::size_t marker) noexcept {
  const Vector3d& p_WG = goal_[marker].p_WG();
  const Vector3d& offset_W = task_.goal.offset_W;
  const Vector3d sight = p_WG - X_WC_exposure_.translation();
  const Vector3d ray = sight.normalized();
  const double across = goal_offset_[marker].norm() * sight.norm();
  const double estimate = 1.0 / (ray.dot(goal_[marker].covariance() * ray) +
                                 std::pow(std::hypot(kEstimateFloor, kDepthFactor * across), 2));
  const bool at_rest = arrived_ && !(task_.goal.max_speed > 0.0);
  const double arrival =
      at_rest ? 1.0 / std::pow(std::hypot(kArrivalSigma, kArrivalLever * offset_W.norm()), 2) : 0.0;
  const double layout = 1.0 / std::pow(layout_sigma_, 2);
  const double all = estimate + arrival + layout;
  arrival_weight_[marker] += kArrivalBlend * (arrival / all - arrival_weight_[marker]);
  layout_weight_[marker] += kArrivalBlend * (layout / all - layout_weight_[marker]);
  const Vector3d arrived = kinematics_.X_WE * task_.view.markers[marker].p - offset_W;
  const double shift = arrival_weight_[marker] * ray.dot(arrived - p_WG) +
                       layout_weight_[marker] * ray.dot(p_WLayout_[marker] - p_WG);
  p_WMarker_[marker] = p_WG + shift * ray;
}

// How the goal's markers stand to one another is known: how far apart the image shows them tells their
// depth, whatever the errors of camera and arm.
void Servo::FitGoalLayout() noexcept {
  const Isometry3d X_CW = X_WC_exposure_.inverse();
  const Vector3d& p_WOrigin = task_.goal.p_WG.front();
  std::array<LayoutPoint, kMaxPoints> points;
  int count = 0;
  for (std::size_t i = 0; i < task_.goal.marker_ids.size(); ++i) {
    const bool seen = goal_last_seen_[i] && *goal_last_seen_[i] == features_.exposure;
    const auto at = Project(X_CW * p_WMarker_[i]);
    if (!seen || !at) continue;
    points[static_cast<std::size_t>(count++)] = {X_CW.linear() * (task_.goal.p_WG[i] - p_WOrigin),
                                                 at->n + goal_offset_[i]};
  }
  LayoutErrors errors;
  errors.n = kAveragedShare * options_.feature_noise_px / task_.view.camera.fx;
  const LayoutFit fit = FitLayout(points, count, errors);
  layout_sigma_ = fit.solved ? fit.depth_sigma : std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; fit.solved && i < task_.goal.marker_ids.size(); ++i) {
    p_WLayout_[i] = X_WC_exposure_ * fit.p_CL + (task_.goal.p_WG[i] - p_WOrigin);
  }
}

double Servo::GoalSigma() const noexcept {
  return std::hypot(options_.feature_noise_px, options_.calibration_px);
}

bool Servo::Carried(std::size_t marker) const noexcept {
  if (!last_seen_[marker]) return false;
  const bool confirmed = markers_needed_ - markers_lost_ >= kConfirming;
  const StalenessLimits& limits = options_.staleness;
  return Age(features_.exposure, *last_seen_[marker]) <=
         (confirmed ? std::max(limits.marker, limits.hidden_marker) : limits.marker);
}

HoldReason Servo::PredictRows(Time now) noexcept {
  const CameraModel& camera = task_.view.camera;
  const Isometry3d X_CW = X_WC_.inverse();
  const Isometry3d X_CE = X_CW * kinematics_.X_WE;
  bool behind = false;
  // Without compensation the image's own time is taken for the present.
  const double image_age = options_.latency_compensation ? Age(now, features_.exposure) : 0.0;
  for (std::size_t i = 0; i < current_.size(); ++i) {
    const auto here = Project(X_CE * task_.view.markers[i].p);
    const auto goal = Project(X_CW * (p_WMarker_[i] + task_.goal.offset_W));
    if (needed_[i] && (!here || !goal)) behind = true;
    const bool usable = Carried(i) && here && goal;
    current_[i].visible = wanted_[i].visible = usable;
    if (!usable) continue;
    const Vector2d seen = options_.latency_compensation ? here->n + offset_[i] : seen_at_[i];
    current_[i].image = {seen, here->depth};
    wanted_[i].image = {goal->n + goal_offset_[i] + image_age * goal_tracks_[i].rate(),
                        goal->depth};
    // The goal's points stand in the world; the end effector's are on the body.
    wanted_[i].on_body = false;
  }
  task_.view.features.Evaluate(camera, current_, &current_rows_, options_.interaction);
  // Of the goals' matrices only the flow under the camera's motion is made.
  if (camera_moves_) {
    task_.view.features.Evaluate(camera, wanted_, &goal_rows_, options_.interaction);
  } else {
    task_.view.features.EvaluateValues(camera, wanted_, &goal_rows_);
  }
  KeepCommonRows(&current_rows_, &goal_rows_);
  if (current_rows_.size() < RowsNeeded()) {
    return behind ? HoldReason::kPointBehindCamera : HoldReason::kTooFewFeatures;
  }
  return HoldReason::kNone;
}

// Features of the reference on the way to the goal's joints. False: the reference is the goal itself.
//
// The image of the model there is corrected by what the image differs from the model: here, the more the
// nearer it is to here; at the goal, the more the nearer it is to the goal.
bool Servo::PredictPathRows() noexcept {
  const ReferencePathOptions& options = options_.path;
  const JointVector& q_goal = active_.q_goal;
  reference_.share = 1.0;
  reference_.step = JointVector::Zero(q_.size());
  if (!options.enabled || options_.law.textbook || q_goal.size() != q_.size()) return false;
  const ViewModel& view = task_.view;
  reference_ = ReferenceAhead(options, view.arm, q_true_, q_goal, options_.law.gain_at_zero);
  if (reference_.share == 1.0) return false;
  const Isometry3d X_CW = X_WC_.inverse();
  for (std::size_t i = 0; i < ahead_.size(); ++i) {
    const Vector3d& p_EM = view.markers[i].p;
    const auto ahead = Project(X_CW * (reference_.X_WE * p_EM));
    ahead_[i].visible = current_[i].visible && ahead;
    ahead_[i].on_body = false;
    if (!ahead_[i].visible) continue;
    const Vector2d goal_correction = PathCorrection(X_CW, i);
    const Vector2d correction =
        (1.0 - reference_.share) * offset_[i] + reference_.share * goal_correction;
    ahead_[i].image = {ahead->n + correction, ahead->depth};
  }
  if (camera_moves_) {
    view.features.Evaluate(view.camera, ahead_, &path_rows_, options_.interaction);
  } else {
    view.features.EvaluateValues(view.camera, ahead_, &path_rows_);
  }
  return path_rows_.size() == current_rows_.size();
}

// The law's options, with the damping that the way and the view ask for.
ServoLawOptions Servo::LawHere() const noexcept {
  ServoLawOptions law = options_.law;
  const bool known = active_.q_goal.size() == q_.size();
  if (!options_.path.enabled || law.textbook || !known) return law;
  const double excess = output_.observability.mm_per_px / options_.convergence.max_mm_per_px - 1.0;
  const double doubt = reference_.share < 1.0 ? 1.0 : std::clamp(excess, 0.0, 1.0);
  const double trust = doubt * options_.path.trust;
  if (trust <= law.damping) return law;
  law.damping = trust;
  law.damping_onset = std::numeric_limits<double>::infinity();
  return law;
}

// By how much a marker's goal in the image differs from the marker's image by the model, the arm being
// at the goal's joints.
Vector2d Servo::PathCorrection(const Isometry3d& X_CW, std::size_t marker) const noexcept {
  const auto modelled = Project(X_CW * (X_WE_goal_ * task_.view.markers[marker].p));
  if (!modelled || !wanted_[marker].visible) return offset_[marker];
  return wanted_[marker].image.n - modelled->n;
}

HoldReason Servo::Control(Time now) noexcept {
  const FeatureJacobian J_v =
      ImageJacobian(current_rows_.L_body, X_WC_, kinematics_.X_WE.translation());
  output_.J_v = J_v;
  output_.J_r = kinematics_.J_WE_W;
  const TaskJacobian J_c = ProductByColumns(J_v, output_.J_r);
  output_.error = FeatureError(task_.view.features, current_rows_, goal_rows_);
  DecomposeComposite(J_v, output_.J_r, J_c, &composite_);
  const SingularSystem& system = composite_.system;
  if (system.measure.status != MeasureStatus::kOk || !output_.error.allFinite()) {
    return HoldReason::kNotFinite;
  }
  output_.status.error_px =
      std::sqrt(output_.error.squaredNorm() / static_cast<double>(output_.error.size()));
  AverageError();
  ReportMeasures();

  const FeatureRows& target = PredictPathRows() ? path_rows_ : goal_rows_;
  const double effort = StartEffort(now);
  ServoDemand demand{FeatureError(task_.view.features, current_rows_, target), ErrorRate(target),
                     effort, SelfMotion()};
  // What the arm was told and has not done yet, it still will.
  const JointVector& q_told = output_.command.q;
  VelocityBounds bounds =
      ComputeVelocityBounds(limits_, q_.cwiseMin(q_told), q_.cwiseMax(q_told), qdot_, dt_);
  // What the image does not show, the model decides: damping pulls towards the way to the goal's joints,
  // not towards rest.
  const JointVector qdot_path = effort * options_.law.gain_at_infinity * reference_.step;
  demand.e_rate += J_c.lazyProduct(qdot_path);
  bounds.lower -= qdot_path;
  bounds.upper -= qdot_path;
  ServoLawResult law = ServoLaw(LawHere(), demand, J_c, system, bounds);
  if (!law.finite) return HoldReason::kNotFinite;
  law.qdot += qdot_path;
  const bool poor = output_.observability.mm_per_px > options_.wait_mm_per_px;
  const bool wait =
      (options_.hold_while_camera_moves || poor) && active_.state == ActiveState::kMoving;
  Command(now, wait ? RampToRest(limits_, qdot_, dt_) : law.qdot);
  return HoldReason::kNone;
}

// Rate of the error that the joints do not cause: the flow under the camera's motion, of the features less
// of their goals, and the goals' own motion.
FeatureVector Servo::ErrorRate(const FeatureRows& target) noexcept {
  FeatureVector rate = FeatureVector::Zero(current_rows_.size());
  if (camera_moves_) rate = (current_rows_.L - target.L).lazyProduct(V_WC_C_);
  if (!(task_.goal.max_speed > 0.0)) return rate;
  wanted_soon_ = wanted_;
  for (std::size_t i = 0; i < wanted_.size(); ++i) {
    wanted_soon_[i].image.n += kSoon * goal_tracks_[i].rate();
  }
  task_.view.features.EvaluateValues(task_.view.camera, wanted_soon_, &soon_rows_);
  if (soon_rows_.size() != goal_rows_.size()) return rate;
  // A reference on the way moves with the goal by its share of the way.
  return rate -
         (reference_.share / kSoon) * FeatureError(task_.view.features, soon_rows_, goal_rows_);
}

// Where the features leave the joints freedom: away from the limits, and up the gradient of log w_c.
JointVector Servo::SelfMotion() const noexcept {
  const int n = task_.view.arm.size();
  if (RowsNeeded() >= n) return JointVector();
  const ServoLawOptions& law = options_.law;
  return LimitAvoidance(limits_, q_, law.self_motion) +
         CompositeAscent(law, limits_, active_.log_w_gradient);
}

double Servo::StartEffort(Time now) noexcept {
  if (!moving_since_) moving_since_ = now;
  const double start_time = options_.law.start_time;
  if (!(start_time > 0.0)) return 1.0;
  return -std::expm1(-(Age(now, *moving_since_) + dt_) / start_time);
}

void Servo::ReportMeasures() noexcept {
  const ViewModel& view = task_.view;
  const ArmJacobian& J_r = output_.J_r;
  const SingularSystem& system = composite_.system;
  ObservabilityReport& report = output_.observability;
  report.k = static_cast<int>(output_.J_v.rows());
  report.n = static_cast<int>(J_r.cols());
  report.composite = system.measure;
  report.axes = system.axes;
  report.w_v = ObservabilityOf(output_.J_v, system.measure, composite_.arm);
  report.w_r = composite_.arm.w;
  report.w_c = system.measure.w;
  for (std::size_t i = 0; i < view.markers.size(); ++i) {
    p_EM_W_[i] = kinematics_.X_WE.linear() * view.markers[i].p;
  }
  const ArmJacobian twists = TwistsOf(system, J_r);
  report.mm_per_px = WorstMillimetresPerPixel(system, J_r, twists, p_EM_W_);
  remaining_mm_ = RemainingMillimetres(system, twists);
  report.trigger_measure = trigger_.measure;
  report.threshold = trigger_.threshold;
  report.trigger_value = TriggerValue(trigger_.measure, system.measure);
  const bool low = report.trigger_value < trigger_.threshold;
  report.cause =
      DiagnoseLowMeasure(system, composite_.arm, J_r, twists, p_EM_W_, RowsNeeded(), low);
}

// The error as it is judged: without the noise of single images.
void Servo::AverageError() noexcept {
  const double time = 0.5 * options_.convergence.settle_time;
  if (mean_error_.size() != output_.error.size() || !mean_error_.allFinite()) {
    mean_error_ = output_.error;
  } else {
    mean_error_ += dt_ / (dt_ + time) * (output_.error - mean_error_);
  }
}

// The joint motion that the image error stands for, and how far it moves the markers [mm]. Directions
// that the image does not show are left out: the view's certificate answers for them.
double Servo::RemainingMillimetres(const SingularSystem& system,
                                   const ArmJacobian& twists) const noexcept {
  Twist V_WE_W = Twist::Zero();
  for (int i = 0; i < system.measure.rank; ++i) {
    const double sigma = system.measure.sigma(i);
    V_WE_W += (system.axes.col(i).dot(mean_error_) / (sigma * sigma)) * twists.col(i);
  }
  double worst = 0.0;  // squared
  for (const Vector3d& p_EM_W : p_EM_W_) {
    worst = std::max(worst, (V_WE_W.head<3>() + V_WE_W.tail<3>().cross(p_EM_W)).squaredNorm());
  }
  return 1e3 * std::sqrt(worst);
}

int Servo::RowsNeeded() const noexcept {
  return std::min({static_cast<int>(task_.view.features.features().size()), task_.view.arm.size(),
                   kTaskDimension});
}

// Converged: small error for the settling time in a view that certifies it. Stalled: an error that no
// longer falls, or a small one in a view that hides too much.
void Servo::JudgeProgress(Time now) noexcept {
  const ConvergenceOptions& goal = options_.convergence;
  const double error =
      std::sqrt(mean_error_.squaredNorm() / static_cast<double>(mean_error_.size()));
  const double way = active_.q_goal.size() == q_.size() ? (active_.q_goal - q_true_).norm() : 0.0;
  const bool certified = output_.observability.mm_per_px <= goal.max_mm_per_px;
  const bool stands = best_since_ && Age(now, *best_since_) > options_.stall_time;
  const double slack = stands && certified ? kReachedShare : 1.0;
  const bool near =
      error <= slack * goal.tolerance_px && remaining_mm_ <= slack * goal.tolerance_mm;
  const bool complete = markers_lost_ == 0 && goals_lost_ == 0;
  // A camera on its way to a better view will see better still: no verdict before it is there.
  const bool moving = active_.state == ActiveState::kMoving;
  if (!near || !complete || moving) {
    below_since_.reset();
  } else if (!below_since_) {
    below_since_ = now;
  }
  const bool progress = error < kProgress * best_error_ || way < kProgress * best_way_;
  if (!best_since_ || progress || moving) {
    best_error_ = !best_since_ || moving ? error : std::min(error, best_error_);
    best_way_ = !best_since_ || moving ? way : std::min(way, best_way_);
    best_since_ = now;
  }
  const bool settled = below_since_ && Age(now, *below_since_) >= goal.settle_time;
  arrived_ = certified && complete && error <= kReachedShare * goal.tolerance_px &&
             remaining_mm_ <= 5.0 * goal.tolerance_mm;
  uncertified_ = settled && !certified;
  stalled_ = uncertified_ || (stands && !(near && complete));
  output_.status.reason = HoldReason::kNone;
  if (settled && certified) {
    output_.status.state = ServoState::kConverged;
  } else {
    output_.status.state = moving ? ServoState::kRepositioning : ServoState::kServoing;
    if (stands && error > goal.tolerance_px && !moving) {
      output_.status.reason = WhyStanding();
      if (output_.status.reason != HoldReason::kNone) output_.status.state = ServoState::kHolding;
    }
  }
}

void Servo::Command(Time now, const JointVector& qdot) noexcept {
  JointVector& q = output_.command.q;
  if (!joints_.empty()) {
    // While a period was late, an arm that takes velocities went on and one that takes positions waited:
    // its encoders tell. Ahead only, to where the arm is: no position command jumps back to an arm that lags.
    const JointVector went_on = late_ * qdot_;
    const JointVector ahead = joints_.newest() - q;
    q += ahead.cwiseMax(went_on.cwiseMin(0.0)).cwiseMin(went_on.cwiseMax(0.0));
    // At rest the position command follows the arm, so that it never jumps when motion resumes.
    if (qdot.isZero(0.0)) q = joints_.newest();
  }
  q += dt_ * qdot;
  qdot_ = qdot;
  output_.command.stamp = now;
  output_.command.qdot = qdot;
}

bool Servo::ArmFollows() noexcept {
  const JointVector& q = joints_.newest();
  // At rest it may be moved by hand, or be another one after a restart.
  if (qdot_.isZero(0.0)) output_.command.q = q;
  for (int i = 0; i < q.size(); ++i) {
    const double lead = std::abs(output_.command.q(i) - q(i));
    if (lead > kMaxLead * task_.view.arm.limits()[static_cast<std::size_t>(i)].velocity)
      return false;
  }
  return true;
}

// Why an arm that no longer gets nearer stands, if it does.
HoldReason Servo::WhyStanding() const noexcept {
  bool at_limit = false;
  for (int i = 0; i < qdot_.size(); ++i) {
    const JointLimits& limit = limits_[static_cast<std::size_t>(i)];
    if (std::abs(qdot_(i)) > kStands * limit.velocity) return HoldReason::kNone;
    const double room = std::min(q_(i) - limit.lower, limit.upper - q_(i));
    at_limit = at_limit || room < kAtLimit * (limit.upper - limit.lower);
  }
  if (at_limit) return HoldReason::kJointLimit;
  return output_.observability.cause == LowCause::kArm ? HoldReason::kArmSingular
                                                       : HoldReason::kNone;
}

void Servo::Rehearse(Time now) noexcept {
  if (joints_.empty() || poses_.empty() || !has_features_) return;
  // As dear as an image can make it: every marker is seen from elsewhere than last time.
  calibrated_at_.fill(std::nullopt);
  goal_seen_from_.fill(std::nullopt);
  // Just after what is there: the same places in the histories are read.
  constexpr Duration kAfter = std::chrono::nanoseconds(1);
  Accept(JointState{joints_.newest_stamp() + kAfter, joints_.newest(), qdot_}, now);
  Accept(CameraPose{poses_.newest_stamp() + kAfter, poses_.newest()}, now);
  ImageFeatures image = features_;
  image.exposure += kAfter;
  Accept(image, now);
  (void)Step(now);
}

const ServoOutput& Servo::Step(Time now) noexcept {
  ServoStatus& status = output_.status;
  const ServoState before = status.state;
  ++status.seq;
  status.stamp = now;
  output_.error.resize(0);
  // A period that starts early, after a late one, must not use up a whole period's acceleration.
  const double elapsed = last_step_ == Time{} ? options_.period : Age(now, last_step_);
  dt_ = std::clamp(elapsed, 0.0, options_.period);
  late_ = std::max(elapsed - options_.period, 0.0);
  last_step_ = now;

  if (!enabled_) fault_ = false;
  HoldReason reason = enabled_ ? CheckInputs(now) : HoldReason::kOperator;
  if (reason == HoldReason::kNone && (fault_ || !ArmFollows())) {
    fault_ = true;
    reason = HoldReason::kArmNotFollowing;
  }
  if (reason == HoldReason::kNone) {
    camera_moves_ = !V_WC_C_.isZero(0.0);
    if (image_is_new_) UseImage();
    PredictState(now);
    snapshot_.valid = true;
    reason = PredictRows(now);
    if (reason == HoldReason::kNone) reason = Control(now);
  }
  if (reason == HoldReason::kNone) {
    JudgeProgress(now);
  } else {
    Command(now, RampToRest(limits_, qdot_, dt_));
    moving_since_.reset();
    below_since_.reset();
    best_since_.reset();
    stalled_ = false;
    arrived_ = false;
    uncertified_ = false;
    mean_error_.resize(0);
    status.reason = reason;
    const bool waiting = before == ServoState::kIdle || before == ServoState::kAcquiring;
    status.state = !enabled_ ? ServoState::kIdle
                   : fault_  ? ServoState::kFault
                   : waiting ? ServoState::kAcquiring
                             : ServoState::kHolding;
    const bool moved = before == ServoState::kServoing || before == ServoState::kRepositioning ||
                       before == ServoState::kConverged;
    if (moved) status.CountStop(reason);
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
  view.q = q_true_;
  view.qdot = qdot_;
  view.X_WC = X_WC_measured_;
  view.composite = report.composite;
  view.cause = report.cause;
  view.markers_lost = markers_lost_;
  view.stalled = stalled_;
  view.uncertified = uncertified_;
  view.mm_per_px = report.mm_per_px;
  view.error_px = status.error_px;
  for (std::size_t i = 0; i < goal_.size(); ++i) {
    snapshot_.p_marker[i] = p_WMarker_[i];
    snapshot_.p_WG[i] = p_WMarker_[i] + task_.goal.offset_W;
  }
  return output_;
}

}  // namespace vantage
