#include "vantage/active/active_camera.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "vantage/math/error.h"
#include "vantage/math/spatial.h"

namespace vantage {
namespace {

using Eigen::Isometry3d;

// A pause between steps counts as no longer than this [s].
constexpr double kLongestStep = 0.1;
// Fruitless plans in a row stretch the time to the next one, up to this many times.
constexpr int kMostPatience = 8;
// On the way, only a view better by this many times the least gain makes the camera turn off.
constexpr double kTurnOff = 2.0;
// The guard keeps markers this share of the margin inside the image.
constexpr double kGuardShare = 0.5;
// The guard holds at least so long [s], and has let go when this share of the path is passed since.
constexpr double kHold = 0.25;
constexpr double kHeadway = 0.05;
// A rig at rest this far from where it was commanded, for so long, did not follow.
constexpr double kAstrayDistance = 0.05;  // [m]
constexpr double kAstrayAngle = 0.05;     // [rad]
constexpr double kAstrayTime = 1.0;       // [s]
// Views that failed are remembered for an arm within this of where it was [rad or m], so many at most.
constexpr double kArmElsewhere = 0.1;
constexpr std::size_t kMostSpoiled = 12;
// Step of the gradient's central differences [m or rad].
constexpr double kGradientStep = 1e-4;

// How many of the arm's markers, whichever they are, the features can do without: those that are left
// still span the task. One at most is counted on.
int SpareMarkers(const ViewModel& model) {
  const std::vector<Feature>& features = model.features.features();
  const int needed =
      std::min({static_cast<int>(features.size()), model.arm.size(), kTaskDimension});
  for (int marker = 0; marker < model.features.num_points(); ++marker) {
    const auto left = std::count_if(features.begin(), features.end(), [&](const Feature& feature) {
      return std::find(feature.points.begin(), feature.points.end(), marker) ==
             feature.points.end();
    });
    if (left < needed) return 0;
  }
  return 1;
}

bool ArmNear(const JointVector& a, const JointVector& b) noexcept {
  return (a - b).lpNorm<Eigen::Infinity>() <= kArmElsewhere;
}

bool WithinLimits(const CameraRig& rig, const RigVector& q_c) noexcept {
  return q_c.allFinite() && (ClampToLimits(rig, q_c) - q_c).cwiseAbs().sum() == 0.0;
}

RigVector CheckedStart(const ViewModel& model, const CameraRig& rig, const RigVector& q_c_start,
                       const ActiveOptions& options) {
  Validate(model);
  Validate(rig);
  Validate(options);
  if (q_c_start.size() != rig.size()) {
    throw ConfigError("", "camera_rig.start",
                      "needs " + std::to_string(rig.size()) + " coordinates, has " +
                          std::to_string(q_c_start.size()));
  }
  if (!WithinLimits(rig, q_c_start)) {
    throw ConfigError("", "camera_rig.start", "must be within the rig's limits");
  }
  return q_c_start;
}

bool Astray(const Isometry3d& X_WC, const Isometry3d& X_WCommanded) noexcept {
  const double angle = AngleBetween(X_WC.linear(), X_WCommanded.linear());
  return (X_WC.translation() - X_WCommanded.translation()).norm() > kAstrayDistance ||
         angle > kAstrayAngle;
}

ActiveRefusal RefusalOf(PlanVerdict verdict) noexcept {
  switch (verdict) {
    case PlanVerdict::kMove:
      return ActiveRefusal::kNone;
    case PlanVerdict::kNoGain:
      return ActiveRefusal::kNoBetterView;
    case PlanVerdict::kNoView:
      return ActiveRefusal::kNoView;
    case PlanVerdict::kNoPath:
      return ActiveRefusal::kNoPath;
    case PlanVerdict::kRigCannotMove:
      return ActiveRefusal::kRigCannotMove;
  }
  return ActiveRefusal::kNone;
}

}  // namespace

void Validate(const ActiveOptions& options) {
  Validate(options.trigger);
  Validate(options.planner);
  if (!(options.replan_interval > 0.0) || !std::isfinite(options.replan_interval)) {
    throw ConfigError("", "active.replan_interval",
                      "must be > 0 s, is " + std::to_string(options.replan_interval));
  }
  if (!(options.look_ahead >= 0.0) || !std::isfinite(options.look_ahead)) {
    throw ConfigError("", "active.look_ahead",
                      "must be >= 0 s, is " + std::to_string(options.look_ahead));
  }
}

JointVector PredictJoints(const JointVector& q, const JointVector& qdot, const JointVector& q_goal,
                          double ahead) noexcept {
  JointVector predicted = q + ahead * qdot;
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    // Joints that run towards the goal end there.
    const double to_goal = q_goal(i) - q(i);
    if (to_goal * qdot(i) > 0.0 && std::abs(ahead * qdot(i)) > std::abs(to_goal)) {
      predicted(i) = q_goal(i);
    }
  }
  return predicted;
}

ActiveCamera::ActiveCamera(ViewModel model, CameraRig rig, const RigVector& q_c_start,
                           const ActiveOptions& options)
    : model_(std::move(model)),
      rig_(std::move(rig)),
      options_(options),
      motion_(CheckedStart(model_, rig_, q_c_start, options_)),
      spare_markers_(SpareMarkers(model_)) {}

bool ActiveCamera::UsableInputs(const ActiveInputs& inputs) const {
  const int n = model_.arm.size();
  return inputs.q.size() == n && inputs.qdot.size() == n && inputs.q_goal.size() == n &&
         inputs.q.allFinite() && inputs.qdot.allFinite() && inputs.q_goal.allFinite() &&
         IsPose(inputs.X_WC);
}

// A rig that was moved by someone else, or did not follow, is where it says it is.
void ActiveCamera::FollowRig(const ActiveInputs& inputs) {
  if (rig_.size() == 0 || moving_ || !Astray(inputs.X_WC, RigPose(rig_, motion_.q_c()))) {
    astray_since_.reset();
    return;
  }
  if (!astray_since_) astray_since_ = inputs.now;
  const bool long_enough = ToSeconds(inputs.now - *astray_since_) >= kAstrayTime;
  if (started_ && !long_enough) return;
  motion_ = RigMotion(NearestRigCoordinates(rig_, inputs.X_WC, motion_.q_c()));
  astray_since_.reset();
}

// True when a marker that is seen from here, the arm being where it is, would not be from where the
// camera could come to rest at the earliest.
bool ActiveCamera::WouldLoseMarker(const ActiveInputs& inputs, double dt) const {
  ViewLimits limits = options_.planner.limits;
  limits.margin *= kGuardShare;
  RigMotion ahead = motion_;
  ahead.Step(dt, false);
  const Isometry3d X_WNow = RigPose(rig_, motion_.q_c());
  const Isometry3d X_WNext = RigPose(rig_, ahead.q_c());
  const Isometry3d X_WRest = RigPose(rig_, ahead.StopCoordinates());
  const auto loses = [&](const PlacedMarker& marker) {
    const auto sees = [&](const Isometry3d& X_WC) {
      return CheckMarkerAmong(model_.camera, limits, X_WC, marker, sample_, inputs.goal_markers) ==
             ViewFault::kNone;
    };
    return sees(X_WNow) && !(sees(X_WNext) && sees(X_WRest));
  };
  return std::any_of(sample_.markers.begin(), sample_.markers.end(), loses) ||
         std::any_of(inputs.goal_markers.begin(), inputs.goal_markers.end(), loses);
}

void ActiveCamera::Move(double dt, const ActiveInputs& inputs) {
  if (!moving_) return;
  // What is lost already, or by plan, needs no guard: the arm waits.
  const bool guarded = !may_lose_ && inputs.markers_lost == 0;
  const bool loses = guarded && WouldLoseMarker(inputs, dt);
  if (loses && !held_since_) {
    held_since_ = inputs.now;
    held_at_ = motion_.s();
  }
  // Once held it comes to rest, and waits a little before it tries again: no creeping along the brink.
  const bool held =
      held_since_ && (loses || !motion_.AtRest() || ToSeconds(inputs.now - *held_since_) < kHold);
  motion_.Step(dt, held || next_.has_value());
  output_.refusal = held ? ActiveRefusal::kGuard : ActiveRefusal::kNone;
  if (!held && motion_.s() > held_at_ + kHeadway) held_since_.reset();
  if (!motion_.AtRest()) return;
  if (next_) {
    // It was planned from where the camera was expected to come to rest.
    RigPath path = next_->StartingAt(motion_.q_c());
    for (int i = 1; i < RigPath::kPoints; ++i) path.point(i) = ClampToLimits(rig_, path.point(i));
    Begin(path, next_gain_, next_loses_);
    return;
  }
  const bool stuck =
      held && ToSeconds(inputs.now - *held_since_) >= std::max(kHold, options_.replan_interval);
  if (motion_.Done() || stuck) {
    motion_ = RigMotion(motion_.q_c());
    moving_ = false;
    held_since_.reset();
    output_.refusal = ActiveRefusal::kNone;
  }
}

// Steepest ascent of log w_c in the rig's coordinates, each axis measured by its speed; the head aims at
// the markers. Stops where the measure is good enough, or the next pose would lose a marker.
void ActiveCamera::ClimbGradient(double dt) {
  const auto log_value = [&](const RigVector& q_c) {
    const Measure measure = MeasureOf(CompositeJacobian(model_, sample_, RigPose(rig_, q_c)));
    return std::log(TriggerValue(options_.trigger.measure, measure));
  };
  const RigVector q_c = motion_.q_c();
  const bool good_enough =
      output_.trigger_value > options_.planner.cap * options_.trigger.threshold;
  RigVector rate = RigVector::Zero(rig_.size());
  for (int i = 0; i < rig_.size() && !good_enough; ++i) {
    const double speed = rig_.axes[static_cast<std::size_t>(i)].max_speed;
    RigVector above = q_c, below = q_c;
    above(i) += kGradientStep;
    below(i) -= kGradientStep;
    const double slope = (log_value(above) - log_value(below)) / (2.0 * kGradientStep);
    rate(i) = speed * speed * slope;
  }
  double share = 0.0;  // of the greatest speeds
  for (int i = 0; i < rig_.size(); ++i) {
    const double speed = rig_.axes[static_cast<std::size_t>(i)].max_speed;
    if (speed > 0.0) share = std::max(share, std::abs(rate(i)) / speed);
  }
  const double linear = (RigJacobian(rig_, q_c).topRows<3>() * rate).norm();
  share = std::max(share, linear / rig_.max_linear_speed);
  if (!std::isfinite(share) || share < 1e-9) return;
  RigVector next = ClampToLimits(rig_, q_c + dt / std::max(share, 1.0) * rate);
  const RigVector aimed = AimAt(rig_, next, sample_.markers.front().p_W);
  for (int i = 0; i < rig_.size(); ++i) {
    const double reach = rig_.axes[static_cast<std::size_t>(i)].max_speed * dt;
    next(i) = std::clamp(aimed(i), q_c(i) - reach, q_c(i) + reach);
  }
  const Isometry3d X_WC = RigPose(rig_, next);
  for (const PlacedMarker& marker : sample_.markers) {
    const ViewFault fault =
        CheckMarker(model_.camera, options_.planner.limits, X_WC, marker, sample_.capsules);
    if (fault != ViewFault::kNone) return;
  }
  motion_ = RigMotion(next);
}

bool ActiveCamera::MarkerAtRisk(const ActiveInputs& inputs) {
  q_soon_.resize(0);
  if (options_.look_ahead == 0.0 || inputs.qdot.isZero(0.0)) return false;
  const Isometry3d X_WC = RigPose(rig_, motion_.q_c());
  const ViewLimits& limits = options_.planner.limits;
  const auto sees = [&](const PlacedMarker& marker, const ArmSample& sample) {
    return CheckMarkerAmong(model_.camera, limits, X_WC, marker, sample, inputs.goal_markers) ==
           ViewFault::kNone;
  };
  for (const double share : {0.5, 1.0}) {
    const JointVector q =
        PredictJoints(inputs.q, inputs.qdot, inputs.q_goal, share * options_.look_ahead);
    SampleArm(model_, q, &soon_);
    bool lost = false;
    for (std::size_t i = 0; i < sample_.markers.size(); ++i) {
      lost = lost || (sees(sample_.markers[i], sample_) && !sees(soon_.markers[i], soon_));
    }
    for (const PlacedMarker& marker : inputs.goal_markers) {
      lost = lost || (sees(marker, sample_) && !sees(marker, soon_));
    }
    if (!lost) continue;
    q_soon_ = q;
    return true;
  }
  return false;
}

ActiveReason ActiveCamera::Demand(const ActiveInputs& inputs) {
  lost_count_ = inputs.markers_lost > 0 ? lost_count_ + 1 : 0;
  const bool at_risk = MarkerAtRisk(inputs);
  if (lost_count_ >= options_.trigger.debounce) return ActiveReason::kMarkerLost;
  if (at_risk) return ActiveReason::kMarkerAtRisk;
  if (inputs.stalled) return ActiveReason::kStalled;
  return trigger_.triggered ? ActiveReason::kLowMeasure : ActiveReason::kNone;
}

PlanRequest ActiveCamera::RequestFrom(const ActiveInputs& inputs, const RigVector& q_c) const {
  PlanRequest request;
  request.q = inputs.q;
  request.q_goal = inputs.q_goal;
  request.q_soon = q_soon_;
  request.goal_markers = inputs.goal_markers;
  request.q_c = q_c;
  request.q_c_stay = q_c;
  for (const SpoiledView& view : spoiled_) {
    if (ArmNear(view.q, inputs.q)) request.X_WSpoiled.push_back(view.X_WC);
  }
  const JointVector to_goal = inputs.q_goal - inputs.q;
  const double distance2 = to_goal.squaredNorm();
  if (distance2 > 1e-12) {
    request.progress_rate = std::max(0.0, inputs.qdot.dot(to_goal) / distance2);
  }
  return request;
}

// A view that fails though the model likes it is likely to fail again, until the arm is elsewhere.
void ActiveCamera::RememberSpoiled(const ActiveInputs& inputs) {
  const auto elsewhere = [&](const SpoiledView& view) { return !ArmNear(view.q, inputs.q); };
  spoiled_.erase(std::remove_if(spoiled_.begin(), spoiled_.end(), elsewhere), spoiled_.end());
  if (spoiled_.size() == kMostSpoiled) spoiled_.erase(spoiled_.begin());
  spoiled_.push_back({RigPose(rig_, motion_.q_c()), inputs.q});
}

void ActiveCamera::Begin(const RigPath& path, double gain, bool may_lose) {
  motion_ = RigMotion(rig_, path);
  may_lose_ = may_lose;
  moving_ = true;
  next_.reset();
  held_since_.reset();
  fruitless_in_a_row_ = 0;
  output_.gain = gain;
  ++output_.moves;
}

void ActiveCamera::Plan(const ActiveInputs& inputs, ActiveReason reason) {
  if (reason != output_.reason) fruitless_in_a_row_ = 0;
  const int patience = std::min(kMostPatience, 1 << std::min(fruitless_in_a_row_, 3));
  if (last_plan_ && ToSeconds(inputs.now - *last_plan_) < patience * options_.replan_interval) {
    return;
  }
  output_.reason = reason;
  last_plan_ = inputs.now;
  ++output_.plans;
  const bool spoiled = reason == ActiveReason::kMarkerLost ||
                       (reason == ActiveReason::kStalled && !inputs.uncertified);
  if (spoiled) RememberSpoiled(inputs);
  PlanRequest request = RequestFrom(inputs, motion_.q_c());
  // The camera loses markers that the model sees, or the servo stands in a view that looks good: what
  // is wrong here is not in the model.
  request.certify = inputs.uncertified;
  request.stay_is_spoiled = spoiled;
  request.may_lose = reason == ActiveReason::kMarkerLost;
  // Where the usual candidates are no good, more of them are looked at: the task waits for a view. A view
  // that is merely low is not worth the search.
  PlannerOptions options = options_.planner;
  if (reason != ActiveReason::kLowMeasure) options.candidates *= patience;
  ViewPlan plan = PlanView(model_, rig_, options_.trigger, options, request);
  if (plan.verdict == PlanVerdict::kNoPath && !request.may_lose) {
    request.may_lose = true;
    plan = PlanView(model_, rig_, options_.trigger, options, request);
  }
  // A view of the arm alone keeps the task going towards where the goal was seen last.
  if (plan.verdict == PlanVerdict::kNoView && !inputs.goal_markers.empty()) {
    request.may_lose = true;
    request.goal_optional = true;
    plan = PlanView(model_, rig_, options_.trigger, options, request);
  }
  if (plan.verdict == PlanVerdict::kNoView && spare_markers_ > 0) {
    request.may_lose = true;
    request.spare_markers = spare_markers_;
    plan = PlanView(model_, rig_, options_.trigger, options, request);
  }
  output_.refusal = RefusalOf(plan.verdict);
  if (plan.verdict == PlanVerdict::kMove) {
    Begin(plan.path, plan.gain, plan.loses);
  } else {
    ++output_.fruitless;
    ++fruitless_in_a_row_;
  }
}

// While the camera is on its way the arm goes on: is the view it goes to still the one to have?
void ActiveCamera::PlanOnTheWay(const ActiveInputs& inputs) {
  if (next_ || !last_plan_ || ToSeconds(inputs.now - *last_plan_) < options_.replan_interval) {
    return;
  }
  last_plan_ = inputs.now;
  ++output_.plans;
  PlanRequest request = RequestFrom(inputs, motion_.StopCoordinates());
  request.q_c_stay = motion_.path().end();
  request.q_soon.resize(0);  // The camera is not there yet.
  request.may_lose = may_lose_;
  request.certify = inputs.uncertified;
  PlannerOptions options = options_.planner;
  options.min_gain *= kTurnOff;
  const ViewPlan plan = PlanView(model_, rig_, options_.trigger, options, request);
  if (plan.verdict != PlanVerdict::kMove) return;
  next_ = plan.path;
  next_gain_ = plan.gain;
  next_loses_ = plan.loses;
}

ActiveOutput ActiveCamera::Step(const ActiveInputs& inputs) {
  const double elapsed = started_ ? ToSeconds(inputs.now - last_step_) : 0.0;
  const double dt = std::clamp(elapsed, 0.0, kLongestStep);
  output_.trigger_value = TriggerValue(options_.trigger.measure, inputs.composite);
  trigger_ = UpdateTrigger(options_.trigger, trigger_, output_.trigger_value);
  output_.triggered = trigger_.triggered;
  if (trigger_.fired) fruitless_in_a_row_ = 0;

  if (!UsableInputs(inputs)) {
    motion_.Step(dt, true);
    output_.refusal = ActiveRefusal::kBadInputs;
  } else if (!options_.enabled) {
    output_.state = ActiveState::kDisabled;
  } else {
    FollowRig(inputs);
    SampleArm(model_, inputs.q, &sample_);
    if (options_.mode == ActiveMode::kGradient) {
      ClimbGradient(dt);
      return Publish(inputs);
    }
    Move(dt, inputs);
    const ActiveReason demand = Demand(inputs);
    // Near an arm's singularity no view raises w_c, but one may still tell better where the markers are.
    const bool certified = inputs.mm_per_px <= options_.planner.max_mm_per_px;
    if (moving_) {
      PlanOnTheWay(inputs);
    } else if (demand == ActiveReason::kNone) {
      output_.refusal = ActiveRefusal::kNone;
    } else if (inputs.cause == LowCause::kArm && certified &&
               (demand == ActiveReason::kLowMeasure || demand == ActiveReason::kStalled)) {
      output_.reason = demand;
      output_.refusal = ActiveRefusal::kArm;
    } else {
      Plan(inputs, demand);
    }
    output_.state = moving_ ? ActiveState::kMoving : ActiveState::kWatching;
  }

  return Publish(inputs);
}

const ActiveOutput& ActiveCamera::Publish(const ActiveInputs& inputs) {
  started_ = true;
  last_step_ = inputs.now;
  output_.q_c = motion_.q_c();
  output_.X_WC = RigPose(rig_, output_.q_c);
  return output_;
}

}  // namespace vantage
