#include "view_scene.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>

namespace vantage {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

// What is not seen, or singular, is worth this share of the threshold.
constexpr double kWorthless = 1e-3;
// Taken off the logarithm of a stretch in which w_c passes through 0.
constexpr double kCrossing = 1.0;
// A view is planned to certify the end with this share of the bound: the end is a prediction.
constexpr double kCertifiedShare = 0.85;
// Of a view that certifies nothing: as bad as this many times the bound.
constexpr double kUncertified = 20.0;
// How much more the certificate counts when nothing else is left to do.
constexpr double kCertifyWeight = 5.0;

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

}  // namespace

ViewScene::ViewScene(const ViewModel& model, const TriggerOptions& trigger,
                     const PlannerOptions& options, const std::vector<ArmSample>& motion,
                     const std::vector<PlacedMarker>& goal_markers)
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

ViewFault ViewScene::Unobstructed(const ArmSample& sample, const Isometry3d& X_WC) const {
  int missing = 0;
  for (const PlacedMarker& marker : sample.markers) {
    const ViewFault fault = CheckMarkerUnobstructed(model_.camera, options_.limits, X_WC, marker);
    if (fault != ViewFault::kNone && ++missing > spare_markers_) return fault;
  }
  if (goal_optional_) return ViewFault::kNone;
  for (const PlacedMarker& marker : goal_markers_) {
    const ViewFault fault = CheckMarkerUnobstructed(model_.camera, options_.limits, X_WC, marker);
    if (fault != ViewFault::kNone) return fault;
  }
  return ViewFault::kNone;
}

bool ViewScene::Hidden(const ArmSample& sample, const Isometry3d& X_WC) const {
  const Vector3d p_WC = X_WC.translation();
  const auto hidden = [&](const PlacedMarker& marker) {
    return IsHidden(p_WC, marker, sample.capsules) || IsCovered(p_WC, marker, sample.markers) ||
           IsCovered(p_WC, marker, goal_markers_);
  };
  int missing = 0;
  for (const PlacedMarker& marker : sample.markers) {
    const bool gone = hidden(marker) || (spare_markers_ > 0 &&
                                         CheckMarkerUnobstructed(model_.camera, options_.limits,
                                                                 X_WC, marker) != ViewFault::kNone);
    if (gone && ++missing > spare_markers_) return true;
  }
  return !goal_optional_ && std::any_of(goal_markers_.begin(), goal_markers_.end(), hidden);
}

MarkerSet ViewScene::Seen(const ArmSample& sample, const Isometry3d& X_WC) const {
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

bool ViewScene::Sees(const ArmSample& sample, const Isometry3d& X_WC) const {
  return Unobstructed(sample, X_WC) == ViewFault::kNone && !Hidden(sample, X_WC);
}

int ViewScene::CountUnobstructed(const Isometry3d& X_WC, ViewFault* fault) const {
  for (int i = 0; i < size(); ++i) {
    *fault = Unobstructed(motion_[i], X_WC);
    if (*fault != ViewFault::kNone) return i;
    if (i > 0 || soon_ == nullptr) continue;
    *fault = Unobstructed(*soon_, X_WC);
    if (*fault != ViewFault::kNone) return 1;
  }
  return size();
}

int ViewScene::CountNotHidden(const Isometry3d& X_WC, int seen) const {
  for (int i = 0; i < seen; ++i) {
    if (Hidden(motion_[i], X_WC)) return i;
    if (i == 0 && soon_ != nullptr && seen > 1 && Hidden(*soon_, X_WC)) return 1;
  }
  return seen;
}

SampleValue ViewScene::ValueAt(int i, const Isometry3d& X_WC) const {
  SampleValue value = ValueOf(trigger_.measure, CompositeJacobian(model_, motion_[i], X_WC));
  value.log_value =
      std::isnan(value.log_value) ? lowest_ : std::clamp(value.log_value, lowest_, highest_);
  return value;
}

double ViewScene::Score(const SampleValues& values, int seen) const noexcept {
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

double ViewScene::Uncertified(const Isometry3d& X_WC) const {
  const ArmSample& end = motion_.back();
  const double mm_per_px =
      WorstMillimetresPerPixel(Decompose(CompositeJacobian(model_, end, X_WC)), end.J_marker_W);
  const double bound = kCertifiedShare * options_.max_mm_per_px;
  const double log_excess = std::log(std::clamp(mm_per_px / bound, 1.0, kUncertified));
  return (certify_ ? kCertifyWeight : 1.0) * log_excess;
}

ViewScore ViewScene::Evaluate(const Isometry3d& X_WC) const {
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

Vector3d ViewScene::Aim() const {
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

}  // namespace vantage
