#include "path_tube.h"

#include <algorithm>
#include <cmath>

#include "rig_speed.h"

namespace vantage::plan {

using Eigen::MatrixXd;
using Eigen::Vector3d;

std::optional<double> PathTube::Refine(const Round& round, std::vector<RigVector>* path) {
  const ArmMotion& motion = model_.problem().motion;
  const Window& window = round.window;
  Prepare(round, *path);
  const auto S = static_cast<int>(round.moves.size());
  const std::vector<int> nodes = NodesOf(round);
  const auto K = static_cast<int>(nodes.size());
  slices_.resize(window.count);
  MatrixXd best = MatrixXd::Constant(K, S, -kInfinity);
  std::vector<std::vector<int>> from(K, std::vector<int>(S, -1));
  Look(window, 0, 1.0, at_node_, (*path)[window.first]);
  for (int n = 0; n < (window.hold_first ? 1 : S); ++n) {
    const bool reached = window.first == 0 || Follows(window.first - 1, (*path)[window.first - 1],
                                                      StateOf(window, 0, at_node_, n, *path));
    if (reached) best(0, n) = slices_[0].reward[n];
  }
  std::vector<double> sum(S * S);
  for (int k = 1; k < K; ++k) {
    const int begin = nodes[k - 1], end = nodes[k];
    for (int p = 0; p < S * S; ++p) sum[p] = best(k - 1, p / S);
    for (int before = begin; before < end;) {
      const int i = std::min(before + round.stride, end);
      Look(window, i, ShareOf(window, begin, i, end), i == end ? at_node_ : between_,
           (*path)[window.first + i]);
      // Stands for those that are left out about it.
      const int next =
          std::min({i + round.stride, i < end ? end : i + round.stride, window.count - 1});
      const double weight = i == window.count - 1 ? 0.5 * (i - before + 1) : 0.5 * (next - before);
      Pass(window, before, i, before == begin, i == end, weight, *path, &sum);
      before = i;
    }
    for (int p = 0; p < S * S; ++p) {
      if (sum[p] > best(k, p % S)) {
        best(k, p % S) = sum[p];
        from[k][p % S] = p / S;
      }
    }
  }
  const int end = window.first + window.count;
  int last = -1;
  for (int n = 0; n < S; ++n) {
    const bool leaves =
        end == motion.size() ||
        Follows(end - 1, StateOf(window, window.count - 1, at_node_, n, *path), (*path)[end]);
    if (leaves && best(K - 1, n) > (last < 0 ? -kInfinity : best(K - 1, last))) last = n;
  }
  if (last < 0) return std::nullopt;
  const double worth = best(K - 1, last);
  Take(round, nodes, from, last, path);
  return worth;
}

void PathTube::Take(const Round& round, const std::vector<int>& nodes,
                    const std::vector<std::vector<int>>& from, int last,
                    std::vector<RigVector>* path) {
  const Window& window = round.window;
  const auto S = static_cast<int>(round.moves.size());
  for (std::size_t k = nodes.size() - 1; k > 0; --k) {
    const int before = from[k][last];
    const int entry = before * S + last;
    for (int i = nodes[k - 1] + 1; i < nodes[k]; ++i) {
      RigVector& own = (*path)[window.first + i];
      if ((i - nodes[k - 1]) % round.stride == 0) {
        own = StateOf(window, i, between_, entry, *path);
      } else {
        own = LeftOut(window.first + i, ShareOf(window, nodes[k - 1], i, nodes[k]),
                      between_.code[entry], own);
      }
    }
    (*path)[window.first + nodes[k]] = StateOf(window, nodes[k], at_node_, last, *path);
    last = before;
  }
  (*path)[window.first] = StateOf(window, 0, at_node_, last, *path);
}

std::vector<int> PathTube::NodesOf(const Round& round) {
  std::vector<int> nodes{0};
  for (int i = round.offset; i < round.window.count - 1; i += round.spacing) nodes.push_back(i);
  if (round.window.count > 1) nodes.push_back(round.window.count - 1);
  return nodes;
}

void PathTube::Prepare(const Round& round, const std::vector<RigVector>& path) {
  const auto S = static_cast<int>(round.moves.size());
  haste_ = round.haste;
  const auto code = [&](int before, int after) {
    std::array<int, kMaxRigAxes> of_axis{};
    of_axis.fill(kStays);
    for (int j = 0; j < space_.size(); ++j) {
      of_axis[space_.axis(j)] = 3 * (round.moves[before][j] + 1) + round.moves[after][j] + 1;
    }
    return of_axis;
  };
  // Moves that differ in the distance alone share a direction, and so do their pairs.
  std::vector<int> direction(S, 0);
  int directions = 0;
  for (int n = 0; n < S; ++n) {
    int same = 0;
    while (same < n && !SameDirection(round.moves[same], round.moves[n])) ++same;
    direction[n] = same < n ? direction[same] : directions++;
  }
  at_node_ = between_ = {};
  std::vector<int> known(directions * directions, -1);
  for (int n = 0; n < S; ++n) {
    Add(code(n, n), &known[direction[n]], &at_node_);
  }
  std::fill(known.begin(), known.end(), -1);
  for (int p = 0; p < S * S; ++p) {
    Add(code(p / S, p % S), &known[direction[p / S] * directions + direction[p % S]], &between_);
  }
  SetSteps(round, path);
}

bool PathTube::SameDirection(const std::vector<int>& a, const std::vector<int>& b) const {
  for (int j = 0; j < space_.size(); ++j) {
    if (space_.axis(j) != space_.step_axis() && a[j] != b[j]) return false;
  }
  return true;
}

void PathTube::Add(const std::array<int, kMaxRigAxes>& code, int* direction,
                   Neighbours* all) const {
  const int size = space_.rig().size(), distance = space_.step_axis();
  if (*direction < 0) {
    *direction = static_cast<int>(all->pick.size()) / size;
    all->pick.insert(all->pick.end(), code.begin(), code.begin() + size);
    if (distance >= 0) all->pick[all->pick.size() - size + distance] = 0;
  }
  all->code.push_back(code);
  all->direction.push_back(*direction);
}

void PathTube::SetSteps(const Round& round, const std::vector<RigVector>& path) {
  const ArmMotion& motion = model_.problem().motion;
  const CameraRig& rig = space_.rig();
  const Window& window = round.window;
  const int last = window.first + window.count - 1;
  const double dt = (motion.time[last] - motion.time[window.first]) /
                    std::max(1, window.count - 1) * round.spacing;
  const RigJacobianMatrix J = RigJacobian(rig, path[window.first + window.count / 2]);
  step_.assign(rig.size(), 0.0);
  for (int j = 0; j < space_.size(); ++j) {
    const bool moves = std::any_of(round.moves.begin(), round.moves.end(),
                                   [&](const std::vector<int>& move) { return move[j] != 0; });
    if (!moves) continue;
    const int axis = space_.axis(j);
    const double speed =
        std::min(rig.axes[axis].max_speed,
                 rig.max_linear_speed / std::max(1e-9, J.col(axis).head<3>().norm()));
    step_[axis] = std::min(round.step * dt * speed, 0.25 * space_.range(j));
  }
}

bool PathTube::Follows(int sample, const RigVector& from, const RigVector& to) const {
  const std::vector<double>& time = model_.problem().motion.time;
  return MayFollow(space_.rig(), from, to, time[sample + 1] - time[sample]);
}

RigVector PathTube::StateOf(const Window& window, int i, const Neighbours& all, int entry,
                            const std::vector<RigVector>& path) const {
  const int distance = space_.step_axis();
  RigVector q_c = path[window.first + i];
  for (int axis = 0; axis < q_c.size(); ++axis) {
    if (axis == distance) {
      q_c(axis) = slices_[i].distance[entry];
    } else if (step_[axis] > 0.0) {
      q_c(axis) = slices_[i].value[axis][all.code[entry][axis]];
    }
  }
  return q_c;
}

double PathTube::ShareOf(const Window& window, int begin, int i, int end) const {
  const double* time = model_.problem().motion.time.data() + window.first;
  return (time[i] - time[begin]) / (time[end] - time[begin]);
}

RigVector PathTube::LeftOut(int sample, double lambda, const std::array<int, kMaxRigAxes>& code,
                            const RigVector& own) {
  const CameraRig& rig = space_.rig();
  const int distance = space_.step_axis();
  RigVector q_c = own;
  for (int axis = 0; axis < rig.size(); ++axis) {
    const double by = (1.0 - lambda) * (code[axis] / 3 - 1) + lambda * (code[axis] % 3 - 1);
    q_c(axis) =
        std::clamp(own(axis) + by * step_[axis], rig.axes[axis].lower, rig.axes[axis].upper);
  }
  if (distance < 0) return q_c;
  // As much farther than need be as before.
  const double lower = rig.axes[distance].lower;
  RigVector from = own, to = q_c;
  from(distance) = to(distance) = lower;
  const std::vector<double>& back = judge_->BackAt(sample, {RigPose(rig, from), RigPose(rig, to)});
  q_c(distance) = std::min(rig.axes[distance].upper,
                           lower + std::max(0.0, q_c(distance) - lower - back[0]) + back[1]);
  return q_c;
}

void PathTube::Look(const Window& window, int i, double lambda, const Neighbours& all,
                    const RigVector& own) {
  const CameraRig& rig = space_.rig();
  const int distance = space_.step_axis();
  std::array<double, kCodes> by{};
  for (int code = 0; code < kCodes; ++code) {
    by[code] = (1.0 - lambda) * (code / 3 - 1) + lambda * (code % 3 - 1);
  }
  Slice& slice = slices_[i];
  slice.value.resize(rig.size());
  for (int axis = 0; axis < rig.size(); ++axis) {
    slice.value[axis].assign(kCodes, axis == distance ? rig.axes[axis].lower : own(axis));
    if (axis == distance || !(step_[axis] > 0.0)) continue;
    for (int code = 0; code < kCodes; ++code) {
      slice.value[axis][code] = std::clamp(own(axis) + by[code] * step_[axis], rig.axes[axis].lower,
                                           rig.axes[axis].upper);
    }
  }
  RigPoses(rig, slice.value, all.pick, &X_WC_);
  const std::vector<SampleJudge::Worth>* worth = nullptr;
  const int sample = window.first + i;
  if (distance >= 0) {
    const double lower = rig.axes[distance].lower, upper = rig.axes[distance].upper;
    const std::vector<double>& back = judge_->BackAt(sample, X_WC_);
    // Further than need be by as much as the path is, and by the steps.
    const double spare = std::max(0.0, own(distance) - lower - back[all.direction[0]]);
    by_.resize(all.code.size());
    slice.distance.resize(all.code.size());
    for (std::size_t n = 0; n < by_.size(); ++n) {
      const double further = spare + by[all.code[n][distance]] * step_[distance];
      const double wanted = lower + back[all.direction[n]] + std::max(0.0, further);
      slice.distance[n] = n == 0 ? own(distance) : std::min(wanted, upper);
      by_[n] = slice.distance[n] - lower;
    }
    worth = &judge_->FromBehind(sample, X_WC_, all.direction, by_, &slice.place);
  } else {
    worth = &judge_->At(sample, X_WC_, &slice.place);
  }
  slice.reward.resize(worth->size());
  for (std::size_t n = 0; n < worth->size(); ++n) slice.reward[n] = Reward((*worth)[n], penalty_);
}

void PathTube::Pass(const Window& window, int before, int i, bool from_node, bool to_node,
                    double weight, const std::vector<RigVector>& path, std::vector<double>* sum) {
  const CameraRig& rig = space_.rig();
  const std::vector<double>& time = model_.problem().motion.time;
  const int at = window.first + i, from = window.first + before, distance = space_.step_axis();
  const Reach reach(rig, time[at] - time[from]);
  const Slice& last = slices_[before];
  const Slice& here = slices_[i];
  const auto S = static_cast<int>(at_node_.code.size());
  // Of each axis: codes that its speed allows.
  std::array<std::array<bool, kCodes>, kMaxRigAxes> allowed{};
  std::array<int, kMaxRigAxes> moving{};
  int movings = 0;
  bool still = true;
  for (int axis = 0; axis < rig.size(); ++axis) {
    if (axis == distance) continue;
    if (!(step_[axis] > 0.0)) {
      still = still && std::abs(path[at](axis) - path[from](axis)) <= reach.axis(axis);
      continue;
    }
    for (int code = 0; code < kCodes; ++code) {
      // At a node the value is of the move before or after alone.
      const double value = last.value[axis][from_node ? 4 * (code / 3) : code];
      const double to = here.value[axis][to_node ? 4 * (code % 3) : code];
      allowed[axis][code] = std::abs(to - value) <= reach.axis(axis);
    }
    moving[movings++] = axis;
  }
  const double by_distance = distance >= 0 ? reach.axis(distance) : 0.0;
  const bool soft = haste_ < kInfinity;
  for (std::size_t p = 0; p < sum->size(); ++p) {
    const int pair = static_cast<int>(p);
    const int a = from_node ? pair / S : pair, b = to_node ? pair % S : pair;
    const double way2 = (here.place[b] - last.place[a]).squaredNorm();
    bool may = still && (soft || way2 <= reach.centre2());
    for (int j = 0; j < movings; ++j) may = may && allowed[moving[j]][between_.code[p][moving[j]]];
    if (distance >= 0) may = may && std::abs(here.distance[b] - last.distance[a]) <= by_distance;
    (*sum)[p] = may ? (*sum)[p] + weight * here.reward[b] : -kInfinity;
    if (soft && way2 > reach.centre2())
      (*sum)[p] -= weight * haste_ * (std::sqrt(way2 / reach.centre2()) - 1.0);
  }
}

}  // namespace vantage::plan
