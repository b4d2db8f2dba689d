#include "sample_judge.h"

#include <algorithm>
#include <cmath>

namespace vantage::plan {

using Eigen::Isometry3d;
using Eigen::Vector3d;

const std::vector<SampleJudge::Worth>& SampleJudge::At(int sample,
                                                       const std::vector<Isometry3d>& X_WC,
                                                       std::vector<Vector3d>* places) {
  Load(X_WC);
  Frustum(sample, X_WC.size());
  places->resize(X_WC.size());
  for (std::size_t i = 0; i < X_WC.size(); ++i) (*places)[i] = X_WC[i].translation();
  return Judge(sample, *places);
}

SampleJudge::Worth SampleJudge::Of(int sample, const RigVector& q_c) {
  std::vector<Vector3d> place;
  return At(sample, {RigPose(model_.problem().rig, q_c)}, &place)[0];
}

const std::vector<double>& SampleJudge::BackAt(int sample, const std::vector<Isometry3d>& X_WC) {
  Load(X_WC);
  Frustum(sample, X_WC.size());
  back_.resize(X_WC.size());
  for (std::size_t i = 0; i < back_.size(); ++i) {
    back_[i] =
        std::max(0.0, -std::min(margins_.near[i], margins_.image[i]) + 1e-12 * model_.unit());
  }
  return back_;
}

const std::vector<SampleJudge::Worth>& SampleJudge::FromBehind(int sample,
                                                               const std::vector<Isometry3d>& X_WC,
                                                               const std::vector<int>& source,
                                                               const std::vector<double>& by,
                                                               std::vector<Vector3d>* places) {
  std::swap(margins_, own_);
  std::swap(cameras_, asked_);
  cameras_.Turn(asked_, source);
  margins_.near.resize(by.size());
  margins_.far.resize(by.size());
  margins_.image.resize(by.size());
  places->resize(by.size());
  for (std::size_t i = 0; i < by.size(); ++i) {
    const int from = source[i];
    const Isometry3d& X = X_WC[from];
    (*places)[i] = X.translation() - by[i] * X.linear().col(2);
    cameras_.Move(static_cast<int>(i), (*places)[i]);
    margins_.near[i] = own_.near[from] + by[i];
    margins_.far[i] = own_.far[from] - by[i];
    margins_.image[i] = own_.image[from] + by[i];
  }
  return Judge(sample, *places);
}

void SampleJudge::Load(const std::vector<Isometry3d>& X_WC) {
  cameras_.Resize(static_cast<int>(X_WC.size()));
  for (std::size_t i = 0; i < X_WC.size(); ++i) cameras_.Set(static_cast<int>(i), X_WC[i]);
}

void SampleJudge::Frustum(int sample, std::size_t count) {
  const PlacementProblem& problem = model_.problem();
  const PlacementModel::SampleView& view = model_.sample_views()[sample];
  evaluator_.CheckFrustum(view.points ? *view.points : view.scene, cameras_, 0,
                          static_cast<int>(count), problem.lens, model_.depth(),
                          BatchPrecision::kDouble, &margins_, model_.rim_margin());
}

const std::vector<SampleJudge::Worth>& SampleJudge::Judge(int sample,
                                                          const std::vector<Vector3d>& places) {
  const PlacementProblem& problem = model_.problem();
  const PlacementModel::SampleView& view = model_.sample_views()[sample];
  const auto count = static_cast<int>(places.size());
  evaluator_.Score(view.scene, cameras_, 0, count, problem.lens, problem.objective.measure,
                   BatchPrecision::kDouble, false, &scores_);
  const std::vector<BatchObstacles>& obstacles = model_.sample_obstacles();
  if (!obstacles.empty()) {
    evaluator_.CheckObstacles(obstacles[sample], cameras_, 0, count, BatchPrecision::kDouble,
                              &margins_);
  }
  evaluations_ += count;
  worth_.resize(places.size());
  for (int i = 0; i < count; ++i) {
    PlanMargins m{margins_.near[i],
                  margins_.far[i],
                  margins_.image[i],
                  obstacles.empty() ? kInfinity : margins_.occlusion[i],
                  obstacles.empty() ? kInfinity : margins_.facing[i],
                  kInfinity};
    for (const BatchBox& box : problem.limits.keep_out) {
      Tighten(PlanLimit::kKeepOut, DistanceToBox(box, places[i]) - problem.limits.clearance, &m);
    }
    // A measure of nothing (log 0) is as bad as a broken limit.
    const bool counts = model_.Keeps(m) && std::isfinite(scores_.sum[i]);
    worth_[i] = {counts ? problem.motion.weight[sample] * scores_.sum[i] : 0.0,
                 counts ? 0.0 : std::max(model_.Violation(m), 1e-6)};
    largest_ = std::max(largest_, std::abs(worth_[i].value));
  }
  return worth_;
}

}  // namespace vantage::plan
