#include "vantage/plan/grid_check.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "candidates.h"
#include "polish.h"
#include "search_space.h"

namespace vantage {
namespace {

using plan::Candidate;
using plan::Distinct;
using plan::Judge;
using plan::kInfinity;
using plan::Place;
using plan::SearchSpace;
using plan::SearchVector;
using plan::SpreadOut;

// Cameras of a block: large enough that dealing it out costs nothing beside its work.
constexpr std::int64_t kBlock = 8192;
// The sequence goes on far from where the search's own grid ended.
constexpr std::int64_t kFirst = 1000003;
// Cells are 1/32 of an axis wide: about as far as polished cameras are apart.
constexpr int kCellBits = 5;
constexpr std::size_t kPolished = 24;
constexpr double kApart = 0.03;
// Cameras whose sights are checked in one go.
constexpr std::size_t kFew = 16;

bool Before(const GridCamera& a, const GridCamera& b) {
  if (a.score != b.score) return a.score > b.score;
  return a.index < b.index;
}

// By where the camera was judged, not by where it was asked for: cameras that step back to one place are one.
std::uint64_t CellOf(const SearchSpace& space, const RigVector& q_c) {
  const int bits = std::min(kCellBits, 64 / std::max(1, space.size()));
  const double parts = 1 << bits;
  const SearchVector u = space.FromRig(q_c);
  std::uint64_t cell = 0;
  for (int i = 0; i < space.size(); ++i) {
    const double part = std::clamp(std::floor(u(i) * parts), 0.0, parts - 1.0);
    cell = (cell << bits) | static_cast<std::uint64_t>(part);
  }
  return cell;
}

}  // namespace

bool GridBest::Wants(const GridCamera& camera) const {
  if (cameras_.size() >= kMost && !Before(camera, cameras_.back())) return false;
  return std::all_of(cameras_.begin(), cameras_.end(), [&](const GridCamera& other) {
    return other.cell != camera.cell || Before(camera, other);
  });
}

bool GridBest::Offer(const GridCamera& camera) {
  if (!Wants(camera)) return false;
  const auto same = std::find_if(cameras_.begin(), cameras_.end(), [&](const GridCamera& other) {
    return other.cell == camera.cell;
  });
  if (same != cameras_.end()) {
    cameras_.erase(same);
  } else if (cameras_.size() >= kMost) {
    cameras_.pop_back();
  }
  cameras_.insert(std::lower_bound(cameras_.begin(), cameras_.end(), camera, Before), camera);
  return true;
}

std::optional<double> GridBest::ValueOfBest(const PlacementModel& model) const {
  if (cameras_.empty()) return std::nullopt;
  return model.Value(cameras_.front().score);
}

struct GridSearch::State {
  State(const PlacementModel& model, std::int64_t all)
      : cameras(all), space(model.problem().rig, model.problem().q_c_start), judge(model, space) {}

  std::int64_t cameras;
  SearchSpace space;
  Judge judge;
  GridBest best;  // of the blocks so far
};

GridSearch::GridSearch(const PlacementModel& model, std::int64_t cameras)
    : state_(std::make_unique<State>(model, cameras)) {}

GridSearch::~GridSearch() = default;

int GridSearch::BlocksOf(std::int64_t cameras) noexcept {
  return static_cast<int>((cameras + kBlock - 1) / kBlock);
}

std::vector<GridCamera> GridSearch::Search(int block) {
  const std::int64_t first = block * kBlock;
  const auto count = static_cast<int>(std::min(kBlock, state_->cameras - first));
  GridBest& best = state_->best;
  std::vector<Candidate> candidates = SpreadOut(state_->space, count, kFirst + first);
  state_->judge.Frustum(candidates.data(), count, BatchPrecision::kDouble);
  // Most are out for their score alone.
  const bool full = best.cameras().size() >= GridBest::kMost;
  const double least = full ? best.cameras().back().score : -kInfinity;
  std::vector<GridCamera> hopeful;
  for (int i = 0; i < count; ++i) {
    const Candidate& c = candidates[i];
    if (c.violation > 0.0 || !(c.score >= least)) continue;
    const GridCamera camera{first + i, CellOf(state_->space, c.q_c), c.score};
    if (best.Wants(camera)) hopeful.push_back(camera);
  }
  // Best first: sights are checked of little more than what is kept.
  std::sort(hopeful.begin(), hopeful.end(), Before);
  std::vector<GridCamera> found, asked;
  std::vector<Candidate> few;
  for (std::size_t at = 0; at < hopeful.size();) {
    asked.clear();
    few.clear();
    for (; at < hopeful.size() && asked.size() < kFew; ++at) {
      if (!best.Wants(hopeful[at])) continue;
      asked.push_back(hopeful[at]);
      few.push_back(candidates[hopeful[at].index - first]);
    }
    state_->judge.Sights(few.data(), static_cast<int>(few.size()));
    for (std::size_t i = 0; i < few.size(); ++i) {
      if (few[i].violation == 0.0 && best.Offer(asked[i])) found.push_back(asked[i]);
    }
  }
  return found;
}

GridCheck FinishGridCheck(const PlacementModel& model, const PlacedCamera& result,
                          const SearchedGrid& grid, const PlanProgress& progress) {
  const SearchSpace space(model.problem().rig, model.problem().q_c_start);
  Judge judge(model, space);
  GridCheck check;
  check.cameras = grid.cameras;
  check.best_on_grid = -kInfinity;
  std::vector<Candidate> candidates;
  for (const GridCamera& camera : grid.best.cameras()) {
    candidates.push_back(SpreadOut(space, 1, kFirst + camera.index).front());
  }
  judge.Frustum(candidates.data(), static_cast<int>(candidates.size()), BatchPrecision::kDouble);
  for (Candidate& c : candidates) c.u = space.FromRig(c.q_c);  // apart by where they stand
  const std::vector<Candidate> apart = Distinct(&candidates, space, kPolished, kApart, &judge);
  for (std::size_t i = 0; i < apart.size(); ++i) {
    const PlacedCamera raw = Place(model, apart[i].q_c, &judge.scorer());
    if (!raw.feasible) continue;
    check.best_on_grid = std::max(check.best_on_grid, raw.value);
    const PlacedCamera polished =
        Place(model, plan::Polish(model, space, apart[i].q_c, &judge.scorer()), &judge.scorer());
    if (polished.feasible && (!check.best.feasible || polished.value > check.best.value)) {
      check.best = polished;
    }
    if (progress) {
      const double share = static_cast<double>(i + 1) / static_cast<double>(apart.size());
      progress("grid check, polish", share, check.best_on_grid);
    }
  }
  if (!check.best.feasible) {
    check.gap = -kInfinity;
  } else {
    check.gap = (check.best.value - result.value) /
                std::max(std::abs(check.best.value), std::numeric_limits<double>::min());
  }
  return check;
}

GridCheck CheckAgainstGrid(const PlacementModel& model, const PlacedCamera& result,
                           std::int64_t cameras) {
  SearchedGrid grid;
  grid.cameras = cameras;
  GridSearch search(model, cameras);
  for (int block = 0; block < GridSearch::BlocksOf(cameras); ++block) {
    for (const GridCamera& camera : search.Search(block)) grid.best.Offer(camera);
  }
  return FinishGridCheck(model, result, grid);
}

}  // namespace vantage
