#include "path_lattice.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "rig_speed.h"
#include "sequences.h"

namespace vantage::plan {

using Eigen::MatrixXd;
using Eigen::Vector3d;

PathLattice::PathLattice(const PlacementModel& model, const SearchSpace& space,
                         const RigVector& q_c_fixed, int states, SampleJudge* judge)
    : model_(model), space_(space), judge_(judge) {
  // Where one axis is the distance each state stands for a direction, from as near as can be.
  CameraRig rig = space.rig();
  const int axis = space.step_axis();
  if (axis >= 0) rig.axes[axis].upper = rig.axes[axis].lower;
  const SearchSpace directions(rig, q_c_fixed);
  states_.push_back(q_c_fixed);
  for (int s = 1; s < states; ++s) states_.push_back(directions.ToRig(directions.Spread(s)));
  if (axis >= 0) states_[0](axis) = rig.axes[axis].lower;
  for (const RigVector& q_c : states_) X_WC_.push_back(RigPose(rig, q_c));
  Connect();
  Layer();
}

std::vector<RigVector> PathLattice::BestPath() {
  const CameraRig& rig = space_.rig();
  const auto S = static_cast<Eigen::Index>(predecessor_.size());
  const int axis = space_.step_axis();
  MatrixXd value(stages_, S);
  std::vector<std::vector<double>> distance(stages_);
  std::vector<int> source(S);
  for (Eigen::Index i = 0; i < S; ++i) source[i] = static_cast<int>(i) / layers();
  std::vector<std::vector<Vector3d>> places(stages_);
  for (int stage = 0; stage < stages_; ++stage) {
    const int sample = SampleOf(stage);
    std::vector<double>& by = distance[stage];
    if (axis >= 0) {
      const std::vector<double>& back = judge_->BackAt(sample, X_WC_);
      const double room = rig.axes[axis].upper - rig.axes[axis].lower;
      by.resize(S);
      for (Eigen::Index s = 0; s < S; ++s) {
        by[s] = std::min(room, back[source[s]] + spare_[s % layers()]);
      }
    }
    const std::vector<SampleJudge::Worth>& worth =
        axis >= 0 ? judge_->FromBehind(sample, X_WC_, source, by, &places[stage])
                  : judge_->At(sample, X_WC_, &places[stage]);
    for (Eigen::Index s = 0; s < S; ++s) value(stage, s) = Reward(worth[s], judge_->Penalty());
  }
  // Where states stand still the links say it all.
  const Reach reach(rig, kReserve * StageTime());
  const auto may_follow = [&](Eigen::Index stage, int from, int to) {
    if (axis < 0) return true;
    return (places[stage][to] - places[stage - 1][from]).squaredNorm() <= reach.centre2() &&
           std::abs(distance[stage][to] - distance[stage - 1][from]) <= reach.axis(axis);
  };
  const std::vector<int> sequence = Sequences(value, predecessor_, may_follow).Best();
  if (sequence.empty()) return {};
  return PathThrough(sequence, distance);
}

int PathLattice::SampleOf(int stage) const {
  const std::vector<double>& time = model_.problem().motion.time;
  const double at = stage * StageTime();
  const auto above = std::lower_bound(time.begin(), time.end(), at - 1e-12);
  const auto i = static_cast<int>(std::min(above, time.end() - 1) - time.begin());
  return i > 0 && at - time[i - 1] < time[i] - at ? i - 1 : i;
}

void PathLattice::Connect() {
  constexpr int kMostStages = 33;
  constexpr std::size_t kOthers = 12;
  const CameraRig& rig = space_.rig();
  // In the order of the axis that takes longest from end to end: what is near comes soon after.
  int slow = 0;
  double longest = 0.0;
  for (int i = 0; i < space_.size(); ++i) {
    if (space_.axis(i) == space_.step_axis()) continue;
    const double takes = space_.range(i) / rig.axes[space_.axis(i)].max_speed;
    if (takes > longest) {
      longest = takes;
      slow = space_.axis(i);
    }
  }
  std::vector<int> order(states_.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(),
            [&](int a, int b) { return states_[a](slow) < states_[b](slow); });
  const int N = model_.problem().motion.size();
  for (stages_ = std::min(kMostStages, N);; stages_ = (stages_ + 1) / 2) {
    predecessor_.assign(states_.size(), {});
    const Reach reach(rig, kReserve * StageTime());
    std::size_t links = 0;
    for (auto a = order.begin(); a != order.end(); ++a) {
      predecessor_[*a].push_back(*a);
      for (auto b = a + 1; b != order.end(); ++b) {
        if (states_[*b](slow) - states_[*a](slow) > reach.axis(slow)) break;
        if (!reach.Covers(states_[*a], X_WC_[*a].translation(), states_[*b],
                          X_WC_[*b].translation())) {
          continue;
        }
        predecessor_[*a].push_back(*b);
        predecessor_[*b].push_back(*a);
        links += 2;
      }
    }
    if (stages_ <= 3 || links >= kOthers * states_.size()) break;
  }
}

void PathLattice::Layer() {
  if (space_.step_axis() < 0) return;
  const double way = space_.rig().max_linear_speed * StageTime();
  spare_ = {0.0, 0.5 * way, way};
  const auto layers = static_cast<int>(spare_.size());
  std::vector<std::vector<int>> all(states_.size() * layers);
  for (std::size_t s = 0; s < all.size(); ++s) {
    for (const int p : predecessor_[s / layers]) {
      for (int layer = 0; layer < layers; ++layer) all[s].push_back(p * layers + layer);
    }
  }
  predecessor_ = std::move(all);
}

std::vector<RigVector> PathLattice::PathThrough(
    const std::vector<int>& sequence, const std::vector<std::vector<double>>& distance) const {
  const ArmMotion& motion = model_.problem().motion;
  const auto state = [&](int stage) {
    RigVector q_c = states_[sequence[stage] / layers()];
    if (space_.step_axis() >= 0) q_c(space_.step_axis()) += distance[stage][sequence[stage]];
    return q_c;
  };
  std::vector<RigVector> path;
  for (int i = 0; i < motion.size(); ++i) {
    const double at = motion.time[i] / StageTime();
    const int stage = std::min(static_cast<int>(at), stages_ - 2);
    path.push_back(state(stage) + (at - stage) * (state(stage + 1) - state(stage)));
  }
  Obey(model_, space_, judge_, &path);
  return path;
}

}  // namespace vantage::plan
