#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "search_space.h"
#include "vantage/plan/placement.h"

/// @file
/// Cameras that a search tries, judged many at a time: what the search for a camera and the check against a grid
/// share.

namespace vantage::plan {

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A camera of a search.
struct Candidate {
  SearchVector u;               ///< As asked for.
  RigVector q_c;                ///< As judged: perhaps a step back from u [m or rad].
  double merit{-kInfinity};     ///< PlacementModel::Merit() of the score.
  double score{0.0};            ///< Of the scene.
  PlanMargins margins{};        ///< Of what was checked [m].
  double violation{kInfinity};  ///< Of what was checked, per unit.
  bool sights_checked{false};   ///< Occlusion and facing are among it.
  double back{0.0};             ///< The step back, per unit.
};

/// What keeps the limits is better than what does not; among the latter the least violation counts.
[[nodiscard]] bool Better(const Candidate& a, const Candidate& b);

/// Candidates best first, as Better() has it, for as long as they are asked for: of many only a few are looked at.
class BestFirst {
 public:
  explicit BestFirst(const std::vector<Candidate>& candidates);

  [[nodiscard]] bool empty() const noexcept { return heap_.empty(); }
  /// Of the next, as it was at first. @pre !empty().
  [[nodiscard]] double violation() const { return heap_.front().violation; }
  /// Index of the next. @pre !empty().
  std::size_t Take();

 private:
  struct Entry {  // a candidate is too large to be moved about
    double violation, merit;
    std::size_t index;
  };
  static bool Worse(const Entry& a, const Entry& b);
  std::vector<Entry> heap_;
};

/// Judges candidates in blocks: a step back to where the frustum is kept, score, and what else may break. Keeps
/// its storage; one thread at a time.
class Judge {
 public:
  /// Both must outlive it.
  Judge(const PlacementModel& model, const SearchSpace& space)
      : model_(model), space_(space), scorer_(model) {}

  /// Everything but sights; candidates hold u.
  void Frustum(Candidate* first, int count, BatchPrecision precision);

  /// Occlusion and facing, of those that keep the rest.
  void Sights(Candidate* first, int count, BatchPrecision precision = BatchPrecision::kDouble);
  /// The same of scattered ones.
  void Sights(const std::vector<Candidate*>& candidates, BatchPrecision precision);

  [[nodiscard]] CameraScorer& scorer() noexcept { return scorer_; }
  /// Cameras judged so far.
  [[nodiscard]] std::int64_t cameras() const noexcept { return cameras_; }

 private:
  // What single precision may be off by is not counted on.
  [[nodiscard]] double ReserveOf(BatchPrecision precision) const;
  [[nodiscard]] double ViolationOf(PlanMargins margins, BatchPrecision precision) const;
  void Block(Candidate* first, int count, BatchPrecision precision);
  // Moves cameras that are too near back along their axes, by what the margins say. True if any moved.
  bool StepBack(Candidate* first, int count, BatchPrecision precision);

  const PlacementModel& model_;
  const SearchSpace& space_;
  CameraScorer scorer_;
  std::vector<Candidate*> asked_;
  std::vector<Eigen::Isometry3d> poses_;
  std::vector<PlanMargins> margins_;
  std::vector<double> scores_;
  std::int64_t cameras_{0};
};

/// Points first, first + 1, ... of the space's even sequence, to be judged.
[[nodiscard]] std::vector<Candidate> SpreadOut(const SearchSpace& space, int count,
                                               std::int64_t first);

/// Distinct candidates that keep all limits, best first; where there are too few, the least violations.
/// @param candidates  Get their sights checked where they are looked at.
/// @param apart  Least distance between any two of them (SearchSpace::Distance).
[[nodiscard]] std::vector<Candidate> Distinct(std::vector<Candidate>* candidates,
                                              const SearchSpace& space, std::size_t most,
                                              double apart, Judge* judge,
                                              BatchPrecision precision = BatchPrecision::kDouble);

/// The camera at q_c, in double precision.
[[nodiscard]] PlacedCamera Place(const PlacementModel& model, const RigVector& q_c,
                                 CameraScorer* scorer);

}  // namespace vantage::plan
