#include "vantage/plan/placement.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include <Eigen/LU>

#include "candidates.h"
#include "cma_es.h"
#include "polish.h"
#include "search_space.h"

namespace vantage {
namespace {

using Eigen::Isometry3d;
using plan::Better;
using plan::Candidate;
using plan::CmaEs;
using plan::Distinct;
using plan::Judge;
using plan::Place;
using plan::Polisher;
using plan::SearchSpace;
using plan::SearchVector;
using plan::SpreadOut;

// Starts are this far apart along some axis, as a share of its range.
constexpr double kApart = 0.1;

// With more free axes the slope leads up a hill in fewer steps than an evolution strategy takes.
constexpr int kFewAxes = 4;

// Volumes have slopes; singular values that change places and the least of samples have edges, on which a climb
// from afar gets stuck.
bool IsSmooth(const PlanObjective& objective) {
  const bool volume =
      objective.measure == BatchMeasure::kW || objective.measure == BatchMeasure::kLogW;
  return volume && objective.aggregate == PlanAggregate::kIntegral;
}

struct Effort {
  PlacementSearch search;  // nothing left open
  bool climbs;             // by slopes where it can
};

Effort EffortOf(PlacementSearch search, const PlanObjective& objective, int free_axes) {
  const bool few = free_axes <= kFewAxes;
  const bool climbs = !few && search.generations == 0 && IsSmooth(objective);
  const auto fill = [](int* value, int fallback) {
    if (*value == 0) *value = fallback;
  };
  fill(&search.grid, few ? 2560 : 40960);
  fill(&search.starts, few ? 16 : climbs ? 192 : 128);
  fill(&search.members, few ? 16 : 24);
  fill(&search.generations, few ? 24 : 80);
  search.polished = std::max(1, search.polished);
  return {search, climbs};
}

// The first grid: where stepping back makes a camera the nearest that its direction allows, half the
// cameras begin at the near end.
std::vector<Candidate> FirstGrid(const SearchSpace& space, int count, bool nearest) {
  std::vector<Candidate> candidates = SpreadOut(space, count, 0);
  if (nearest && space.step_axis() >= 0) {
    for (Candidate& c : candidates) c.u(0) = 0.0;
  }
  return candidates;
}

// After these shares of the generations the worse half of the strategies gives up, and of those that climb
// the same hill all but the best.
constexpr std::array<double, 3> kHalvings{0.15, 0.3, 0.5};
constexpr double kSameHill = 0.02;

// Those of `alive` that go on, at most `most`.
std::vector<std::size_t> Leaders(const SearchSpace& space, const std::vector<Candidate>& best,
                                 std::vector<std::size_t> alive, std::size_t most) {
  std::sort(alive.begin(), alive.end(),
            [&](std::size_t a, std::size_t b) { return Better(best[a], best[b]); });
  std::vector<std::size_t> leaders;
  for (const std::size_t i : alive) {
    if (leaders.size() >= most) break;
    const bool other_hill = std::all_of(leaders.begin(), leaders.end(), [&](std::size_t leader) {
      return space.Distance(best[i].u, best[leader].u) >= kSameHill;
    });
    if (other_hill) leaders.push_back(i);
  }
  std::sort(leaders.begin(), leaders.end());
  return leaders;
}

// Orders the members of strategies. An evolution strategy looks at its best half alone: whether something hides
// a marker is checked best first, until that many keep everything.
class Ranking {
 public:
  Ranking(const SearchSpace& space, int members, Judge* judge)
      : space_(space), members_(members), judge_(judge) {}

  /// Generations one after the other, but for sights judged.
  void Rank(std::vector<Candidate>* generations) {
    worth_.clear();
    for (const Candidate& c : *generations) {
      // A step back or over a bound makes no difference to what is judged: a little against drift.
      worth_.push_back(c.merit - 0.01 * c.back - space_.Excess(c.u));
    }
    const std::size_t strategies = generations->size() / members_;
    orders_.resize(strategies);
    for (std::vector<int>& order : orders_) {
      order.resize(members_);
      std::iota(order.begin(), order.end(), 0);
    }
    do {
      asked_.clear();
      for (std::size_t a = 0; a < strategies; ++a) Order(a, generations->data() + a * members_);
      judge_->Sights(asked_, BatchPrecision::kSingle);
    } while (!asked_.empty());
  }
  /// Of strategy a, best first; right as far as CmaEs::mu().
  [[nodiscard]] const std::vector<int>& order(std::size_t a) const { return orders_[a]; }
  /// All that there is to know of a member was checked.
  [[nodiscard]] static bool Known(const Candidate& c) {
    return c.sights_checked || c.violation > 0.0;
  }

 private:
  void Order(std::size_t a, Candidate* own) {
    std::vector<int>& order = orders_[a];
    const double* worth = worth_.data() + a * members_;
    std::sort(order.begin(), order.end(), [&](int i, int j) {
      const double vi = own[i].violation, vj = own[j].violation;
      return vi != vj ? vi < vj : worth[i] > worth[j];
    });
    for (int i = 0; i < members_ / 2; ++i) {
      if (!Known(own[order[i]])) asked_.push_back(&own[order[i]]);
    }
  }

  const SearchSpace& space_;
  int members_;
  Judge* judge_;
  std::vector<double> worth_;
  std::vector<std::vector<int>> orders_;
  std::vector<Candidate*> asked_;
};

// All strategies side by side: one generation of each is judged together, in single precision: polishing does
// the rest.
std::vector<Candidate> Evolve(const SearchSpace& space, const std::vector<Candidate>& starts,
                              const PlacementSearch& search, double step, Judge* judge,
                              const std::function<void(double, const Candidate&)>& told) {
  constexpr double kDone = 1e-5;  // what polishing does better
  std::vector<CmaEs> strategies;
  std::vector<Candidate> best = starts;
  for (std::size_t i = 0; i < starts.size(); ++i) {
    // From where the start was judged, not from where it was asked for.
    strategies.emplace_back(space.FromRig(starts[i].q_c), step, search.members,
                            search.seed + 1000 * i);
  }
  std::vector<Candidate> generation;
  Ranking ranking(space, search.members, judge);
  std::vector<std::size_t> alive(strategies.size());
  std::iota(alive.begin(), alive.end(), std::size_t{0});
  for (int g = 0; g < search.generations; ++g) {
    const auto done = [&](std::size_t i) { return strategies[i].reach() < kDone; };
    alive.erase(std::remove_if(alive.begin(), alive.end(), done), alive.end());
    for (const double share : kHalvings) {
      if (g != static_cast<int>(share * search.generations)) continue;
      const std::size_t half = (alive.size() + 1) / 2;
      alive = Leaders(space, best, alive, std::max<std::size_t>(half, search.polished));
    }
    generation.clear();
    for (const std::size_t i : alive) {
      for (const SearchVector& u : strategies[i].Ask()) {
        Candidate c;
        c.u = u;
        generation.push_back(c);
      }
    }
    if (alive.empty()) break;
    const auto members = static_cast<int>(generation.size());
    judge->Frustum(generation.data(), members, BatchPrecision::kSingle);
    ranking.Rank(&generation);
    for (std::size_t a = 0; a < alive.size(); ++a) {
      Candidate& record = best[alive[a]];
      const Candidate* own = generation.data() + a * search.members;
      for (int i = 0; i < search.members; ++i) {
        if (ranking.Known(own[i]) && Better(own[i], record)) record = own[i];
      }
      strategies[alive[a]].Tell(ranking.order(a));
    }
    if (told) {
      const Candidate& leader = *std::min_element(best.begin(), best.end(), Better);
      told(static_cast<double>(g + 1) / search.generations, leader);
    }
  }
  judge->Frustum(best.data(), static_cast<int>(best.size()), BatchPrecision::kDouble);
  judge->Sights(best.data(), static_cast<int>(best.size()));
  return best;
}

// What rough polishing may leave, of the merit and as a share of an axis' range.
constexpr double kRoughMerit = 1e-3;
constexpr double kSamePlace = 1e-6;

// Which of two polished cameras is better.
bool Higher(const Polisher& a, const Polisher& b) {
  if (a.keeps() != b.keeps()) return a.keeps();
  return a.keeps() ? a.merit() > b.merit() : a.violation() < b.violation();
}

std::vector<ActiveLimit> ActiveLimits(const PlacementModel& model, const PlacedCamera& camera) {
  const double tight = 1e-6 * model.unit();
  std::vector<ActiveLimit> active;
  for (int i = 0; i < kPlanLimits; ++i) {
    if (camera.margins[i] < tight) {
      active.push_back({model.NameOf(static_cast<PlanLimit>(i)), camera.margins[i]});
    }
  }
  const CameraRig& rig = model.problem().rig;
  for (int i = 0; i < rig.size(); ++i) {
    const RigAxis& axis = rig.axes[i];
    const double range = axis.upper - axis.lower;
    if (!(range > 0.0)) continue;
    if (camera.q_c(i) - axis.lower < 1e-9 * range) {
      active.push_back({axis.name + ", lower end", camera.q_c(i) - axis.lower});
    } else if (axis.upper - camera.q_c(i) < 1e-9 * range) {
      active.push_back({axis.name + ", upper end", axis.upper - camera.q_c(i)});
    }
  }
  return active;
}

// Of all candidates: which limit stands in the way, and by how much.
std::vector<LimitDiagnosis> Diagnose(const PlacementModel& model, std::vector<Candidate> candidates,
                                     const PlacedCamera& nearest, Judge* judge) {
  // Sights of what the frustum would allow were checked; here they are asked of all.
  for (Candidate& c : candidates) {
    if (c.sights_checked) continue;
    c.violation = 0.0;
  }
  judge->Sights(candidates.data(), static_cast<int>(candidates.size()));
  std::vector<LimitDiagnosis> diagnosis;
  for (int i = 0; i < kPlanLimits; ++i) {
    LimitDiagnosis d;
    d.name = model.NameOf(static_cast<PlanLimit>(i));
    d.best_margin = nearest.margins[i];
    d.margin_at_nearest = nearest.margins[i];
    for (const Candidate& c : candidates) {
      d.best_margin = std::max(d.best_margin, c.margins[i]);
      PlanMargins others = c.margins;
      others[i] = 0.0;
      d.alone_prevents = d.alone_prevents || model.Keeps(others);
    }
    PlanMargins others = nearest.margins;
    others[i] = 0.0;
    d.alone_prevents = d.alone_prevents || model.Keeps(others);
    if (std::isfinite(d.best_margin) && (d.margin_at_nearest < 0.0 || d.best_margin < 0.0)) {
      diagnosis.push_back(d);
    }
  }
  return diagnosis;
}

WorstCaseWarning WarnOfWorstCase(const PlacementModel& model, const SearchSpace& space,
                                 const PlacedCamera& best) {
  WorstCaseWarning warning;
  const PlacementProblem& problem = model.problem();
  if (problem.objective.aggregate != PlanAggregate::kWorst) return warning;
  const auto jacobian = [&](int sample, const Isometry3d& X_WC) {
    return PlainJacobian(model.scene(), sample, X_WC, 1.0, problem.lens);
  };
  const auto warn = [&](WorstCaseWarning::Kind kind, int sample) {
    warning = {kind, sample, problem.motion.time[sample]};
    return warning;
  };
  // Rank lost from here and from cameras all over the workspace: the arm's doing.
  constexpr double kLost = 1e-9;
  const auto is_singular = [&](int sample, const Isometry3d& X_WC) {
    const Eigen::MatrixXd J = jacobian(sample, X_WC);
    return !J.allFinite() || MeasureOf(J).inverse_condition() < kLost;
  };
  for (int i = 0; i < problem.motion.size(); ++i) {
    bool singular = is_singular(i, best.X_WC);
    for (int k = 0; singular && k < 8; ++k) {
      singular = is_singular(i, RigPose(space.rig(), space.ToRig(space.Spread(k))));
    }
    if (singular) return warn(WorstCaseWarning::Kind::kArmSingular, i);
  }
  double last = 0.0;
  for (int i = 0; i < problem.motion.size(); ++i) {
    const Eigen::MatrixXd J = jacobian(i, best.X_WC);
    if (J.rows() != J.cols() || !J.allFinite()) return warning;
    const double det = J.determinant();
    if (det * last < 0.0) return warn(WorstCaseWarning::Kind::kChangesSign, i);
    last = det;
  }
  return warning;
}

}  // namespace

PlacementResult PlaceCamera(const PlacementModel& model, const PlacementSearch& effort,
                            const PlanProgress& progress) {
  const PlacementProblem& problem = model.problem();
  const SearchSpace space(problem.rig, problem.q_c_start);
  const auto [search, climbs] = EffortOf(effort, problem.objective, space.size());
  Judge judge(model, space);
  PlacementResult result;
  const auto tell = [&](const char* stage, double share, const Candidate* best) {
    if (!progress) return;
    std::optional<double> value;
    if (best != nullptr && best->violation == 0.0 && best->sights_checked) {
      value = model.Value(best->score);
    }
    progress(stage, share, value);
  };

  // The nearer the better holds for volumes, not for conditions.
  const BatchMeasure measure = problem.objective.measure;
  const bool nearest = measure == BatchMeasure::kW || measure == BatchMeasure::kLogW;
  std::vector<Candidate> grid =
      space.size() == 0 ? std::vector<Candidate>(1) : FirstGrid(space, search.grid, nearest);
  if (space.size() == 0) grid[0].u.resize(0);
  judge.Frustum(grid.data(), static_cast<int>(grid.size()), BatchPrecision::kSingle);
  tell("grid", 0.1, nullptr);

  std::vector<Candidate> ends = Distinct(&grid, space, static_cast<std::size_t>(search.starts),
                                         kApart, &judge, BatchPrecision::kSingle);
  const auto keeps = [](const Candidate& c) { return c.violation == 0.0; };
  // A slope needs limits that are kept to start from.
  const bool climb = climbs && std::all_of(ends.begin(), ends.end(), keeps);
  if (space.size() > 0 && !climb) {
    ends = Evolve(space, ends, search, 0.06, &judge, [&](double share, const Candidate& best) {
      tell("evolution", 0.1 + 0.7 * share, &best);
    });
    if (std::none_of(ends.begin(), ends.end(), keeps)) {
      // Once more, wider: from the least violations of a grid eight times as fine.
      grid = SpreadOut(space, 8 * search.grid, search.grid);
      judge.Frustum(grid.data(), static_cast<int>(grid.size()), BatchPrecision::kDouble);
      judge.Sights(grid.data(), static_cast<int>(grid.size()));
      ends = Distinct(&grid, space, static_cast<std::size_t>(search.starts), kApart, &judge);
      ends = Evolve(space, ends, search, 0.15, &judge, [&](double share, const Candidate& best) {
        tell("evolution, wider", 0.1 + 0.7 * share, &best);
      });
    }
  }

  const std::vector<Candidate> all_ends = ends;
  const auto polished = static_cast<std::size_t>(search.polished);
  if (!climb) ends = Distinct(&ends, space, polished, 1e-4, &judge);
  std::vector<Polisher> hills;
  hills.reserve(ends.size());
  for (const Candidate& end : ends) hills.emplace_back(model, space, end.q_c, &judge.scorer());
  if (climb) {
    for (std::size_t i = 0; i < hills.size(); ++i) {
      hills[i].Coarse();
      tell("climb", 0.1 + 0.7 * static_cast<double>(i + 1) / static_cast<double>(hills.size()),
           nullptr);
    }
    std::sort(hills.begin(), hills.end(), Higher);
    // Twice as many as are polished otherwise, for these heights are not exact.
    hills.erase(hills.begin() + static_cast<std::ptrdiff_t>(std::min(hills.size(), 2 * polished)),
                hills.end());
  }
  for (std::size_t i = 0; i < hills.size(); ++i) {
    hills[i].Rough();
    tell("polish", 0.8 + 0.15 * static_cast<double>(i + 1) / static_cast<double>(hills.size()),
         nullptr);
  }
  std::sort(hills.begin(), hills.end(), Higher);
  // The best to rounding, and what is as good within what rough polishing may leave but stands elsewhere.
  std::vector<SearchVector> rough;
  const double least = hills.front().merit() - kRoughMerit;
  const bool kept = hills.front().keeps();
  for (Polisher& hill : hills) {
    const SearchVector u = space.FromRig(hill.q_c());
    if (hill.keeps() != kept || (kept && hill.merit() < least)) continue;
    const bool known = std::any_of(rough.begin(), rough.end(), [&](const SearchVector& other) {
      return space.Distance(u, other) < kSamePlace;
    });
    rough.push_back(u);
    if (!known) hill.Finish();
  }
  std::sort(hills.begin(), hills.end(), Higher);
  result.best = Place(model, hills.front().q_c(), &judge.scorer());
  tell("polish", 1.0, nullptr);

  result.start = Place(model, problem.q_c_start, &judge.scorer());
  if (result.best.feasible) {
    result.active = ActiveLimits(model, result.best);
    result.warning = WarnOfWorstCase(model, space, result.best);
    // The least good of what is allowed: from the bad end of the grid.
    result.worst = result.best;
    std::vector<const Candidate*> allowed;
    for (const Candidate& c : grid) {
      if (c.violation == 0.0) allowed.push_back(&c);
    }
    const auto higher = [](const Candidate* a, const Candidate* b) { return Better(*a, *b); };
    std::make_heap(allowed.begin(), allowed.end(), higher);
    while (!allowed.empty()) {
      std::pop_heap(allowed.begin(), allowed.end(), higher);
      const PlacedCamera placed = Place(model, allowed.back()->q_c, &judge.scorer());
      allowed.pop_back();
      if (!placed.feasible) continue;
      result.worst = placed;
      break;
    }
  } else {
    grid.insert(grid.end(), all_ends.begin(), all_ends.end());
    result.diagnosis = Diagnose(model, std::move(grid), result.best, &judge);
  }
  result.evaluations = judge.scorer().evaluations();
  result.cameras = judge.cameras();
  return result;
}

PlacedCamera JudgeCamera(const PlacementModel& model, const RigVector& q_c) {
  CameraScorer scorer(model);
  return Place(model, q_c, &scorer);
}

PlacementMap MapPlacements(const PlacementModel& model, const RigVector& q_c, int axis_x,
                           int axis_y, int columns, int rows) {
  const PlacementProblem& problem = model.problem();
  const SearchSpace space(problem.rig, q_c);
  CameraScorer scorer(model);
  PlacementMap map;
  map.axis_x = axis_x;
  map.axis_y = axis_y;
  const auto values = [&](int axis, int count) {
    const RigAxis& limits = problem.rig.axes[axis];
    std::vector<double> all;
    for (int i = 0; i < count; ++i) {
      all.push_back(limits.lower + (limits.upper - limits.lower) * i / std::max(1, count - 1));
    }
    return all;
  };
  map.x = values(axis_x, columns);
  map.y = values(axis_y, rows);
  std::vector<Isometry3d> poses;
  for (const double y : map.y) {
    for (const double x : map.x) {
      PlacedCamera cell;
      cell.q_c = q_c;
      cell.q_c(axis_x) = x;
      cell.q_c(axis_y) = y;
      // From the near end, back to where the frustum is kept.
      const int step = space.step_axis();
      if (step >= 0 && step != axis_x && step != axis_y) {
        cell.q_c(step) = problem.rig.axes[step].lower;
      }
      map.cells.push_back(cell);
    }
  }
  const auto load = [&] {
    poses.clear();
    for (PlacedCamera& cell : map.cells) {
      cell.X_WC = RigPose(problem.rig, cell.q_c);
      poses.push_back(cell.X_WC);
    }
    scorer.Load(poses);
  };
  std::vector<PlanMargins> margins;
  load();
  scorer.Frustum(BatchPrecision::kDouble, &margins);
  const int step = space.step_axis();
  if (step >= 0 && step != axis_x && step != axis_y) {
    for (std::size_t i = 0; i < map.cells.size(); ++i) {
      const double back = TooNear(margins[i]);
      if (back > 0.0) {
        map.cells[i].q_c = space.StepBack(map.cells[i].q_c, back + 1e-12 * model.unit());
      }
    }
    load();
    scorer.Frustum(BatchPrecision::kDouble, &margins);
  }
  scorer.Obstacles(BatchPrecision::kDouble, &margins);
  std::vector<double> scores;
  scorer.Scores(BatchPrecision::kDouble, &scores);
  for (std::size_t i = 0; i < map.cells.size(); ++i) {
    map.cells[i].margins = margins[i];
    map.cells[i].value = model.Value(scores[i]);
    map.cells[i].feasible = model.Keeps(margins[i]);
  }
  return map;
}

}  // namespace vantage
