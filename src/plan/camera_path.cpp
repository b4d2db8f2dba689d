#include "vantage/plan/camera_path.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "path_lattice.h"
#include "path_tube.h"
#include "rig_speed.h"
#include "sample_judge.h"
#include "search_space.h"
#include "sequences.h"
#include "vantage/math/error.h"

namespace vantage {
namespace {

using Eigen::MatrixXd;
using plan::MayFollow;
using plan::Obey;
using plan::PathLattice;
using plan::PathTube;
using plan::PullNear;
using plan::SampleJudge;
using plan::SearchSpace;

// The rig with the axes locked that cannot move.
CameraRig Moving(const PlacementProblem& problem) {
  CameraRig rig = problem.rig;
  for (int i = 0; i < rig.size(); ++i) {
    if (rig.axes[i].max_speed == 0.0) rig.axes[i].lower = rig.axes[i].upper = problem.q_c_start(i);
  }
  return rig;
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
PathTube::Round RoundOf(const PathTube::Window& window, const Reshaping& by, int free_axes,
                        int round, double share) {
  constexpr double kFirstStep = 0.5, kLastStep = 0.1;
  const auto waves = static_cast<int>(kSpacing.size());
  PathTube::Round of;
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
                  PathTube* tube, SampleJudge* judge, std::vector<RigVector>* path,
                  const std::function<void(int)>& told) {
  constexpr double kFree = 0.85;  // of the rounds
  constexpr double kFirstPrice = 10.0, kLastPrice = 1000.0;
  constexpr int kMostStride = 4;
  const ArmMotion& motion = model.problem().motion;
  double worth = 0.0;
  for (int i = 0; i < motion.size(); ++i) worth += judge->Of(i, (*path)[i]).value;
  const double mean = std::abs(worth) / motion.size();
  for (int r = rounds.first; r < rounds.end; ++r) {
    const double share = ShareOf(rounds, r);
    PathTube::Round round = RoundOf({0, motion.size(), false}, kOfPath, space.size(), r, share);
    if (share < kFree) {
      round.stride = std::clamp(round.spacing / 2, 1, kMostStride);
      round.haste = mean * kFirstPrice * std::pow(kLastPrice / kFirstPrice, share / kFree);
    } else if (r == 0 || ShareOf(rounds, r - 1) < kFree) {
      Obey(model, space, judge, path);
    }
    tube->Refine(round, path);
    told(r);
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
  return plan::Sequences(value, predecessor, [](Eigen::Index, int, int) { return true; }).Best();
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
    PathLattice lattice(model, space, best_fixed.q_c, std::max(2, search.states / part), &judge);
    std::vector<RigVector> path = lattice.BestPath();
    if (!path.empty()) runners.push_back({std::move(path), {}});
  }
  tell(0.3);
  // All go some way, the better half further, the best to the end.
  const int heat = std::max(1, search.rounds / 12);
  PathTube tube(model, space, judge.Penalty(), &judge);
  for (int done = 0; done < search.rounds;) {
    const int until = runners.size() > 1 ? std::min(search.rounds, done + heat) : search.rounds;
    for (std::size_t k = 0; k < runners.size(); ++k) {
      Runner& runner = runners[k];
      RefineFreely(
          model, space, {done, until, search.rounds}, &tube, &judge, &runner.q_c, [&](int round) {
            // Of this heat, all runners together.
            const double of_heat = (static_cast<double>(k) * (until - done) + round + 1 - done) /
                                   static_cast<double>(runners.size());
            tell(0.3 + 0.7 * (done + of_heat) / search.rounds);
          });
      runner.judged = Judge(model, runner.q_c, &judge);
      if (better(runner.judged, result.path) && KeepsSpeeds(model, runner.judged)) {
        result.path = runner.judged;
      }
    }
    std::stable_sort(runners.begin(), runners.end(),
                     [&](const Runner& a, const Runner& b) { return better(a.judged, b.judged); });
    runners.resize((runners.size() + 1) / 2);
    done = until;
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
  PathTube tube(model, space, penalty, &judge);
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
