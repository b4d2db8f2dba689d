#include "vantage/active/view_planner.h"

#include <algorithm>
#include <array>
#include <bitset>
#include <cassert>
#include <cmath>
#include <limits>
#include <queue>
#include <string>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "vantage/math/angles.h"
#include "vantage/math/error.h"
#include "vantage/math/spatial.h"
#include "view_candidates.h"

namespace vantage {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

// What is not seen, or singular, is worth this share of the threshold.
constexpr double kWorthless = 1e-3;
// Taken off the logarithm of a stretch in which w_c passes through 0.
constexpr double kCrossing = 1.0;
// A view that is spoilt for a reason unknown is not mended nearer to it than this [m or rad].
constexpr double kElsewhere = 0.2;
// A view is planned to certify the end with this share of the bound: the end is a prediction.
constexpr double kCertifiedShare = 0.85;
// Of a view that certifies nothing: as bad as this many times the bound.
constexpr double kUncertified = 20.0;
// How much more the certificate counts when nothing else is left to do.
constexpr double kCertifyWeight = 5.0;
// Better views whose ways are tried before giving up.
constexpr int kMaxWays = 12;
// Points of a way at which the markers are looked for: one every so many metres or radians.
constexpr double kStationSpacing = 0.12;
constexpr int kLeastStations = 6;
constexpr int kMostStations = 48;

// Logarithm of a measure at one sample; sign of det J_c where it has one, else 0.
struct SampleValue {
  double log_value{0.0};
  int sign{0};
};

// Markers of the arm, then those of the goal.
using MarkerSet = std::bitset<std::size_t{2} * kMaxPoints>;

using SampleValues = std::array<SampleValue, kMaxPathSamples>;

// Dimension that a Jacobian of a rigid end effector spans at most.
int RankBound(const TaskJacobian& J) noexcept {
  return static_cast<int>(std::min<Eigen::Index>({J.rows(), J.cols(), kTaskDimension}));
}

// JᵀJ or JJᵀ, whichever is smaller.
JointMatrix Gram(const TaskJacobian& J) noexcept {
  JointMatrix G;
  if (J.rows() < J.cols()) {
    G.noalias() = J.lazyProduct(J.transpose());
  } else {
    G.noalias() = J.transpose().lazyProduct(J);
  }
  return G;
}

SampleValue SquareValue(const TaskJacobian& J) noexcept {
  const JointMatrix square = J;
  const Eigen::PartialPivLU<JointMatrix> lu(square);
  SampleValue value;
  value.sign = lu.permutationP().determinant() > 0 ? 1 : -1;
  for (Eigen::Index i = 0; i < J.cols(); ++i) {
    const double pivot = lu.matrixLU()(i, i);
    if (pivot < 0.0) value.sign = -value.sign;
    value.log_value += std::log(std::abs(pivot));
  }
  value.log_value /= static_cast<double>(J.cols());
  return value;
}

// Logarithm of the measure; of w_c^(1/s) for w_c, so that all count alike.
SampleValue ValueOf(TriggerMeasure measure, const TaskJacobian& J) noexcept {
  SampleValue value;
  value.log_value = -std::numeric_limits<double>::infinity();
  const int s = RankBound(J);
  if (s == 0) return value;
  const bool volume =
      measure == TriggerMeasure::kGeometricMean || measure == TriggerMeasure::kCompositeW;
  if (volume && J.rows() == J.cols() && s == J.cols()) return SquareValue(J);
  const JointMatrix G = Gram(J);
  if (volume && G.rows() == s) {
    const Eigen::LLT<JointMatrix> llt(G);
    if (llt.info() != Eigen::Success) return value;
    // det G = (product of the diagonal)², w = sqrt(det G).
    value.log_value = llt.matrixLLT().diagonal().array().log().sum() / s;
    return value;
  }
  const Eigen::SelfAdjointEigenSolver<JointMatrix> eigen(G, Eigen::EigenvaluesOnly);
  const auto largest = eigen.eigenvalues().tail(s);  // ascending squares of singular values
  if (!(largest(0) > 0.0)) return value;
  if (volume) {
    value.log_value = 0.5 * largest.array().log().sum() / s;
  } else if (measure == TriggerMeasure::kSigmaMin) {
    value.log_value = 0.5 * std::log(largest(0));
  } else {
    value.log_value = 0.5 * std::log(largest(0) / largest(s - 1));
  }
  return value;
}

// Everything a plan is scored against.
class Scene {
 public:
  Scene(const ViewModel& model, const TriggerOptions& trigger, const PlannerOptions& options,
        const std::vector<ArmSample>& motion, const std::vector<PlacedMarker>& goal_markers)
      : model_(model),
        trigger_(trigger),
        options_(options),
        motion_(motion),
        goal_markers_(goal_markers) {
    assert(!motion.empty() && motion.size() <= kMaxPathSamples);
    double log_threshold = std::log(trigger.threshold);
    if (trigger.measure == TriggerMeasure::kCompositeW) {
      const auto k = static_cast<int>(model.features.features().size());
      log_threshold /= std::min({k, model.arm.size(), kTaskDimension});
    }
    highest_ = log_threshold + std::log(options.cap);
    lowest_ = log_threshold + std::log(kWorthless);
  }

  /// Makes the certificate of the motion's end count before all else.
  void Certify() { certify_ = true; }

  /// So many of the arm's markers may be missing.
  void Spare(int markers) { spare_markers_ = markers; }

  /// Leaves the goal's markers out of what must be seen; they stand in the way all the same.
  void NeglectGoal() { goal_optional_ = true; }

  /// Makes every view answer for one more configuration, right after the first.
  void AlsoSee(const ArmSample& soon) { soon_ = &soon; }

  [[nodiscard]] int size() const noexcept { return static_cast<int>(motion_.size()); }

  /// First fault of the sample's markers, beyond those that may be missing, and of the goal's that is not
  /// occlusion.
  [[nodiscard]] ViewFault Unobstructed(const ArmSample& sample, const Isometry3d& X_WC) const {
    int missing = 0;
    for (const PlacedMarker& marker : sample.markers) {
      const ViewFault fault = CheckMarkerUnobstructed(model_.camera, options_.limits, X_WC, marker);
      if (fault != ViewFault::kNone && ++missing > spare_markers_) return fault;
    }
    return GoalMarkers(X_WC);
  }

  /// By a link, or by another marker: more of the arm's than may be missing, or one of the goal's.
  [[nodiscard]] bool Hidden(const ArmSample& sample, const Isometry3d& X_WC) const {
    const Vector3d p_WC = X_WC.translation();
    const auto hidden = [&](const PlacedMarker& marker) {
      return IsHidden(p_WC, marker, sample.capsules) || IsCovered(p_WC, marker, sample.markers) ||
             IsCovered(p_WC, marker, goal_markers_);
    };
    int missing = 0;
    for (const PlacedMarker& marker : sample.markers) {
      const bool gone =
          hidden(marker) ||
          (spare_markers_ > 0 && CheckMarkerUnobstructed(model_.camera, options_.limits, X_WC,
                                                         marker) != ViewFault::kNone);
      if (gone && ++missing > spare_markers_) return true;
    }
    return !goal_optional_ && std::any_of(goal_markers_.begin(), goal_markers_.end(), hidden);
  }

  /// The markers that are seen, of those that must be.
  [[nodiscard]] MarkerSet Seen(const ArmSample& sample, const Isometry3d& X_WC) const {
    MarkerSet seen;
    const auto look = [&](const std::vector<PlacedMarker>& markers, std::size_t first) {
      for (std::size_t i = 0; i < markers.size(); ++i) {
        seen[first + i] = CheckMarkerAmong(model_.camera, options_.limits, X_WC, markers[i], sample,
                                           goal_markers_) == ViewFault::kNone;
      }
    };
    look(sample.markers, 0);
    if (!goal_optional_) look(goal_markers_, kMaxPoints);
    return seen;
  }

  [[nodiscard]] bool Sees(const ArmSample& sample, const Isometry3d& X_WC) const {
    return Unobstructed(sample, X_WC) == ViewFault::kNone && !Hidden(sample, X_WC);
  }

  /// Samples up to the first fault that is not occlusion.
  [[nodiscard]] int CountUnobstructed(const Isometry3d& X_WC, ViewFault* fault) const {
    for (int i = 0; i < size(); ++i) {
      *fault = Unobstructed(motion_[i], X_WC);
      if (*fault != ViewFault::kNone) return i;
      if (i > 0 || soon_ == nullptr) continue;
      *fault = Unobstructed(*soon_, X_WC);
      if (*fault != ViewFault::kNone) return 1;
    }
    return size();
  }

  /// Of the first `seen` samples, those up to the first at which a marker is hidden.
  [[nodiscard]] int CountNotHidden(const Isometry3d& X_WC, int seen) const {
    for (int i = 0; i < seen; ++i) {
      if (Hidden(motion_[i], X_WC)) return i;
      if (i == 0 && soon_ != nullptr && seen > 1 && Hidden(*soon_, X_WC)) return 1;
    }
    return seen;
  }

  [[nodiscard]] SampleValue ValueAt(int i, const Isometry3d& X_WC) const {
    SampleValue value = ValueOf(trigger_.measure, CompositeJacobian(model_, motion_[i], X_WC));
    value.log_value =
        std::isnan(value.log_value) ? lowest_ : std::clamp(value.log_value, lowest_, highest_);
    return value;
  }

  /// See ScoreView(). Of a motion of one sample, its value.
  [[nodiscard]] double Score(const SampleValues& values, int seen) const noexcept {
    const auto at = [&](int i) { return i < seen ? values[i].log_value : lowest_; };
    if (size() == 1) return at(0);
    double sum = 0.0;
    for (int i = 0; i + 1 < size(); ++i) {
      double stretch = 0.5 * (at(i) + at(i + 1));
      const bool crossing = i + 1 < seen && values[i].sign * values[i + 1].sign < 0;
      if (crossing) stretch -= kCrossing;
      sum += std::max(lowest_, stretch);
    }
    return sum / (size() - 1);
  }

  /// How much worse a view is because it does not certify the motion's end; 0: it does.
  [[nodiscard]] double Uncertified(const Isometry3d& X_WC) const {
    const ArmSample& end = motion_.back();
    const double mm_per_px =
        WorstMillimetresPerPixel(Decompose(CompositeJacobian(model_, end, X_WC)), end.J_marker_W);
    const double bound = kCertifiedShare * options_.max_mm_per_px;
    const double log_excess = std::log(std::clamp(mm_per_px / bound, 1.0, kUncertified));
    return (certify_ ? kCertifyWeight : 1.0) * log_excess;
  }

  [[nodiscard]] ViewScore Evaluate(const Isometry3d& X_WC) const {
    ViewScore view;
    const int unobstructed = CountUnobstructed(X_WC, &view.fault);
    view.seen = CountNotHidden(X_WC, unobstructed);
    if (view.seen < unobstructed) view.fault = ViewFault::kHidden;
    SampleValues values;
    for (int i = 0; i < view.seen; ++i) values[i] = ValueAt(i, X_WC);
    view.score = Score(values, view.seen);
    if (view.seen == size()) view.score -= Uncertified(X_WC);
    return view;
  }

  [[nodiscard]] const std::vector<ArmSample>& motion() const noexcept { return motion_; }

  /// The middle of all that must be seen: where a head looks.
  [[nodiscard]] Vector3d Aim() const {
    Vector3d lower = motion_[0].markers[0].p_W;
    Vector3d upper = lower;
    const auto include = [&](const PlacedMarker& marker) {
      lower = lower.cwiseMin(marker.p_W);
      upper = upper.cwiseMax(marker.p_W);
    };
    for (const ArmSample& sample : motion_) {
      std::for_each(sample.markers.begin(), sample.markers.end(), include);
    }
    if (!goal_optional_) std::for_each(goal_markers_.begin(), goal_markers_.end(), include);
    return 0.5 * (lower + upper);
  }

  [[nodiscard]] double lowest() const noexcept { return lowest_; }

 private:
  [[nodiscard]] ViewFault GoalMarkers(const Isometry3d& X_WC) const {
    if (goal_optional_) return ViewFault::kNone;
    for (const PlacedMarker& marker : goal_markers_) {
      const ViewFault fault = CheckMarkerUnobstructed(model_.camera, options_.limits, X_WC, marker);
      if (fault != ViewFault::kNone) return fault;
    }
    return ViewFault::kNone;
  }

  const ViewModel& model_;
  const TriggerOptions& trigger_;
  const PlannerOptions& options_;
  const std::vector<ArmSample>& motion_;
  const std::vector<PlacedMarker>& goal_markers_;
  const ArmSample* soon_{nullptr};
  bool certify_{false};
  bool goal_optional_{false};
  int spare_markers_{0};
  double highest_{0.0}, lowest_{0.0};
};

// One view under consideration. Before occlusion is checked `view` may promise too much.
struct Candidate {
  RigVector q_c;
  Isometry3d X_WC;
  SampleValues values;
  ViewScore view;
  double uncertified{0.0};
  double travel{0.0};   // [m + rad]
  double worth{0.0};    // score less the cost of travel
  bool checked{false};  // for occlusion
};

struct LessWorth {
  bool operator()(const Candidate* a, const Candidate* b) const noexcept {
    return a->worth < b->worth;
  }
};

// Scores views of one request.
class Search {
 public:
  Search(const Scene& scene, const CameraRig& rig, const PlannerOptions& options,
         const RigVector& from)
      : scene_(scene), rig_(rig), options_(options), X_WFrom_(RigPose(rig, from)) {}

  /// Scores everything but occlusion.
  [[nodiscard]] Candidate Open(const RigVector& q_c) {
    ++scored_;
    Candidate c;
    c.q_c = q_c;
    c.X_WC = RigPose(rig_, q_c);
    c.travel = (c.X_WC.translation() - X_WFrom_.translation()).norm() +
               AngleBetween(X_WFrom_.linear(), c.X_WC.linear());
    c.view.seen = scene_.CountUnobstructed(c.X_WC, &c.view.fault);
    for (int i = 0; i < c.view.seen; ++i) c.values[i] = scene_.ValueAt(i, c.X_WC);
    if (c.view.seen == scene_.size()) c.uncertified = scene_.Uncertified(c.X_WC);
    Rate(&c);
    return c;
  }

  /// Checks for occlusion; the worth may fall.
  void Close(Candidate* c) const {
    c->checked = true;
    const int seen = scene_.CountNotHidden(c->X_WC, c->view.seen);
    if (seen == c->view.seen) return;
    c->view.seen = seen;
    c->view.fault = ViewFault::kHidden;
    Rate(c);
  }

  [[nodiscard]] int scored() const noexcept { return scored_; }

 private:
  void Rate(Candidate* c) const {
    c->view.score = scene_.Score(c->values, c->view.seen);
    if (c->view.seen == scene_.size()) c->view.score -= c->uncertified;
    c->worth = c->view.score - options_.travel_cost * c->travel;
  }

  const Scene& scene_;
  const CameraRig& rig_;
  const PlannerOptions& options_;
  Isometry3d X_WFrom_;
  int scored_{0};
};

// True when every feature row is a coordinate of a point and both coordinates of each point are in:
// then w_c does not depend on the roll, with square pixels.
bool IgnoresRoll(const ViewModel& model) {
  if (model.camera.fx != model.camera.fy || model.camera.skew != 0.0) return false;
  std::array<int, kMaxPoints> axes{};
  for (const Feature& feature : model.features.features()) {
    if (feature.kind == FeatureKind::kPointX) {
      axes[feature.points[0]] |= 1;
    } else if (feature.kind == FeatureKind::kPointY) {
      axes[feature.points[0]] |= 2;
    } else {
      return false;
    }
  }
  return std::all_of(axes.begin(), axes.end(), [](int both) { return both == 0 || both == 3; });
}

// All views over the workspace, each with the best of its rolls.
std::vector<Candidate> OpenWorkspace(const CameraRig& rig, const RigVector& from,
                                     const Vector3d& aim_W, int count, bool roll_matters,
                                     const Scene& scene, Search* search) {
  std::vector<Candidate> open;
  open.reserve(static_cast<std::size_t>(count) + 1);
  const std::vector<double> rolls = OtherRolls(rig, from);
  const int roll_axis = HeadOf(rig).roll;
  for (const RigVector& position : CandidatePositions(rig, from, aim_W, count)) {
    Candidate best = search->Open(position);
    // A roll also turns the frame of the image round the markers.
    if (roll_matters || best.view.seen < scene.size()) {
      for (const double roll : rolls) {
        RigVector rolled = position;
        rolled(roll_axis) = roll;
        const Candidate other = search->Open(rolled);
        if (other.worth > best.worth) best = other;
      }
    }
    open.push_back(best);
  }
  return open;
}

// Climbs from a view by single steps along the axes, which become smaller.
Candidate Refine(const CameraRig& rig, const Vector3d& aim_W, Candidate best, Search* search) {
  for (const double scale : {1.0, 1.0, 0.5, 0.5, 0.25, 0.25}) {
    Candidate better = best;
    for (const RigVector& q_c : Neighbours(rig, best.q_c, aim_W, scale)) {
      Candidate neighbour = search->Open(q_c);
      if (neighbour.worth <= better.worth) continue;
      search->Close(&neighbour);
      if (neighbour.worth > better.worth) better = neighbour;
    }
    best = better;
  }
  return best;
}

// How often a marker that was seen is not seen any more at the stations of a way, given where the arm is
// by then.
int CountLosses(const Scene& scene, const CameraRig& rig, const RigMotion& motion,
                double progress_rate, MarkerSet seen, int seen_at_end) {
  const RigPath& path = motion.path();
  const double length = path.Length();
  const int stations =
      std::clamp(static_cast<int>(length / kStationSpacing), kLeastStations, kMostStations);
  int losses = 0;
  for (int i = 1; i <= stations; ++i) {
    const double s = static_cast<double>(i) / stations;
    const double progress = 1.0 - std::exp(-progress_rate * motion.TimeAt(s));
    const int last = std::max(0, std::min(scene.size(), seen_at_end) - 1);
    const int sample = std::min(last, static_cast<int>(std::lround(progress * (scene.size() - 1))));
    const MarkerSet now = scene.Seen(scene.motion()[sample], RigPose(rig, path.At(s)));
    losses += static_cast<int>((seen & ~now).count());
    seen = now;
  }
  return losses;
}

struct Way {
  RigPath path;
  double duration{0.0};
  int losses{0};
  bool found{false};
};

// The fastest way that loses no marker; where some may be lost, the one with the fewest losses.
Way FindWay(const Scene& scene, const CameraRig& rig, const PlanRequest& request,
            const Vector3d& aim_W, const Candidate& to, const MarkerSet& seen_at_start) {
  Way best;
  for (const RigPath& path : PathsBetween(rig, request.q_c, to.q_c, aim_W)) {
    const RigMotion motion(rig, path);
    const bool slower = best.found && motion.duration() >= best.duration;
    if (slower && best.losses == 0) continue;
    const int losses =
        CountLosses(scene, rig, motion, request.progress_rate, seen_at_start, to.view.seen);
    if (losses > 0 && !request.may_lose) continue;
    if (best.found && (losses > best.losses || (losses == best.losses && slower))) continue;
    best = {path, motion.duration(), losses, true};
  }
  return best;
}

}  // namespace

void Validate(const PlannerOptions& options) {
  const auto refuse = [](const char* key, const std::string& reason) {
    throw ConfigError("", std::string("active.planner.") + key, reason);
  };
  if (options.candidates < 8) {
    refuse("candidates", "must be >= 8, is " + std::to_string(options.candidates));
  }
  if (options.path_samples < 1 || options.path_samples > kMaxPathSamples) {
    refuse("path_samples", "must be in [1, " + std::to_string(kMaxPathSamples) + "], is " +
                               std::to_string(options.path_samples));
  }
  if (!(options.travel_cost >= 0.0) || !std::isfinite(options.travel_cost)) {
    refuse("travel_cost", "must be >= 0 per m or rad, is " + std::to_string(options.travel_cost));
  }
  if (!(options.cap > 1.0) || !std::isfinite(options.cap)) {
    refuse("cap", "must be > 1, is " + std::to_string(options.cap));
  }
  if (!(options.min_gain >= 0.0) || !std::isfinite(options.min_gain)) {
    refuse("min_gain", "must be >= 0, is " + std::to_string(options.min_gain));
  }
  if (!(options.max_mm_per_px > 0.0)) {
    refuse("max_mm_per_px", "must be > 0 mm/px, is " + std::to_string(options.max_mm_per_px));
  }
  const ViewLimits& limits = options.limits;
  if (!(limits.margin >= 0.0) || !std::isfinite(limits.margin)) {
    refuse("limits.margin", "must be >= 0 px, is " + std::to_string(limits.margin));
  }
  if (!(limits.min_depth > 0.0) || !std::isfinite(limits.min_depth)) {
    refuse("limits.min_depth", "must be > 0 m, is " + std::to_string(limits.min_depth));
  }
  if (!(limits.max_depth > limits.min_depth)) {
    refuse("limits.max_depth", "must be > min_depth, is " + std::to_string(limits.max_depth));
  }
  if (!(limits.max_incidence > 0.0 && limits.max_incidence < kPi / 2.0)) {
    refuse("limits.max_incidence",
           "must be in (0, pi/2) rad, is " + std::to_string(limits.max_incidence));
  }
  if (!(limits.min_semi_axis >= 0.0) || !std::isfinite(limits.min_semi_axis)) {
    refuse("limits.min_semi_axis", "must be >= 0 px, is " + std::to_string(limits.min_semi_axis));
  }
}

std::vector<ArmSample> SampleMotion(const ViewModel& model, const JointVector& q,
                                    const JointVector& q_goal, int samples) {
  const bool still = samples == 1 || (q_goal - q).cwiseAbs().maxCoeff() < 1e-6;
  const int count = still ? 1 : samples;
  std::vector<ArmSample> motion(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    const double share = count == 1 ? 0.0 : static_cast<double>(i) / (count - 1);
    SampleArm(model, q + share * (q_goal - q), &motion[i]);
  }
  return motion;
}

ViewScore ScoreView(const ViewModel& model, const TriggerOptions& trigger,
                    const PlannerOptions& options, const std::vector<ArmSample>& motion,
                    const std::vector<PlacedMarker>& goal_markers, const Isometry3d& X_WC) {
  return Scene(model, trigger, options, motion, goal_markers).Evaluate(X_WC);
}

bool CanWatch(const ViewModel& model, const CameraRig& rig, const PlannerOptions& options,
              const std::vector<ArmSample>& motion, const std::vector<PlacedMarker>& goal_markers,
              const RigVector& q_c) {
  const TriggerOptions trigger;
  const Scene scene(model, trigger, options, motion, goal_markers);
  const auto watches = [&](const RigVector& view) {
    const Isometry3d X_WC = RigPose(rig, view);
    return std::all_of(motion.begin(), motion.end(),
                       [&](const ArmSample& sample) { return scene.Sees(sample, X_WC); });
  };
  if (watches(q_c)) return true;
  const std::vector<RigVector> views =
      CandidatePositions(rig, q_c, scene.Aim(), options.candidates);
  return std::any_of(views.begin(), views.end(), watches);
}

ViewPlan PlanView(const ViewModel& model, const CameraRig& rig, const TriggerOptions& trigger,
                  const PlannerOptions& options, const PlanRequest& request) {
  assert(request.q.size() == model.arm.size() && request.q_goal.size() == model.arm.size());
  assert(request.q_c.size() == rig.size() && request.q_c_stay.size() == rig.size());
  const std::vector<ArmSample> motion =
      SampleMotion(model, request.q, request.q_goal, options.path_samples);
  Scene scene(model, trigger, options, motion, request.goal_markers);
  ArmSample soon;
  if (request.q_soon.size() == model.arm.size()) {
    SampleArm(model, request.q_soon, &soon);
    scene.AlsoSee(soon);
  }
  if (request.certify) scene.Certify();
  if (request.goal_optional) scene.NeglectGoal();
  scene.Spare(request.spare_markers);

  ViewPlan plan;
  const Isometry3d X_WStay = RigPose(rig, request.q_c_stay);
  plan.stay = scene.Evaluate(X_WStay);
  if (!CanMove(rig)) {
    plan.verdict = PlanVerdict::kRigCannotMove;
    return plan;
  }
  const double stay_score = request.stay_is_spoiled ? scene.lowest() : plan.stay.score;
  const double wanted = stay_score + std::log1p(options.min_gain);
  const MarkerSet seen_at_start = scene.Seen(motion[0], RigPose(rig, request.q_c));

  const Vector3d aim_W = scene.Aim();
  Search search(scene, rig, options, request.q_c);
  std::vector<Candidate> open = OpenWorkspace(rig, request.q_c, aim_W, options.candidates,
                                              !IgnoresRoll(model), scene, &search);
  const auto spoils = [](const Candidate& c, const Isometry3d& X_WSpoiled) {
    return (c.X_WC.translation() - X_WSpoiled.translation()).norm() +
               AngleBetween(X_WSpoiled.linear(), c.X_WC.linear()) <
           kElsewhere;
  };
  const auto far_enough = [&](const Candidate& c) {
    if (request.stay_is_spoiled && spoils(c, X_WStay)) return false;
    return std::none_of(request.X_WSpoiled.begin(), request.X_WSpoiled.end(),
                        [&](const Isometry3d& X_WSpoiled) { return spoils(c, X_WSpoiled); });
  };
  std::priority_queue<Candidate*, std::vector<Candidate*>, LessWorth> queue;
  for (Candidate& c : open) {
    if (c.view.seen > 0 && far_enough(c)) queue.push(&c);
  }

  // Best first; occlusion is checked only of what would be taken.
  bool any_view = plan.stay.seen > 0 && !request.stay_is_spoiled;
  bool any_better = false;
  Candidate refined;
  for (int ways = 0; !queue.empty() && ways < kMaxWays;) {
    Candidate* best = queue.top();
    queue.pop();
    if (!best->checked) {
      search.Close(best);
      if (best->view.seen > 0) queue.push(best);
      continue;
    }
    any_view = true;
    if (ways == 0) {
      refined = Refine(rig, aim_W, *best, &search);
      if (refined.worth > best->worth && far_enough(refined)) {
        queue.push(best);
        best = &refined;
      }
    }
    if (best->worth < wanted) break;
    any_better = true;
    ++ways;
    const Way way = FindWay(scene, rig, request, aim_W, *best, seen_at_start);
    if (!way.found) continue;
    plan.verdict = PlanVerdict::kMove;
    plan.path = way.path;
    plan.duration = way.duration;
    plan.loses = way.losses > 0;
    plan.move = best->view;
    plan.gain = std::expm1(best->view.score - stay_score);
    plan.views_scored = search.scored();
    return plan;
  }
  plan.views_scored = search.scored();
  plan.verdict =
      any_better ? PlanVerdict::kNoPath : (any_view ? PlanVerdict::kNoGain : PlanVerdict::kNoView);
  return plan;
}

}  // namespace vantage
