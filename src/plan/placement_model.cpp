#include "vantage/plan/placement_model.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>

#include "vantage/math/angles.h"
#include "vantage/math/error.h"

namespace vantage {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// Stands for the logarithm of nothing.
constexpr double kWorthless = -1e4;

[[noreturn]] void Refuse(const std::string& key, const std::string& reason) {
  throw ConfigError("", key, reason);
}

void Check(const PlacementProblem& problem) {
  Validate(problem.rig);
  if (problem.motion.size() == 0) Refuse("motion", "needs a sample");
  const std::size_t arm_markers = problem.motion.samples.front().markers.size();
  if (arm_markers == 0) Refuse("markers", "needs one on the arm");
  if (problem.q_c_start.size() != problem.rig.size()) {
    Refuse("camera_rig", "start must have " + std::to_string(problem.rig.size()) +
                             " coordinates, has " + std::to_string(problem.q_c_start.size()));
  }
  const PlanObjective& objective = problem.objective;
  if (!(objective.k_v >= 0.0) || !(objective.k_r >= 0.0) || !std::isfinite(objective.k_v) ||
      !std::isfinite(objective.k_r)) {
    Refuse("objective", "k_v and k_r must be >= 0, are " + std::to_string(objective.k_v) + " and " +
                            std::to_string(objective.k_r));
  }
  const bool sum = objective.quantity == PlanQuantity::kWeightedSum ||
                   objective.quantity == PlanQuantity::kProduct;
  if (sum && objective.aggregate == PlanAggregate::kWorst) {
    Refuse("objective.over", "the worst case is of w_c or w_v, not of eq. 23");
  }
  if (sum && objective.measure != BatchMeasure::kW && objective.measure != BatchMeasure::kLogW) {
    Refuse("objective.measure", "eq. 23 has w or log w");
  }
  const std::size_t all_markers = arm_markers + problem.scene_markers.size();
  if (all_markers > kMaxPoints) {
    Refuse("markers", "of arm and scene must be " + std::to_string(kMaxPoints) + " at most, are " +
                          std::to_string(all_markers));
  }
  const PlanLimits& limits = problem.limits;
  if (!(limits.depth.min > 0.0) || !(limits.depth.max > limits.depth.min)) {
    Refuse("limits.max_depth", "must be above min_depth, and that above 0 m; they are " +
                                   std::to_string(limits.depth.max) + " m and " +
                                   std::to_string(limits.depth.min) + " m");
  }
  if (limits.focus && !(limits.focus->max > limits.focus->min)) {
    Refuse("limits.focus", "must end farther than it begins, is " +
                               std::to_string(limits.focus->min) + " m to " +
                               std::to_string(limits.focus->max) + " m");
  }
  const auto refuse_value = [](const char* key, const char* bound, double value) {
    Refuse(key, std::string("must be ") + bound + ", is " + std::to_string(value));
  };
  if (!(limits.max_incidence > 0.0)) {
    refuse_value("limits.max_incidence", "> 0 rad", limits.max_incidence);
  }
  const auto length = [&](const char* key, double value) {
    if (!(value >= 0.0 && std::isfinite(value))) refuse_value(key, ">= 0 m and finite", value);
  };
  length("limits.rim", limits.rim);
  length("limits.clearance", limits.clearance);
  const PoseUncertainty& uncertainty = problem.uncertainty;
  if (!(uncertainty.position >= 0.0 && std::isfinite(uncertainty.position)) ||
      !(uncertainty.rotation >= 0.0 && std::isfinite(uncertainty.rotation))) {
    Refuse("robust", "standard deviations must be >= 0, are " +
                         std::to_string(uncertainty.position) + " m and " +
                         std::to_string(uncertainty.rotation) + " rad");
  }
}

DepthLimits Tighter(const PlanLimits& limits) {
  DepthLimits depth = limits.depth;
  if (limits.focus) {
    depth.min = std::max(depth.min, limits.focus->min);
    depth.max = std::min(depth.max, limits.focus->max);
  }
  if (!(depth.max > depth.min)) {
    Refuse("limits.focus", "ends before the least depth or begins behind the greatest: from " +
                               std::to_string(depth.min) + " m to " + std::to_string(depth.max) +
                               " m is left");
  }
  return depth;
}

// Points that stand for a normal distribution of poses: the mean over them is that over the distribution
// to the third order (spherical cubature: I. Arasaratnam, S. Haykin, "Cubature Kalman filters", IEEE
// Trans. Automatic Control 54(6), 2009). For the worst case, two standard deviations each way.
std::vector<Isometry3d> OffsetsOf(const PoseUncertainty& uncertainty) {
  std::vector<Isometry3d> offsets{Isometry3d::Identity()};
  if (uncertainty.none()) return offsets;
  const int axes = (uncertainty.position > 0.0 ? 3 : 0) + (uncertainty.rotation > 0.0 ? 3 : 0);
  const double reach = uncertainty.worst ? 2.0 : std::sqrt(static_cast<double>(axes));
  for (int i = 0; i < 6; ++i) {
    const double sigma = i < 3 ? uncertainty.position : uncertainty.rotation;
    if (sigma == 0.0) continue;
    for (const double sign : {1.0, -1.0}) {
      Twist step = Twist::Zero();
      step(i) = sign * reach * sigma;
      offsets.push_back(Advance(Isometry3d::Identity(), step));
    }
  }
  return offsets;
}

PointJacobian ViewColumns(ViewTask task, const Vector3d& p_EP_W) {
  PointJacobian J(3, task == ViewTask::kBody ? 6 : task == ViewTask::kPlane ? 2 : 3);
  J.setZero();
  const Eigen::Index translations = std::min<Eigen::Index>(3, J.cols());
  J.leftCols(translations) = Eigen::Matrix3d::Identity().leftCols(translations);
  if (task == ViewTask::kBody) J.rightCols<3>() = -Skew(p_EP_W);
  return J;
}

Measure ArmMeasure(ViewTask task, const ArmJacobian& J_r) {
  const int rows = task == ViewTask::kBody ? 6 : task == ViewTask::kPlane ? 2 : 3;
  const TaskJacobian J = J_r.topRows(rows);
  return MeasureOf(J, rows);
}

bool Composite(const PlanObjective& objective) {
  return objective.quantity == PlanQuantity::kComposite;
}

BatchSample SampleOf(const PlanObjective& objective, const ArmSample& arm, double weight) {
  BatchSample sample;
  sample.weight = weight;
  const Vector3d p_WE = arm.kinematics.X_WE.translation();
  for (std::size_t j = 0; j < arm.markers.size(); ++j) {
    sample.p_W.push_back(arm.markers[j].p_W);
    sample.J_p_W.push_back(Composite(objective)
                               ? arm.J_marker_W[j]
                               : ViewColumns(objective.task, arm.markers[j].p_W - p_WE));
  }
  if (objective.quantity == PlanQuantity::kProduct && objective.measure == BatchMeasure::kW) {
    sample.weight *= ArmMeasure(objective.task, arm.kinematics.J_WE_W).w;
  }
  return sample;
}

// What the arm adds whatever the camera does.
double ArmShare(const PlanObjective& objective, const ArmMotion& motion) {
  const bool logarithm = objective.measure == BatchMeasure::kLogW;
  double factor = 0.0;
  if (objective.quantity == PlanQuantity::kWeightedSum) factor = objective.k_r;
  if (objective.quantity == PlanQuantity::kProduct && logarithm) factor = 1.0;
  if (factor == 0.0) return 0.0;
  double sum = 0.0;
  for (int i = 0; i < motion.size(); ++i) {
    const Measure arm = ArmMeasure(objective.task, motion.samples[i].kinematics.J_WE_W);
    sum += motion.weight[i] * (logarithm ? arm.log_w : arm.w);
  }
  return factor * sum;
}

Vector3d Centre(const ArmMotion& motion) {
  Vector3d low = motion.samples.front().markers.front().p_W, high = low;
  for (const ArmSample& sample : motion.samples) {
    for (const PlacedMarker& marker : sample.markers) {
      low = low.cwiseMin(marker.p_W);
      high = high.cwiseMax(marker.p_W);
    }
  }
  return 0.5 * (low + high);
}

double UnitOf(const PlacementProblem& problem, const Vector3d& centre_W) {
  const CameraRig& rig = problem.rig;
  RigVector middle = problem.q_c_start;
  for (int i = 0; i < rig.size(); ++i) {
    middle(i) = 0.5 * (rig.axes[i].lower + rig.axes[i].upper);
  }
  const double distance = (RigPose(rig, middle).translation() - centre_W).norm();
  return std::max(distance, 10.0 * kMinDepth);
}

std::vector<BatchSample> SamplesOf(const PlacementProblem& problem) {
  std::vector<BatchSample> samples;
  for (int i = 0; i < problem.motion.size(); ++i) {
    samples.push_back(
        SampleOf(problem.objective, problem.motion.samples[i], problem.motion.weight[i]));
  }
  return samples;
}

bool NeedsObstacles(const PlacementProblem& problem) {
  const PlanLimits& limits = problem.limits;
  const bool links = limits.occlusion && !problem.motion.samples.front().capsules.empty();
  return links || !limits.boxes.empty() || limits.max_incidence < kPi;
}

// Points alone: nothing is measured of them.
std::unique_ptr<BatchScene> PointsOf(const PlacementProblem& problem, int first, int count,
                                     double unit) {
  if (problem.scene_markers.empty()) return nullptr;
  std::vector<BatchSample> samples;
  for (int i = first; i < first + count; ++i) {
    BatchSample sample;
    for (const PlacedMarker& marker : problem.motion.samples[i].markers) {
      sample.p_W.push_back(marker.p_W);
    }
    for (const PlacedMarker& marker : problem.scene_markers) sample.p_W.push_back(marker.p_W);
    sample.J_p_W.assign(sample.p_W.size(), PointJacobian::Zero(3, 1));
    samples.push_back(std::move(sample));
  }
  return std::make_unique<BatchScene>(std::move(samples), BatchBody::kFree,
                                      std::vector<BatchRow>{{0, 0}}, unit);
}

void AppendSights(const PlacementProblem& problem, const ArmSample& sample,
                  std::vector<BatchSight>* sights) {
  const PlanLimits& limits = problem.limits;
  std::vector<PlacedMarker> markers = sample.markers;
  markers.insert(markers.end(), problem.scene_markers.begin(), problem.scene_markers.end());
  for (const PlacedMarker& marker : markers) {
    BatchSight sight;
    sight.p_W = SightOf(marker);
    sight.normal_W = marker.normal_W;
    if (limits.occlusion) {
      for (const PlacedCapsule& capsule : sample.capsules) {
        const std::optional<PlacedCapsule> body = ObstacleTo(marker, capsule);
        if (body) sight.capsules.push_back({body->p_WA, body->p_WB, body->radius});
      }
    }
    sights->push_back(std::move(sight));
  }
}

BatchObstacles ObstaclesOf(const PlacementProblem& problem, int first, int count, double unit) {
  std::vector<BatchSight> sights;
  for (int i = first; i < first + count; ++i) {
    AppendSights(problem, problem.motion.samples[i], &sights);
  }
  return {std::move(sights), problem.limits.boxes, problem.limits.max_incidence, unit};
}

std::unique_ptr<BatchObstacles> ObstaclesOf(const PlacementProblem& problem, double unit) {
  if (!NeedsObstacles(problem)) return nullptr;
  return std::make_unique<BatchObstacles>(ObstaclesOf(problem, 0, problem.motion.size(), unit));
}

PlacementProblem Checked(PlacementProblem problem) {
  Check(problem);
  return problem;
}

}  // namespace

struct PlacementModel::Lazy {
  std::once_flag views_made, obstacles_made;
  std::vector<SampleView> views;
  std::vector<BatchObstacles> obstacles;
};

const char* Name(PlanLimit limit) noexcept {
  switch (limit) {
    case PlanLimit::kNear:
      return "least depth";
    case PlanLimit::kFar:
      return "greatest depth";
    case PlanLimit::kImage:
      return "field of view";
    case PlanLimit::kHidden:
      return "occlusion";
    case PlanLimit::kFacing:
      return "facing of markers";
    case PlanLimit::kKeepOut:
      return "keep-out box";
  }
  return "?";
}

PlacementModel::PlacementModel(PlacementProblem problem)
    : problem_(Checked(std::move(problem))),
      depth_(Tighter(problem_.limits)),
      offsets_(OffsetsOf(problem_.uncertainty)),
      unit_(UnitOf(problem_, Centre(problem_.motion))),
      centre_W_(Centre(problem_.motion)),
      scene_(SamplesOf(problem_), BatchBody::kRigid, problem_.rows, unit_),
      points_(PointsOf(problem_, 0, problem_.motion.size(), unit_)),
      obstacles_(ObstaclesOf(problem_, unit_)),
      lazy_(std::make_unique<Lazy>()) {
  // A ball is inside a half space when its centre is by its radius; the margin of a point counts along the
  // optical axis.
  const BatchLens& lens = problem_.lens;
  const double x_half = 0.5 * (lens.x_max - lens.x_min), y_half = 0.5 * (lens.y_max - lens.y_min);
  rim_margin_ =
      problem_.limits.rim *
      std::max({std::hypot(1.0, lens.x_min) / x_half, std::hypot(1.0, lens.x_max) / x_half,
                std::hypot(1.0, lens.y_min) / y_half, std::hypot(1.0, lens.y_max) / y_half});
  constant_ = ArmShare(problem_.objective, problem_.motion);
  if (problem_.objective.quantity == PlanQuantity::kWeightedSum) factor_ = problem_.objective.k_v;
}

PlacementModel::~PlacementModel() = default;
PlacementModel::PlacementModel(PlacementModel&&) noexcept = default;

const PlacedMarker& PlacementModel::marker(int sample, int j) const noexcept {
  const std::vector<PlacedMarker>& own = problem_.motion.samples[sample].markers;
  const auto count = static_cast<int>(own.size());
  return j < count ? own[j] : problem_.scene_markers[j - count];
}

int PlacementModel::markers() const noexcept {
  return static_cast<int>(problem_.motion.samples.front().markers.size() +
                          problem_.scene_markers.size());
}

double PlacementModel::Value(double score) const noexcept {
  // 0 times the logarithm of nothing is nothing.
  return constant_ + (factor_ == 0.0 ? 0.0 : factor_ * score);
}

double PlacementModel::Merit(double score) const noexcept {
  double merit = 0.0;
  switch (problem_.objective.measure) {
    case BatchMeasure::kLogW:
      merit = problem_.objective.aggregate == PlanAggregate::kWorst ? score
                                                                    : score / scene_.total_weight();
      break;
    case BatchMeasure::kNegativeTrace:
      merit = -std::log(-score);
      break;
    default:
      merit = std::log(score);
  }
  return merit > kWorthless ? merit : kWorthless;
}

double PlacementModel::Violation(const PlanMargins& margins) const noexcept {
  double sum = 0.0;
  for (const double margin : margins) sum += std::max(0.0, -margin);
  return sum / unit_;
}

std::string PlacementModel::NameOf(PlanLimit limit) const {
  if (limit == PlanLimit::kNear && depth_.min > problem_.limits.depth.min) return "focus, near end";
  if (limit == PlanLimit::kFar && depth_.max < problem_.limits.depth.max) return "focus, far end";
  return Name(limit);
}

const std::vector<PlacementModel::SampleView>& PlacementModel::sample_views() const {
  std::call_once(lazy_->views_made, [this] {
    for (int i = 0; i < problem_.motion.size(); ++i) {
      std::vector<BatchSample> one{SampleOf(problem_.objective, problem_.motion.samples[i], 1.0)};
      lazy_->views.push_back({BatchScene(std::move(one), BatchBody::kRigid, problem_.rows, unit_),
                              PointsOf(problem_, i, 1, unit_)});
    }
  });
  return lazy_->views;
}

const std::vector<BatchObstacles>& PlacementModel::sample_obstacles() const {
  std::call_once(lazy_->obstacles_made, [this] {
    if (obstacles_ == nullptr) return;
    for (int i = 0; i < problem_.motion.size(); ++i) {
      lazy_->obstacles.push_back(ObstaclesOf(problem_, i, 1, unit_));
    }
  });
  return lazy_->obstacles;
}

double DistanceToBox(const BatchBox& box, const Vector3d& p_W) noexcept {
  const Vector3d p_B = box.X_WB.linear().transpose() * (p_W - box.X_WB.translation());
  const Vector3d beyond = p_B.cwiseAbs() - box.half;
  return beyond.cwiseMax(0.0).norm() + std::min(0.0, beyond.maxCoeff());
}

void CameraScorer::Load(const std::vector<Isometry3d>& X_WC) {
  const std::vector<Isometry3d>& offsets = model_.offsets();
  count_ = static_cast<int>(X_WC.size());
  cameras_.Resize(count_ * static_cast<int>(offsets.size()));
  p_WC_.resize(X_WC.size());
  int entry = 0;
  for (int i = 0; i < count_; ++i) {
    p_WC_[i] = X_WC[i].translation();
    cameras_.Set(entry++, X_WC[i]);
    for (std::size_t j = 1; j < offsets.size(); ++j) cameras_.Set(entry++, X_WC[i] * offsets[j]);
  }
}

void CameraScorer::Frustum(BatchPrecision precision, std::vector<PlanMargins>* margins) {
  const int poses = static_cast<int>(model_.offsets().size());
  evaluator_.CheckFrustum(model_.points(), cameras_, 0, count_ * poses, model_.problem().lens,
                          model_.depth(), precision, &batch_margins_, model_.rim_margin());
  PlanMargins open;
  open.fill(kInfinity);
  margins->resize(count_, open);
  const PlanLimits& limits = model_.problem().limits;
  for (int i = 0; i < count_; ++i) {
    PlanMargins& m = (*margins)[i];
    m = open;
    for (int j = i * poses; j < (i + 1) * poses; ++j) {
      Tighten(PlanLimit::kNear, batch_margins_.near[j], &m);
      Tighten(PlanLimit::kFar, batch_margins_.far[j], &m);
      Tighten(PlanLimit::kImage, batch_margins_.image[j], &m);
    }
    for (const BatchBox& box : limits.keep_out) {
      Tighten(PlanLimit::kKeepOut, DistanceToBox(box, p_WC_[i]) - limits.clearance, &m);
    }
  }
}

void CameraScorer::Obstacles(BatchPrecision precision, std::vector<PlanMargins>* margins) {
  if (model_.obstacles() == nullptr) return;
  const int poses = static_cast<int>(model_.offsets().size());
  evaluator_.CheckObstacles(*model_.obstacles(), cameras_, 0, count_ * poses, precision,
                            &batch_margins_);
  for (int i = 0; i < count_; ++i) {
    PlanMargins& m = (*margins)[i];
    m[IndexOf(PlanLimit::kHidden)] = m[IndexOf(PlanLimit::kFacing)] = kInfinity;
    for (int j = i * poses; j < (i + 1) * poses; ++j) {
      Tighten(PlanLimit::kHidden, batch_margins_.occlusion[j], &m);
      Tighten(PlanLimit::kFacing, batch_margins_.facing[j], &m);
    }
  }
}

void CameraScorer::Scores(BatchPrecision precision, std::vector<double>* scores) {
  const int poses = static_cast<int>(model_.offsets().size());
  const PlanObjective& objective = model_.problem().objective;
  const bool worst_sample = objective.aggregate == PlanAggregate::kWorst;
  evaluator_.Score(model_.scene(), cameras_, 0, count_ * poses, model_.problem().lens,
                   objective.measure, precision, worst_sample, &batch_scores_);
  evaluations_ += static_cast<std::int64_t>(count_) * poses * model_.problem().motion.size();
  const std::vector<double>& all = worst_sample ? batch_scores_.least : batch_scores_.sum;
  scores->resize(count_);
  const bool worst_pose = model_.problem().uncertainty.worst;
  for (int i = 0; i < count_; ++i) {
    const double* own = all.data() + static_cast<std::ptrdiff_t>(i) * poses;
    if (poses == 1) {
      (*scores)[i] = own[0];
    } else if (worst_pose) {
      (*scores)[i] = *std::min_element(own, own + poses);
    } else {
      double sum = 0.0;
      for (int j = 1; j < poses; ++j) sum += own[j];
      (*scores)[i] = sum / (poses - 1);
    }
  }
}

}  // namespace vantage
