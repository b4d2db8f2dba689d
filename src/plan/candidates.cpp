#include "candidates.h"

#include <algorithm>
#include <numeric>

namespace vantage::plan {
namespace {

// Cameras that are scored in one go.
constexpr int kBlock = 512;

}  // namespace

bool Better(const Candidate& a, const Candidate& b) {
  if (a.violation != b.violation) return a.violation < b.violation;
  return a.merit > b.merit;
}

BestFirst::BestFirst(const std::vector<Candidate>& candidates) {
  heap_.reserve(candidates.size());
  for (const Candidate& c : candidates) heap_.push_back({c.violation, c.merit, heap_.size()});
  std::make_heap(heap_.begin(), heap_.end(), Worse);
}

std::size_t BestFirst::Take() {
  std::pop_heap(heap_.begin(), heap_.end(), Worse);
  const std::size_t index = heap_.back().index;
  heap_.pop_back();
  return index;
}

bool BestFirst::Worse(const Entry& a, const Entry& b) {
  if (a.violation != b.violation) return a.violation > b.violation;
  if (a.merit != b.merit) return a.merit < b.merit;
  return a.index > b.index;
}

void Judge::Frustum(Candidate* first, int count, BatchPrecision precision) {
  for (int done = 0; done < count; done += kBlock) {
    Block(first + done, std::min(kBlock, count - done), precision);
  }
}

void Judge::Sights(Candidate* first, int count, BatchPrecision precision) {
  std::vector<Candidate*> all(count);
  std::iota(all.begin(), all.end(), first);
  Sights(all, precision);
}

void Judge::Sights(const std::vector<Candidate*>& candidates, BatchPrecision precision) {
  if (model_.obstacles() == nullptr) {
    for (Candidate* c : candidates) c->sights_checked = true;
    return;
  }
  asked_.clear();
  poses_.clear();
  for (Candidate* c : candidates) {
    if (c->sights_checked || c->violation > 0.0) continue;
    asked_.push_back(c);
    poses_.push_back(RigPose(space_.rig(), c->q_c));
  }
  if (asked_.empty()) return;
  margins_.resize(asked_.size());
  for (std::size_t i = 0; i < asked_.size(); ++i) margins_[i] = asked_[i]->margins;
  scorer_.Load(poses_);
  scorer_.Obstacles(precision, &margins_);
  for (std::size_t i = 0; i < asked_.size(); ++i) {
    asked_[i]->margins = margins_[i];
    asked_[i]->sights_checked = true;
    asked_[i]->violation = ViolationOf(margins_[i], precision);
  }
}

double Judge::ReserveOf(BatchPrecision precision) const {
  return (precision == BatchPrecision::kSingle ? 1e-5 : 1e-12) * model_.unit();
}

double Judge::ViolationOf(PlanMargins margins, BatchPrecision precision) const {
  if (precision == BatchPrecision::kSingle) {
    for (double& margin : margins) margin -= 0.5 * ReserveOf(precision);
  }
  return model_.Keeps(margins) ? 0.0 : model_.Violation(margins);
}

void Judge::Block(Candidate* first, int count, BatchPrecision precision) {
  cameras_ += count;
  poses_.resize(count);
  for (int i = 0; i < count; ++i) {
    first[i].q_c = space_.ToRig(first[i].u);
    poses_[i] = RigPose(space_.rig(), first[i].q_c);
  }
  scorer_.Load(poses_);
  scorer_.Frustum(precision, &margins_);
  if (space_.can_step_back() && StepBack(first, count, precision)) scorer_.Load(poses_);
  scorer_.Scores(precision, &scores_);
  for (int i = 0; i < count; ++i) {
    Candidate& c = first[i];
    c.margins = margins_[i];
    c.score = scores_[i];
    c.merit = model_.Merit(c.score);
    c.violation = ViolationOf(c.margins, precision);
    c.sights_checked = false;
  }
}

bool Judge::StepBack(Candidate* first, int count, BatchPrecision precision) {
  const double reserve = ReserveOf(precision);
  bool any = false;
  bool exact = true;
  for (int i = 0; i < count; ++i) {
    const double back = TooNear(margins_[i]);
    first[i].back = std::max(0.0, back) / model_.unit();
    if (!(back > 0.0)) continue;
    const RigVector moved = space_.StepBack(first[i].q_c, back + reserve);
    if (space_.step_axis() >= 0 && model_.problem().limits.keep_out.empty() &&
        model_.offsets().size() == 1) {
      const double by = moved(space_.step_axis()) - first[i].q_c(space_.step_axis());
      margins_[i][IndexOf(PlanLimit::kNear)] += by;
      margins_[i][IndexOf(PlanLimit::kFar)] -= by;
      margins_[i][IndexOf(PlanLimit::kImage)] += by;
      poses_[i].translation() -= by * poses_[i].linear().col(2);
    } else {
      exact = false;
      poses_[i] = RigPose(space_.rig(), moved);
    }
    first[i].q_c = moved;
    any = true;
  }
  if (any && !exact) {
    scorer_.Load(poses_);
    scorer_.Frustum(precision, &margins_);
  }
  return any;
}

std::vector<Candidate> SpreadOut(const SearchSpace& space, int count, std::int64_t first) {
  std::vector<Candidate> candidates(count);
  for (int i = 0; i < count; ++i) candidates[i].u = space.Spread(first + i);
  return candidates;
}

std::vector<Candidate> Distinct(std::vector<Candidate>* candidates, const SearchSpace& space,
                                std::size_t most, double apart, Judge* judge,
                                BatchPrecision precision) {
  BestFirst by_worth(*candidates);
  std::vector<Candidate> kept;
  const auto is_new = [&](const Candidate& c) {
    return std::all_of(kept.begin(), kept.end(), [&](const Candidate& other) {
      return space.Distance(c.u, other.u) >= apart;
    });
  };
  // A few at a time, of those that a sight might spoil and that are not too near to what is kept.
  constexpr std::size_t kFew = 16;
  std::vector<Candidate*> asked;
  do {
    asked.clear();
    while (asked.size() < kFew && !by_worth.empty() && by_worth.violation() == 0.0) {
      Candidate& c = (*candidates)[by_worth.Take()];
      if (is_new(c)) asked.push_back(&c);
    }
    judge->Sights(asked, precision);
    for (const Candidate* c : asked) {
      if (kept.size() < most && c->violation == 0.0 && is_new(*c)) kept.push_back(*c);
    }
  } while (!asked.empty() && kept.size() < most);
  if (kept.size() < most) {
    std::vector<Candidate> rest;
    for (const Candidate& c : *candidates) {
      if (c.violation > 0.0) rest.push_back(c);
    }
    std::sort(rest.begin(), rest.end(), Better);
    for (const Candidate& c : rest) {
      if (kept.size() >= most) break;
      if (is_new(c)) kept.push_back(c);
    }
  }
  return kept;
}

PlacedCamera Place(const PlacementModel& model, const RigVector& q_c, CameraScorer* scorer) {
  PlacedCamera placed;
  placed.q_c = q_c;
  placed.X_WC = RigPose(model.problem().rig, q_c);
  scorer->Load({placed.X_WC});
  std::vector<PlanMargins> margins;
  std::vector<double> scores;
  scorer->Frustum(BatchPrecision::kDouble, &margins);
  scorer->Obstacles(BatchPrecision::kDouble, &margins);
  scorer->Scores(BatchPrecision::kDouble, &scores);
  placed.margins = margins[0];
  placed.value = model.Value(scores[0]);
  placed.feasible = model.Keeps(margins[0]);
  return placed;
}

}  // namespace vantage::plan
