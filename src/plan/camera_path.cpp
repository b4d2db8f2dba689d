#include "vantage/plan/camera_path.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>

#include "search_space.h"
#include "vantage/math/error.h"

namespace vantage {
namespace {

using Eigen::Isometry3d;
using Eigen::MatrixXd;
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
  /// At one sample, of many cameras.
  const std::vector<Worth>& At(int sample, const std::vector<RigVector>& q_c) {
    const PlacementProblem& problem = model_.problem();
    const PlacementModel::SampleView& view = model_.sample_views()[sample];
    const auto count = static_cast<int>(q_c.size());
    Frustum(sample, q_c);
    evaluator_.Score(view.scene, cameras_, 0, count, problem.lens, problem.objective.measure,
                     BatchPrecision::kDouble, false, &scores_);
    if (view.obstacles) {
      evaluator_.CheckObstacles(*view.obstacles, cameras_, 0, count, BatchPrecision::kDouble,
                                &margins_);
    }
    evaluations_ += count;
    worth_.resize(q_c.size());
    for (int i = 0; i < count; ++i) {
      PlanMargins m{margins_.near[i],
                    margins_.far[i],
                    margins_.image[i],
                    view.obstacles ? margins_.occlusion[i] : kInfinity,
                    view.obstacles ? margins_.facing[i] : kInfinity,
                    kInfinity};
      for (const BatchBox& box : problem.limits.keep_out) {
        Tighten(PlanLimit::kKeepOut, DistanceToBox(box, places_[i]) - problem.limits.clearance, &m);
      }
      const bool keeps = model_.Keeps(m);
      // A measure of nothing (log 0) is as bad as a broken limit.
      const bool counts = keeps && std::isfinite(scores_.sum[i]);
      worth_[i] = {counts ? problem.motion.weight[sample] * scores_.sum[i] : 0.0,
                   counts ? 0.0 : std::max(model_.Violation(m), 1e-6)};
      largest_ = std::max(largest_, std::abs(worth_[i].value));
    }
    return worth_;
  }

  /// Where the cameras of the last call are.
  [[nodiscard]] const std::vector<Eigen::Vector3d>& places() const noexcept { return places_; }

  /// Moves cameras of one sample along the distance axis to the nearest place that keeps the frustum, in closed form
  /// as PlaceCamera() does. @pre space.step_axis() >= 0.
  void PullNear(int sample, const SearchSpace& space, std::vector<RigVector>* q_c) {
    const int axis = space.step_axis();
    for (RigVector& q : *q_c) q(axis) = space.rig().axes[axis].lower;
    Frustum(sample, *q_c);
    for (std::size_t i = 0; i < q_c->size(); ++i) {
      const double back = -std::min(margins_.near[i], margins_.image[i]);
      if (back > 0.0) (*q_c)[i] = space.StepBack((*q_c)[i], back + 1e-12 * model_.unit());
    }
  }

  /// A broken limit outweighs anything that was seen so far.
  [[nodiscard]] double Penalty() const noexcept {
    return 1e3 * model_.problem().motion.size() * (largest_ > 0.0 ? largest_ : 1.0);
  }
  [[nodiscard]] std::int64_t evaluations() const noexcept { return evaluations_; }

 private:
  // Sets the cameras and their margins near, far and image.
  void Frustum(int sample, const std::vector<RigVector>& q_c) {
    const PlacementProblem& problem = model_.problem();
    const PlacementModel::SampleView& view = model_.sample_views()[sample];
    const auto count = static_cast<int>(q_c.size());
    cameras_.Resize(count);
    places_.resize(q_c.size());
    for (int i = 0; i < count; ++i) {
      const Isometry3d X_WC = RigPose(problem.rig, q_c[i]);
      places_[i] = X_WC.translation();
      cameras_.Set(i, X_WC);
    }
    evaluator_.CheckFrustum(view.points ? *view.points : view.scene, cameras_, 0, count,
                            problem.lens, model_.depth(), BatchPrecision::kDouble, &margins_,
                            model_.rim_margin());
  }

  const PlacementModel& model_;
  BatchEvaluator evaluator_;
  BatchCameras cameras_;
  BatchScores scores_;
  BatchMargins margins_;
  std::vector<Eigen::Vector3d> places_;
  std::vector<Worth> worth_;
  double largest_{0.0};
  std::int64_t evaluations_{0};
};

double Reward(const SampleJudge::Worth& worth, double penalty) {
  return worth.violation > 0.0 ? -penalty * (1.0 + worth.violation) : worth.value;
}

bool MayFollow(const CameraRig& rig, const RigVector& from, const Eigen::Vector3d& p_from,
               const RigVector& to, const Eigen::Vector3d& p_to, double dt) {
  const double allowed = dt * (1.0 + kSpeedSlack) + 1e-12;
  for (int i = 0; i < rig.size(); ++i) {
    if (std::abs(to(i) - from(i)) > rig.axes[i].max_speed * allowed) return false;
  }
  return (p_to - p_from).norm() <= rig.max_linear_speed * allowed;
}

// The same along the straight line in rig coordinates, where the camera's own way is longer than between
// its ends.
bool MayMoveTo(const CameraRig& rig, const RigVector& from, const RigVector& to, double dt) {
  constexpr int kPieces = 8;
  constexpr double kReserve = 0.98;  // between the pieces' ends
  RigVector last = from;
  Eigen::Vector3d p_last = RigPose(rig, from).translation();
  for (int i = 1; i <= kPieces; ++i) {
    const RigVector next = from + (static_cast<double>(i) / kPieces) * (to - from);
    const Eigen::Vector3d p_next = RigPose(rig, next).translation();
    if (!MayFollow(rig, last, p_last, next, p_next, kReserve * dt / kPieces)) return false;
    last = next;
    p_last = p_next;
  }
  return true;
}

CameraPath Judge(const PlacementModel& model, std::vector<RigVector> q_c, SampleJudge* judge) {
  CameraPath path;
  path.q_c = std::move(q_c);
  double sum = 0.0;
  for (int i = 0; i < model.problem().motion.size(); ++i) {
    const SampleJudge::Worth worth = judge->At(i, {path.q_c[i]})[0];
    sum += worth.value;
    path.broken += worth.violation > 0.0 ? 1 : 0;
  }
  path.value = model.Value(sum);
  return path;
}

// The path as near as the frustum lets each sample be and the distance axis' speed allows: of all distances that
// are no nearer and keep the speed the least at each sample. Other axes stay.
void PullNear(const PlacementModel& model, const SearchSpace& space, SampleJudge* judge,
              std::vector<RigVector>* path) {
  constexpr double kReserve = 0.99;  // of the speed
  const int axis = space.step_axis();
  if (axis < 0) return;
  const ArmMotion& motion = model.problem().motion;
  const double speed = kReserve * space.rig().axes[axis].max_speed;
  const int N = motion.size();
  for (int i = 0; i < N; ++i) {
    std::vector<RigVector> one{(*path)[i]};
    judge->PullNear(i, space, &one);
    (*path)[i] = one[0];
  }
  for (int i = 1; i < N; ++i) {
    const double by = speed * (motion.time[i] - motion.time[i - 1]);
    (*path)[i](axis) = std::max((*path)[i](axis), (*path)[i - 1](axis) - by);
  }
  for (int i = N - 2; i >= 0; --i) {
    const double by = speed * (motion.time[i + 1] - motion.time[i]);
    (*path)[i](axis) = std::max((*path)[i](axis), (*path)[i + 1](axis) - by);
  }
}

// Stages of the coarse lattice: as many as let a camera get from one state to some neighbours in time.
int StagesFor(const SearchSpace& space, const ArmMotion& motion, int states) {
  const double cell = std::pow(static_cast<double>(states), -1.0 / space.size());
  double slowest = kInfinity;  // share of an axis' range in the whole time
  for (int i = 0; i < space.size(); ++i) {
    const RigAxis& axis = space.rig().axes[space.axis(i)];
    slowest = std::min(slowest, axis.max_speed * motion.time.back() / space.range(i));
  }
  const double stages = slowest / (1.5 * cell);
  return std::clamp(static_cast<int>(stages) + 1, 2, std::max(2, motion.size() / 2));
}

// The best path over scattered states that changes state between stages alone.
std::vector<RigVector> CoarsePath(const PlacementModel& model, const SearchSpace& space,
                                  const RigVector& q_c_fixed, const CameraPathSearch& search,
                                  SampleJudge* judge) {
  const ArmMotion& motion = model.problem().motion;
  std::vector<RigVector> states{q_c_fixed};
  for (int s = 1; s < search.states; ++s) states.push_back(space.ToRig(space.Spread(s)));
  const auto S = static_cast<Eigen::Index>(states.size());
  const int stages = StagesFor(space, motion, search.states);
  // Stage of a sample: the node in time that is nearest.
  const auto stage_of = [&](int sample) {
    return static_cast<int>(std::lround(motion.time[sample] / motion.time.back() * (stages - 1)));
  };
  // Where one axis is the distance each state stands for a direction, from as near as can be.
  const bool near = space.step_axis() >= 0;
  std::vector<std::vector<SampleJudge::Worth>> worth;
  for (int i = 0; i < motion.size(); ++i) {
    std::vector<RigVector> here = states;
    if (near) judge->PullNear(i, space, &here);
    worth.push_back(judge->At(i, here));
    if (i == motion.size() / 2) states = here;
  }
  std::vector<Eigen::Vector3d> places;
  for (const RigVector& q_c : states) places.push_back(RigPose(space.rig(), q_c).translation());
  MatrixXd value = MatrixXd::Zero(stages, S);
  for (int i = 0; i < motion.size(); ++i) {
    for (Eigen::Index s = 0; s < S; ++s) {
      value(stage_of(i), s) += Reward(worth[i][s], judge->Penalty());
    }
  }
  const double dt = motion.time.back() / (stages - 1);
  std::vector<std::vector<int>> predecessor(states.size());
  for (std::size_t a = 0; a < states.size(); ++a) {
    for (std::size_t b = 0; b < states.size(); ++b) {
      if (MayFollow(space.rig(), states[b], places[b], states[a], places[a], dt) &&
          MayMoveTo(space.rig(), states[b], states[a], dt)) {
        predecessor[a].push_back(static_cast<int>(b));
      }
    }
  }
  const std::vector<int> best = BestSequence(value, predecessor);
  std::vector<RigVector> path;
  for (int i = 0; i < motion.size(); ++i) {
    const double at = motion.time[i] / motion.time.back() * (stages - 1);
    const int stage = std::min(static_cast<int>(at), stages - 2);
    const RigVector& from = states[best[stage]];
    path.push_back(from + (at - stage) * (states[best[stage + 1]] - from));
  }
  if (near) PullNear(model, space, judge, &path);
  return path;
}

// Axes that a round varies: three at most, another choice each round.
std::vector<int> AxesOfRound(int free_axes, int round) {
  std::vector<int> axes;
  for (int i = 0; i < std::min(3, free_axes); ++i) {
    const int stride = free_axes > 3 && round % 2 == 1 ? 2 : 1;
    const int axis = (round + i * stride) % free_axes;
    if (std::find(axes.begin(), axes.end(), axis) == axes.end()) axes.push_back(axis);
  }
  return axes;
}

// One round: dynamic programming over the path and its neighbours at `step` of an axis' range.
void RefineRound(const PlacementModel& model, const SearchSpace& space, int first, int count,
                 bool hold_first, const std::vector<int>& axes, double step, double penalty,
                 SampleJudge* judge, std::vector<RigVector>* path) {
  const ArmMotion& motion = model.problem().motion;
  const CameraRig& rig = space.rig();
  int neighbours = 1;
  for (std::size_t i = 0; i < axes.size(); ++i) neighbours *= 3;
  std::vector<std::vector<RigVector>> states(count);
  std::vector<std::vector<Eigen::Vector3d>> places(count);
  MatrixXd best = MatrixXd::Constant(count, neighbours, -kInfinity);
  std::vector<std::vector<int>> from(count, std::vector<int>(neighbours, -1));
  std::vector<int> order(neighbours);  // states of the sample before, best first
  for (int i = 0; i < count; ++i) {
    const RigVector& own = (*path)[first + i];
    // State 0 is the path itself.
    for (int n = 0; n < neighbours; ++n) {
      RigVector q_c = own;
      if (!(hold_first && i == 0)) {
        int code = n;
        for (const int a : axes) {
          const double by = code % 3 == 0 ? 0.0 : code % 3 == 1 ? 1.0 : -1.0;
          const RigAxis& axis = rig.axes[space.axis(a)];
          q_c(space.axis(a)) =
              std::clamp(own(space.axis(a)) + by * step * space.range(a), axis.lower, axis.upper);
          code /= 3;
        }
      }
      states[i].push_back(q_c);
    }
    const std::vector<SampleJudge::Worth>& worth = judge->At(first + i, states[i]);
    places[i] = judge->places();
    for (int n = 0; n < neighbours; ++n) {
      const double reward = Reward(worth[n], penalty);
      if (i == 0) {
        // What comes before the window stays.
        const bool reached =
            first == 0 ||
            MayFollow(rig, (*path)[first - 1], RigPose(rig, (*path)[first - 1]).translation(),
                      states[0][n], places[0][n], motion.time[first] - motion.time[first - 1]);
        if (reached) best(0, n) = reward;
        continue;
      }
      const double dt = motion.time[first + i] - motion.time[first + i - 1];
      // Best first: the first that the speeds allow is the one.
      for (const int p : order) {
        if (!(best(i - 1, p) > -kInfinity)) break;
        if (!MayFollow(rig, states[i - 1][p], places[i - 1][p], states[i][n], places[i][n], dt)) {
          continue;
        }
        best(i, n) = best(i - 1, p) + reward;
        from[i][n] = p;
        break;
      }
    }
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(),
                     [&](int a, int b) { return best(i, a) > best(i, b); });
  }
  const int after = first + count;
  int last = -1;
  for (int n = 0; n < neighbours; ++n) {
    const bool leaves = after == motion.size() ||
                        MayFollow(rig, states[count - 1][n], places[count - 1][n], (*path)[after],
                                  RigPose(rig, (*path)[after]).translation(),
                                  motion.time[after] - motion.time[after - 1]);
    if (leaves && (last < 0 || best(count - 1, n) > best(count - 1, last))) last = n;
  }
  if (last < 0 || !(best(count - 1, last) > -kInfinity)) return;
  for (int i = count - 1; i >= 0; --i) {
    (*path)[first + i] = states[i][last];
    last = from[i][last];
  }
}

void Refine(const PlacementModel& model, const SearchSpace& space, int first, int count, int rounds,
            bool hold_first, double first_step, double penalty, SampleJudge* judge,
            std::vector<RigVector>* path, const std::function<void(double)>& told) {
  constexpr double kLastStep = 2e-4;
  for (int r = 0; r < rounds; ++r) {
    const double share = rounds > 1 ? static_cast<double>(r) / (rounds - 1) : 1.0;
    const double step = first_step * std::pow(kLastStep / first_step, share);
    RefineRound(model, space, first, count, hold_first, AxesOfRound(space.size(), r), step, penalty,
                judge, path);
    if (told) told(static_cast<double>(r + 1) / rounds);
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
  const Eigen::Index N = value.rows(), S = value.cols();
  if (N == 0 || S == 0) return {};
  Eigen::VectorXd sum = value.row(0);
  std::vector<std::vector<int>> from(N, std::vector<int>(S, -1));
  for (Eigen::Index i = 1; i < N; ++i) {
    Eigen::VectorXd next = Eigen::VectorXd::Constant(S, -kInfinity);
    for (Eigen::Index s = 0; s < S; ++s) {
      for (const int p : predecessor[s]) {
        if (sum(p) + value(i, s) > next(s)) {
          next(s) = sum(p) + value(i, s);
          from[i][s] = p;
        }
      }
    }
    sum = next;
  }
  Eigen::Index state = 0;
  if (!(sum.maxCoeff(&state) > -kInfinity)) return {};
  std::vector<int> sequence(N);
  for (Eigen::Index i = N - 1; i >= 0; --i) {
    sequence[i] = static_cast<int>(state);
    state = from[i][state];
  }
  return sequence;
}

CameraPath JudgePath(const PlacementModel& model, std::vector<RigVector> q_c) {
  SampleJudge judge(model);
  return Judge(model, std::move(q_c), &judge);
}

bool KeepsSpeeds(const PlacementModel& model, const CameraPath& path) {
  const PlacementProblem& problem = model.problem();
  for (std::size_t i = 1; i < path.q_c.size(); ++i) {
    const double dt = problem.motion.time[i] - problem.motion.time[i - 1];
    if (!MayFollow(problem.rig, path.q_c[i - 1],
                   RigPose(problem.rig, path.q_c[i - 1]).translation(), path.q_c[i],
                   RigPose(problem.rig, path.q_c[i]).translation(), dt)) {
      return false;
    }
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
  // From the lattice's best, and from the best fixed camera: a tube may lead either to the better end.
  constexpr double kWideTube = 0.05;
  std::vector<std::vector<RigVector>> starts{result.fixed.q_c};
  PullNear(model, space, &judge, &starts[0]);
  starts.push_back(CoarsePath(model, space, best_fixed.q_c, search, &judge));
  tell(0.3);
  const double penalty = judge.Penalty();
  for (std::size_t k = 0; k < starts.size(); ++k) {
    std::vector<RigVector>& path = starts[k];
    Refine(model, space, 0, problem.motion.size(), search.rounds, false, kWideTube, penalty, &judge,
           &path, [&](double share) { tell(0.3 + 0.35 * (static_cast<double>(k) + share)); });
    const CameraPath judged = Judge(model, path, &judge);
    if (better(judged, result.path) && KeepsSpeeds(model, judged)) result.path = judged;
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
  for (int i = first; i < first + count; ++i) judge.At(i, {path->q_c[i]});
  const double penalty = judge.Penalty();
  const auto worth = [&] {
    double sum = 0.0;
    for (int i = first; i < first + count; ++i) {
      sum += Reward(judge.At(i, {path->q_c[i]})[0], penalty);
    }
    return sum;
  };
  const double before = worth();
  Refine(model, space, first, count, rounds, hold_first, 0.02, penalty, &judge, &path->q_c, {});
  return worth() - before;
}

}  // namespace vantage
