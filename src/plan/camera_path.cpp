#include "vantage/plan/camera_path.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <optional>

#include "search_space.h"
#include "vantage/math/error.h"

namespace vantage {
namespace {

using Eigen::Isometry3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using plan::SearchSpace;
using plan::SearchVector;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// A step may exceed a speed limit by this share: what rounding takes.
constexpr double kSpeedSlack = 1e-9;

// The rig with the axes locked that cannot move.
CameraRig Moving(const PlacementProblem& problem) {
  CameraRig rig = problem.rig;
  for (int i = 0; i < rig.size(); ++i) {
    if (rig.axes[i].max_speed == 0.0) rig.axes[i].lower = rig.axes[i].upper = problem.q_c_start(i);
  }
  return rig;
}

// What cameras are worth at single samples of the motion.
class SampleJudge {
 public:
  explicit SampleJudge(const PlacementModel& model) : model_(model) {}

  struct Worth {
    double value;      // weight times measure; 0 where a limit is broken
    double violation;  // 0: all limits are kept
  };
  /// At one sample, of many cameras. Writes where they stand.
  const std::vector<Worth>& At(int sample, const std::vector<Isometry3d>& X_WC,
                               std::vector<Vector3d>* places) {
    Load(X_WC);
    Frustum(sample, X_WC.size());
    places->resize(X_WC.size());
    for (std::size_t i = 0; i < X_WC.size(); ++i) (*places)[i] = X_WC[i].translation();
    return Judge(sample, *places);
  }

  /// Of one camera.
  Worth Of(int sample, const RigVector& q_c) {
    std::vector<Vector3d> place;
    return At(sample, {RigPose(model_.problem().rig, q_c)}, &place)[0];
  }

  /// By how much each camera has to step back along its optical axis to keep field of view and least depth at
  /// one sample [m]; not above 0: it keeps them where it is. FromBehind() is about the same cameras.
  const std::vector<double>& BackAt(int sample, const std::vector<Isometry3d>& X_WC) {
    Load(X_WC);
    Frustum(sample, X_WC.size());
    back_.resize(X_WC.size());
    for (std::size_t i = 0; i < back_.size(); ++i) {
      back_[i] = -std::min(margins_.near[i], margins_.image[i]);
    }
    return back_;
  }

  /// Worth of cameras that stand by[i] [m] further back along the optical axis than camera source[i] of those
  /// that BackAt() was asked about. Writes where they stand.
  const std::vector<Worth>& FromBehind(int sample, const std::vector<Isometry3d>& X_WC,
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

  /// A broken limit outweighs anything that was seen so far.
  [[nodiscard]] double Penalty() const noexcept {
    return 1e3 * model_.problem().motion.size() * (largest_ > 0.0 ? largest_ : 1.0);
  }
  [[nodiscard]] std::int64_t evaluations() const noexcept { return evaluations_; }

 private:
  void Load(const std::vector<Isometry3d>& X_WC) {
    cameras_.Resize(static_cast<int>(X_WC.size()));
    for (std::size_t i = 0; i < X_WC.size(); ++i) cameras_.Set(static_cast<int>(i), X_WC[i]);
  }

  // Sets the margins near, far and image.
  void Frustum(int sample, std::size_t count) {
    const PlacementProblem& problem = model_.problem();
    const PlacementModel::SampleView& view = model_.sample_views()[sample];
    evaluator_.CheckFrustum(view.points ? *view.points : view.scene, cameras_, 0,
                            static_cast<int>(count), problem.lens, model_.depth(),
                            BatchPrecision::kDouble, &margins_, model_.rim_margin());
  }

  const std::vector<Worth>& Judge(int sample, const std::vector<Vector3d>& places) {
    const PlacementProblem& problem = model_.problem();
    const PlacementModel::SampleView& view = model_.sample_views()[sample];
    const auto count = static_cast<int>(places.size());
    evaluator_.Score(view.scene, cameras_, 0, count, problem.lens, problem.objective.measure,
                     BatchPrecision::kDouble, false, &scores_);
    if (view.obstacles) {
      evaluator_.CheckObstacles(*view.obstacles, cameras_, 0, count, BatchPrecision::kDouble,
                                &margins_);
    }
    evaluations_ += count;
    worth_.resize(places.size());
    for (int i = 0; i < count; ++i) {
      PlanMargins m{margins_.near[i],
                    margins_.far[i],
                    margins_.image[i],
                    view.obstacles ? margins_.occlusion[i] : kInfinity,
                    view.obstacles ? margins_.facing[i] : kInfinity,
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

  const PlacementModel& model_;
  BatchEvaluator evaluator_;
  BatchCameras cameras_, asked_;
  BatchScores scores_;
  BatchMargins margins_, own_;
  std::vector<double> back_;
  std::vector<Worth> worth_;
  double largest_{0.0};
  std::int64_t evaluations_{0};
};

double Reward(const SampleJudge::Worth& worth, double penalty) {
  return worth.violation > 0.0 ? -penalty * (1.0 + worth.violation) : worth.value;
}

// How far a rig gets in a time.
class Reach {
 public:
  Reach(const CameraRig& rig, double dt) : size_(rig.size()) {
    const double allowed = dt * (1.0 + kSpeedSlack) + 1e-12;
    for (int i = 0; i < size_; ++i) axis_[i] = rig.axes[i].max_speed * allowed;
    centre2_ = std::pow(rig.max_linear_speed * allowed, 2);
  }
  [[nodiscard]] double axis(int i) const noexcept { return axis_[i]; }
  /// Of the camera's centre, squared.
  [[nodiscard]] double centre2() const noexcept { return centre2_; }
  [[nodiscard]] bool Covers(const RigVector& from, const Vector3d& p_from, const RigVector& to,
                            const Vector3d& p_to) const noexcept {
    if ((p_to - p_from).squaredNorm() > centre2_) return false;
    for (int i = 0; i < size_; ++i) {
      if (std::abs(to(i) - from(i)) > axis_[i]) return false;
    }
    return true;
  }

 private:
  int size_;
  std::array<double, kMaxRigAxes> axis_{};
  double centre2_{0.0};
};

bool MayFollow(const CameraRig& rig, const RigVector& from, const RigVector& to, double dt) {
  return Reach(rig, dt).Covers(from, RigPose(rig, from).translation(), to,
                               RigPose(rig, to).translation());
}

CameraPath Judge(const PlacementModel& model, std::vector<RigVector> q_c, SampleJudge* judge) {
  CameraPath path;
  path.q_c = std::move(q_c);
  double sum = 0.0;
  for (int i = 0; i < model.problem().motion.size(); ++i) {
    const SampleJudge::Worth worth = judge->Of(i, path.q_c[i]);
    sum += worth.value;
    path.broken += worth.violation > 0.0 ? 1 : 0;
  }
  path.value = model.Value(sum);
  return path;
}

// The path as near as the frustum lets each sample be and the speeds allow, other axes as they are: no
// distance is less than those of its neighbours allow.
void PullNear(const PlacementModel& model, const SearchSpace& space, SampleJudge* judge,
              std::vector<RigVector>* path) {
  constexpr double kReserve = 0.99;  // of the speeds
  const int axis = space.step_axis();
  if (axis < 0) return;
  const CameraRig& rig = space.rig();
  const ArmMotion& motion = model.problem().motion;
  const int N = motion.size();
  const double lower = rig.axes[axis].lower, upper = rig.axes[axis].upper;
  std::vector<Isometry3d> X_WC;
  for (int i = 0; i < N; ++i) {
    RigVector q = (*path)[i];
    q(axis) = lower;
    X_WC.push_back(RigPose(rig, q));
    (*path)[i](axis) = std::min(
        upper, lower + std::max(0.0, judge->BackAt(i, {X_WC[i]})[0] + 1e-12 * model.unit()));
  }
  const auto follow = [&](int from, int to) {
    const double dt = std::abs(motion.time[to] - motion.time[from]);
    const double far = kReserve * rig.max_linear_speed * dt;
    const Vector3d back = -X_WC[to].linear().col(2);
    const Vector3d way = X_WC[from].translation() -
                         ((*path)[from](axis) - lower) * X_WC[from].linear().col(2) -
                         X_WC[to].translation();
    const double along = way.dot(back);
    const double across2 = way.squaredNorm() - along * along;
    const double least = lower + along - std::sqrt(std::max(0.0, far * far - across2));
    const double by_axis = (*path)[from](axis) - kReserve * rig.axes[axis].max_speed * dt;
    (*path)[to](axis) = std::min(upper, std::max({(*path)[to](axis), least, by_axis}));
  };
  for (int i = 1; i < N; ++i) follow(i - 1, i);
  for (int i = N - 1; i > 0; --i) follow(i, i - 1);
}

// The path as the speeds allow: where it runs ahead, what follows lags behind.
void Lag(const CameraRig& rig, const ArmMotion& motion, std::vector<RigVector>* path) {
  for (int i = 1; i < motion.size(); ++i) {
    const RigVector from = (*path)[i - 1], wanted = (*path)[i];
    const double dt = motion.time[i] - motion.time[i - 1];
    if (MayFollow(rig, from, wanted, dt)) continue;
    double share = 0.0;
    for (double step = 0.5; step > 1e-4; step *= 0.5) {
      const RigVector to = from + (share + step) * (wanted - from);
      if (MayFollow(rig, from, to, dt)) share += step;
    }
    (*path)[i] = from + share * (wanted - from);
  }
}

// The path as limits and speeds allow, as near as can be.
void Obey(const PlacementModel& model, const SearchSpace& space, SampleJudge* judge,
          std::vector<RigVector>* path) {
  // What lags stands elsewhere, where it may have to be farther away.
  for (int round = 0; round < 2; ++round) {
    PullNear(model, space, judge, path);
    Lag(space.rig(), model.problem().motion, path);
  }
}

// The best sequences of states, by dynamic programming.
class Sequences {
 public:
  /// @param may_follow  (step, from, to): whether a state may follow another, which is among its predecessors.
  template <class MayFollow>
  Sequences(const MatrixXd& value, const std::vector<std::vector<int>>& predecessor,
            const MayFollow& may_follow)
      : sum_(value.row(0)) {
    const Eigen::Index N = value.rows(), S = value.cols();
    from_.assign(N, std::vector<int>(S, -1));
    for (Eigen::Index i = 1; i < N; ++i) {
      Eigen::VectorXd next = Eigen::VectorXd::Constant(S, -kInfinity);
      for (Eigen::Index s = 0; s < S; ++s) {
        double best = -kInfinity;
        for (const int p : predecessor[s]) {
          if (sum_(p) > best && may_follow(i, p, static_cast<int>(s))) {
            best = sum_(p);
            from_[i][s] = p;
          }
        }
        next(s) = best + value(i, s);
      }
      sum_ = next;
    }
  }

  /// The state that the best of all ends in; -1: there is no sequence.
  [[nodiscard]] int BestEnd() const {
    Eigen::Index end = 0;
    return sum_.maxCoeff(&end) > -kInfinity ? static_cast<int>(end) : -1;
  }
  /// The best sequence that ends in a state.
  [[nodiscard]] std::vector<int> To(int end) const {
    std::vector<int> sequence(from_.size());
    for (std::size_t i = from_.size(); i-- > 0;) {
      sequence[i] = end;
      end = from_[i][end];
    }
    return sequence;
  }

 private:
  Eigen::VectorXd sum_;
  std::vector<std::vector<int>> from_;
};

// Directions of the coarse lattice and where they stand at each of its stages.
class Lattice {
 public:
  Lattice(const PlacementModel& model, const SearchSpace& space, const RigVector& q_c_fixed,
          int states, SampleJudge* judge)
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

  /// The best path, as far as the speeds between the stages tell.
  std::vector<RigVector> BestPath() {
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
          by[s] = std::min(
              room, std::max(0.0, back[source[s]] + 1e-12 * model_.unit()) + spare_[s % layers()]);
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
    const Sequences sequences(value, predecessor_, may_follow);
    return PathThrough(sequences.To(sequences.BestEnd()), distance);
  }

 private:
  static constexpr double kReserve = 0.95;  // of the speeds

  [[nodiscard]] int layers() const { return static_cast<int>(spare_.size()); }
  [[nodiscard]] double StageTime() const {
    return model_.problem().motion.time.back() / (stages_ - 1);
  }
  [[nodiscard]] int SampleOf(int stage) const {
    const std::vector<double>& time = model_.problem().motion.time;
    const double at = stage * StageTime();
    const auto above = std::lower_bound(time.begin(), time.end(), at - 1e-12);
    const auto i = static_cast<int>(std::min(above, time.end() - 1) - time.begin());
    return i > 0 && at - time[i - 1] < time[i] - at ? i - 1 : i;
  }

  // As many stages as leave a state enough others to go to.
  void Connect() {
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

  // Where one axis is the distance, each direction from as near as can be and from further back: what comes near
  // fast has to begin in time.
  void Layer() {
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

  // In between as near as can be, and as the speeds allow.
  std::vector<RigVector> PathThrough(const std::vector<int>& sequence,
                                     const std::vector<std::vector<double>>& distance) const {
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

  const PlacementModel& model_;
  const SearchSpace& space_;
  SampleJudge* judge_;
  std::vector<RigVector> states_;
  std::vector<Isometry3d> X_WC_;
  std::vector<double> spare_{
      0.0};  // of the layers of a state: how much further back than need be [m]
  int stages_{2};
  std::vector<std::vector<int>> predecessor_;
};

// Samples of a path that are refined.
struct Window {
  int first, count;
  bool hold_first;
};
// The neighbours of a path and the best way through them. Nodes lie `spacing` samples apart; what moves a node
// moves the samples about it in proportion.
class Tube {
 public:
  Tube(const PlacementModel& model, const SearchSpace& space, double penalty, SampleJudge* judge)
      : model_(model), space_(space), penalty_(penalty), judge_(judge) {}

  struct Round {
    Window window;
    // Of a node, in steps of each free axis: -1, 0 or 1. The first is none.
    std::vector<std::vector<int>> moves;
    int spacing{1};    // samples between nodes
    int offset{1};     // of the second node
    double step{0.1};  // as a share of what the speeds allow from node to node
    int stride{1};     // samples between those that are looked at
    double haste{
        kInfinity};  // what twice the camera's speed costs at a sample; inf: none above it is allowed
  };
  /// The best way through the neighbours of the path becomes the path. Returns what the window's samples are
  /// then worth, those that are not looked at as their neighbours; nothing where there is no way.
  std::optional<double> Refine(const Round& round, std::vector<RigVector>* path) {
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
        const double weight =
            i == window.count - 1 ? 0.5 * (i - before + 1) : 0.5 * (next - before);
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
    for (int k = K - 1; k > 0; --k) {
      const int before = from[k][last];
      for (int i = nodes[k - 1] + 1; i < nodes[k]; ++i) {
        const int entry = before * S + last;
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
    return worth;
  }

 private:
  // Neighbours of one sample.
  struct Slice {
    std::vector<std::vector<double>> value;  // of each rig axis, those that occur
    std::vector<double> distance;            // of each neighbour, where one axis is the distance
    std::vector<Vector3d> place;
    std::vector<double> reward;
  };
  // What the neighbours of a sample are. At a node: its moves. Between nodes: each move of the one before with
  // each move of the one after. A move of an axis is a code: 3 (move before + 1) + (move after + 1).
  struct Neighbours {
    std::vector<std::array<int, kMaxRigAxes>> code;  // of each, by rig axis
    std::vector<int>
        direction;  // of each: where one axis is the distance, those with equal other axes share one
    std::vector<int> pick;  // of each direction: codes by rig axis, one after the other
  };
  static constexpr int kStays = 4;  // code of an axis that does not move
  static constexpr int kCodes = 9;

  static std::vector<int> NodesOf(const Round& round) {
    std::vector<int> nodes{0};
    for (int i = round.offset; i < round.window.count - 1; i += round.spacing) nodes.push_back(i);
    if (round.window.count > 1) nodes.push_back(round.window.count - 1);
    return nodes;
  }

  // Sets the neighbours and the steps.
  void Prepare(const Round& round, const std::vector<RigVector>& path) {
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

  // Two moves, in steps of each free axis.
  [[nodiscard]] bool SameDirection(const std::vector<int>& a, const std::vector<int>& b) const {
    for (int j = 0; j < space_.size(); ++j) {
      if (space_.axis(j) != space_.step_axis() && a[j] != b[j]) return false;
    }
    return true;
  }

  // One more neighbour; `direction`: its index among those of all, -1: it is the first to have it.
  void Add(const std::array<int, kMaxRigAxes>& code, int* direction, Neighbours* all) const {
    const int size = space_.rig().size(), distance = space_.step_axis();
    if (*direction < 0) {
      *direction = static_cast<int>(all->pick.size()) / size;
      all->pick.insert(all->pick.end(), code.begin(), code.begin() + size);
      if (distance >= 0) all->pick[all->pick.size() - size + distance] = 0;
    }
    all->code.push_back(code);
    all->direction.push_back(*direction);
  }

  // One step of an axis: a share of what its speed and that of the camera allow from node to node.
  void SetSteps(const Round& round, const std::vector<RigVector>& path) {
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

  [[nodiscard]] bool Follows(int sample, const RigVector& from, const RigVector& to) const {
    const std::vector<double>& time = model_.problem().motion.time;
    return MayFollow(space_.rig(), from, to, time[sample + 1] - time[sample]);
  }

  // Rig coordinates of a neighbour.
  [[nodiscard]] RigVector StateOf(const Window& window, int i, const Neighbours& all, int entry,
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

  // Where sample i lies in time between two nodes.
  [[nodiscard]] double ShareOf(const Window& window, int begin, int i, int end) const {
    const double* time = model_.problem().motion.time.data() + window.first;
    return (time[i] - time[begin]) / (time[end] - time[begin]);
  }

  // Rig coordinates of a neighbour that was not looked at.
  [[nodiscard]] RigVector LeftOut(int sample, double lambda,
                                  const std::array<int, kMaxRigAxes>& code, const RigVector& own) {
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
    const std::vector<double>& back =
        judge_->BackAt(sample, {RigPose(rig, from), RigPose(rig, to)});
    const double need = std::max(0.0, back[0] + 1e-12 * model_.unit());
    q_c(distance) =
        std::min(rig.axes[distance].upper, lower + std::max(0.0, q_c(distance) - lower - need) +
                                               std::max(0.0, back[1] + 1e-12 * model_.unit()));
    return q_c;
  }

  // Judges the neighbours of a sample that lies at `lambda` between two nodes, or is one.
  void Look(const Window& window, int i, double lambda, const Neighbours& all,
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
        slice.value[axis][code] = std::clamp(own(axis) + by[code] * step_[axis],
                                             rig.axes[axis].lower, rig.axes[axis].upper);
      }
    }
    RigPoses(rig, slice.value, all.pick, &X_WC_);
    const std::vector<SampleJudge::Worth>* worth = nullptr;
    const int sample = window.first + i;
    if (distance >= 0) {
      const double lower = rig.axes[distance].lower, upper = rig.axes[distance].upper;
      const std::vector<double>& back = judge_->BackAt(sample, X_WC_);
      // Further than need be by as much as the path is, and by the steps.
      const auto need = [&](int direction) {
        return std::max(0.0, back[direction] + 1e-12 * model_.unit());
      };
      const double spare = std::max(0.0, own(distance) - lower - need(all.direction[0]));
      by_.resize(all.code.size());
      slice.distance.resize(all.code.size());
      for (std::size_t n = 0; n < by_.size(); ++n) {
        const double further = spare + by[all.code[n][distance]] * step_[distance];
        const double wanted = lower + need(all.direction[n]) + std::max(0.0, further);
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

  // From one sample to another, for each pair of the moves of the nodes about them: adds what the
  // latter is worth to the sums, -inf where the speeds do not allow it.
  void Pass(const Window& window, int before, int i, bool from_node, bool to_node, double weight,
            const std::vector<RigVector>& path, std::vector<double>* sum) {
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
      for (int j = 0; j < movings; ++j)
        may = may && allowed[moving[j]][between_.code[p][moving[j]]];
      if (distance >= 0) may = may && std::abs(here.distance[b] - last.distance[a]) <= by_distance;
      (*sum)[p] = may ? (*sum)[p] + weight * here.reward[b] : -kInfinity;
      if (soft && way2 > reach.centre2())
        (*sum)[p] -= weight * haste_ * (std::sqrt(way2 / reach.centre2()) - 1.0);
    }
  }

  const PlacementModel& model_;
  const SearchSpace& space_;
  double penalty_;
  double haste_{kInfinity};
  SampleJudge* judge_;
  Neighbours at_node_, between_;
  std::vector<double> step_;  // of each rig axis
  std::vector<Isometry3d> X_WC_;
  std::vector<double> by_;
  std::vector<Slice> slices_;
};

// Moves of a node: one step of one of `most` axes, another choice with each `turn`.
std::vector<std::vector<int>> AlongAxes(int free_axes, int most, int turn) {
  std::vector<std::vector<int>> moves{std::vector<int>(free_axes, 0)};
  for (int i = 0; i < std::min(most, free_axes); ++i) {
    for (const int by : {1, -1}) {
      moves.emplace_back(free_axes, 0);
      moves.back()[(turn + i) % free_axes] = by;
    }
  }
  return moves;
}

// Moves of a node: a step of each of two axes, another pair with each `turn`.
std::vector<std::vector<int>> OverPair(int free_axes, int turn) {
  if (free_axes < 2) return AlongAxes(free_axes, 1, 0);
  const int stride = 1 + turn / free_axes % (free_axes - 1);
  const int a = turn % free_axes, b = (a + stride) % free_axes;
  std::vector<std::vector<int>> moves;
  for (const int by_a : {0, 1, -1}) {
    for (const int by_b : {0, 1, -1}) {
      moves.emplace_back(free_axes, 0);
      moves.back()[a] = by_a;
      moves.back()[b] = by_b;
    }
  }
  return moves;
}

// Rounds [first, end) of a refinement of `all`.
struct Rounds {
  int first, end, all;
};

// How far apart nodes may lie, as a share of the window, and how many axes a round moves when it moves each alone.
struct Reshaping {
  int parts, axes;
};
constexpr Reshaping kOfPath{4, 3};
// With few rounds short waves of few moves gain most for their time.
constexpr Reshaping kOfWindow{8, 2};

// Long waves first, then ever shorter ones, over and over with smaller steps.
constexpr std::array<int, 6> kSpacing{32, 16, 8, 4, 2, 1};
Tube::Round RoundOf(const Window& window, const Reshaping& by, int free_axes, int round,
                    double share) {
  constexpr double kFirstStep = 0.5, kLastStep = 0.1;
  const auto waves = static_cast<int>(kSpacing.size());
  Tube::Round of;
  of.window = window;
  of.moves =
      round / waves % 2 == 0 ? AlongAxes(free_axes, by.axes, round) : OverPair(free_axes, round);
  of.spacing = std::min(kSpacing[round % waves], std::max(1, window.count / by.parts));
  of.offset = 1 + (round * 7919) % of.spacing;
  of.step = kFirstStep * std::pow(kLastStep / kFirstStep, share);
  return of;
}

double ShareOf(const Rounds& rounds, int round) {
  return rounds.all > 1 ? static_cast<double>(round) / (rounds.all - 1) : 1.0;
}

// Refines a whole path. What moves at its greatest speed can hardly change its way: speeds may be exceeded at
// first, at a price that rises, and not every sample is looked at. The last rounds keep them.
void RefineFreely(const PlacementModel& model, const SearchSpace& space, const Rounds& rounds,
                  Tube* tube, SampleJudge* judge, std::vector<RigVector>* path) {
  constexpr double kFree = 0.85;  // of the rounds
  constexpr double kFirstPrice = 10.0, kLastPrice = 1000.0;
  constexpr int kMostStride = 4;
  const ArmMotion& motion = model.problem().motion;
  double worth = 0.0;
  for (int i = 0; i < motion.size(); ++i) worth += judge->Of(i, (*path)[i]).value;
  const double mean = std::abs(worth) / motion.size();
  for (int r = rounds.first; r < rounds.end; ++r) {
    const double share = ShareOf(rounds, r);
    Tube::Round round = RoundOf({0, motion.size(), false}, kOfPath, space.size(), r, share);
    if (share < kFree) {
      round.stride = std::clamp(round.spacing / 2, 1, kMostStride);
      round.haste = mean * kFirstPrice * std::pow(kLastPrice / kFirstPrice, share / kFree);
    } else if (r == 0 || ShareOf(rounds, r - 1) < kFree) {
      Obey(model, space, judge, path);
    }
    tube->Refine(round, path);
  }
}

void CheckPathObjective(const PlacementModel& model) {
  if (model.problem().objective.aggregate == PlanAggregate::kWorst) {
    throw ConfigError("", "objective.over", "must be integral where the camera moves (eq. 15)");
  }
  if (!model.problem().uncertainty.none()) {
    throw ConfigError("", "robust", "is for cameras that stand still");
  }
  if (model.problem().motion.size() < 4) {
    throw ConfigError("", "motion.samples", "must be 4 or more where the camera moves");
  }
}

}  // namespace

std::vector<int> BestSequence(const MatrixXd& value,
                              const std::vector<std::vector<int>>& predecessor) {
  if (value.rows() == 0 || value.cols() == 0) return {};
  const Sequences sequences(value, predecessor, [](Eigen::Index, int, int) { return true; });
  const int end = sequences.BestEnd();
  return end < 0 ? std::vector<int>() : sequences.To(end);
}

CameraPath JudgePath(const PlacementModel& model, std::vector<RigVector> q_c) {
  SampleJudge judge(model);
  return Judge(model, std::move(q_c), &judge);
}

bool KeepsSpeeds(const PlacementModel& model, const CameraPath& path) {
  const PlacementProblem& problem = model.problem();
  for (std::size_t i = 1; i < path.q_c.size(); ++i) {
    const double dt = problem.motion.time[i] - problem.motion.time[i - 1];
    if (!MayFollow(problem.rig, path.q_c[i - 1], path.q_c[i], dt)) return false;
  }
  return true;
}

CameraPathResult PlanCameraPath(const PlacementModel& model, const PlacedCamera& best_fixed,
                                const CameraPathSearch& search, const PlanProgress& progress) {
  CheckPathObjective(model);
  const PlacementProblem& problem = model.problem();
  const SearchSpace space(Moving(problem), problem.q_c_start);
  SampleJudge judge(model);
  CameraPathResult result;
  result.fixed =
      Judge(model, std::vector<RigVector>(problem.motion.size(), best_fixed.q_c), &judge);
  result.path = result.fixed;
  result.evaluations = judge.evaluations();
  if (space.size() == 0) return result;
  const auto tell = [&](double share) {
    if (progress) progress("camera path", share, result.path.value);
  };
  const auto better = [](const CameraPath& a, const CameraPath& b) {
    return a.broken != b.broken ? a.broken < b.broken : a.value > b.value;
  };
  // From the best fixed camera, and from the best paths over lattices that differ in how fine they are.
  struct Runner {
    std::vector<RigVector> q_c;
    CameraPath judged;
  };
  std::vector<Runner> runners{{result.fixed.q_c, {}}};
  PullNear(model, space, &judge, &runners[0].q_c);
  for (const int part : {4, 2, 1}) {
    Lattice lattice(model, space, best_fixed.q_c, std::max(2, search.states / part), &judge);
    runners.push_back({lattice.BestPath(), {}});
  }
  tell(0.3);
  // All go some way, the better half further, the best to the end.
  const int heat = std::max(1, search.rounds / 12);
  Tube tube(model, space, judge.Penalty(), &judge);
  for (int done = 0; done < search.rounds;) {
    const int until = runners.size() > 1 ? std::min(search.rounds, done + heat) : search.rounds;
    for (Runner& runner : runners) {
      RefineFreely(model, space, {done, until, search.rounds}, &tube, &judge, &runner.q_c);
      runner.judged = Judge(model, runner.q_c, &judge);
      if (better(runner.judged, result.path) && KeepsSpeeds(model, runner.judged)) {
        result.path = runner.judged;
      }
    }
    std::stable_sort(runners.begin(), runners.end(),
                     [&](const Runner& a, const Runner& b) { return better(a.judged, b.judged); });
    runners.resize((runners.size() + 1) / 2);
    done = until;
    tell(0.3 + 0.7 * done / search.rounds);
  }
  result.evaluations = judge.evaluations();
  return result;
}

double RefineWindow(const PlacementModel& model, int first, int count, int rounds, bool hold_first,
                    CameraPath* path) {
  CheckPathObjective(model);
  const PlacementProblem& problem = model.problem();
  const SearchSpace space(Moving(problem), problem.q_c_start);
  if (space.size() == 0) return 0.0;
  SampleJudge judge(model);
  std::vector<SampleJudge::Worth> worth;
  for (int i = first; i < first + count; ++i) worth.push_back(judge.Of(i, path->q_c[i]));
  const double penalty = judge.Penalty();
  double before = 0.0;
  for (const SampleJudge::Worth& of_sample : worth) before += Reward(of_sample, penalty);
  Tube tube(model, space, penalty, &judge);
  double now = before;
  for (int r = 0; r < rounds; ++r) {
    const double share = ShareOf({0, rounds, rounds}, r);
    now = tube.Refine(RoundOf({first, count, hold_first}, kOfWindow, space.size(), r, share),
                      &path->q_c)
              .value_or(now);
  }
  return now - before;
}

}  // namespace vantage
