#include "vantage/observability/selection.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace vantage {
namespace {

using Rows = std::vector<int>;

// Values that differ by less (relative) are equal: rounding must not decide between sets.
constexpr double kTie = 1e-12;

bool IsBetter(double value, double than) noexcept {
  return value > than + kTie * std::abs(than);
}

SelectionStatus Check(const std::vector<TaskJacobian>& J, int k) noexcept {
  if (J.empty() || J.front().size() == 0) return SelectionStatus::kEmpty;
  for (const TaskJacobian& at : J) {
    if (at.rows() != J.front().rows() || at.cols() != J.front().cols()) {
      return SelectionStatus::kUneven;
    }
    if (!at.allFinite()) return SelectionStatus::kNotFinite;
  }
  return k < 1 || k > J.front().rows() ? SelectionStatus::kBadCount : SelectionStatus::kOk;
}

// The candidates, and how many sets of them were looked at.
class Candidates {
 public:
  Candidates(const std::vector<TaskJacobian>& J, const SelectionOptions& options)
      : J_(J), options_(options) {}

  [[nodiscard]] int size() const noexcept { return static_cast<int>(J_.front().rows()); }
  [[nodiscard]] std::int64_t sets() const noexcept { return sets_; }
  [[nodiscard]] bool MayTryPairs(std::int64_t k) const noexcept {
    const std::int64_t others = size() - k;
    const std::int64_t pairs = (k * (k - 1) / 2) * (others * (others - 1) / 2);
    return pairs * static_cast<std::int64_t>(J_.size()) <= options_.pair_limit;
  }

  [[nodiscard]] double Value(const Rows& rows) {
    ++sets_;
    return SelectionValue(J_, rows, options_);
  }

 private:
  const std::vector<TaskJacobian>& J_;
  const SelectionOptions& options_;
  std::int64_t sets_{0};
};

struct Scored {
  Rows rows;
  double value{-1.0};
};

// Number of sets of k out of m, or more than `limit`.
std::int64_t CountSets(int m, int k, std::int64_t limit) noexcept {
  std::int64_t count = 1;
  for (int i = 1; i <= std::min(k, m - k); ++i) {
    count = count * (m - i + 1) / i;
    if (count > limit) return count;
  }
  return count;
}

Scored TryAll(Candidates* candidates, int k) {
  const int m = candidates->size();
  Rows rows(k);
  std::iota(rows.begin(), rows.end(), 0);
  Scored best;
  while (true) {
    const double value = candidates->Value(rows);
    if (IsBetter(value, best.value)) best = {rows, value};
    int i = k - 1;
    while (i >= 0 && rows[i] == m - k + i) --i;
    if (i < 0) return best;
    ++rows[i];
    for (int j = i + 1; j < k; ++j) rows[j] = rows[j - 1] + 1;
  }
}

Rows Others(const Rows& rows, int m) {
  Rows others;
  for (int i = 0; i < m; ++i) {
    if (!std::binary_search(rows.begin(), rows.end(), i)) others.push_back(i);
  }
  return others;
}

Rows With(Rows rows, int row) {
  rows.insert(std::lower_bound(rows.begin(), rows.end(), row), row);
  return rows;
}

Rows Without(Rows rows, int row) {
  rows.erase(std::lower_bound(rows.begin(), rows.end(), row));
  return rows;
}

// One row more (or fewer), as good as can be.
template <typename Change>
Scored BestChange(Candidates* candidates, const Rows& choices, Change&& change) {
  Scored best;
  for (const int row : choices) {
    Rows changed = change(row);
    const double value = candidates->Value(changed);
    if (IsBetter(value, best.value)) best = {std::move(changed), value};
  }
  return best;
}

Scored Forward(Candidates* candidates, int k) {
  Scored set;
  while (static_cast<int>(set.rows.size()) < k) {
    set = BestChange(candidates, Others(set.rows, candidates->size()),
                     [&](int row) { return With(set.rows, row); });
  }
  return set;
}

Scored Backward(Candidates* candidates, int k) {
  Scored set;
  set.rows.resize(candidates->size());
  std::iota(set.rows.begin(), set.rows.end(), 0);
  set.value = candidates->Value(set.rows);
  while (static_cast<int>(set.rows.size()) > k) {
    set = BestChange(candidates, set.rows, [&](int row) { return Without(set.rows, row); });
  }
  return set;
}

// The best set that is one swap away, or the set itself.
Scored SwapOne(Candidates* candidates, const Scored& from) {
  Scored best = from;
  const Rows others = Others(from.rows, candidates->size());
  for (const int out : from.rows) {
    const Rows rest = Without(from.rows, out);
    const Scored swapped = BestChange(candidates, others, [&](int in) { return With(rest, in); });
    if (IsBetter(swapped.value, best.value)) best = swapped;
  }
  return best;
}

// The first set found better by a swap of two rows, or the set itself.
Scored SwapTwo(Candidates* candidates, const Scored& from) {
  const Rows others = Others(from.rows, candidates->size());
  for (std::size_t a = 0; a < from.rows.size(); ++a) {
    for (std::size_t b = a + 1; b < from.rows.size(); ++b) {
      const Rows rest = Without(Without(from.rows, from.rows[a]), from.rows[b]);
      for (std::size_t c = 0; c < others.size(); ++c) {
        for (std::size_t d = c + 1; d < others.size(); ++d) {
          Rows changed = With(With(rest, others[c]), others[d]);
          const double value = candidates->Value(changed);
          if (IsBetter(value, from.value)) return {std::move(changed), value};
        }
      }
    }
  }
  return from;
}

Scored Exchange(Candidates* candidates, Scored set) {
  const bool pairs = candidates->MayTryPairs(static_cast<std::int64_t>(set.rows.size()));
  while (true) {
    Scored next = SwapOne(candidates, set);
    if (pairs && !IsBetter(next.value, set.value)) next = SwapTwo(candidates, set);
    if (!IsBetter(next.value, set.value)) return set;
    set = std::move(next);
  }
}

Scored ExchangeFromBothEnds(Candidates* candidates, int k) {
  const Scored forward = Exchange(candidates, Forward(candidates, k));
  const Scored backward = Exchange(candidates, Backward(candidates, k));
  return IsBetter(backward.value, forward.value) ? backward : forward;
}

}  // namespace

const char* Name(SelectionStatus status) noexcept {
  switch (status) {
    case SelectionStatus::kOk:
      return "OK";
    case SelectionStatus::kEmpty:
      return "EMPTY";
    case SelectionStatus::kBadCount:
      return "BAD_COUNT";
    case SelectionStatus::kUneven:
      return "UNEVEN";
    case SelectionStatus::kNotFinite:
      return "NOT_FINITE";
    case SelectionStatus::kSingular:
      return "SINGULAR";
  }
  return "?";
}

double SelectionValue(const std::vector<TaskJacobian>& J, const std::vector<int>& rows,
                      const SelectionOptions& options) {
  double sum = 0.0;
  double least = std::numeric_limits<double>::infinity();
  TaskJacobian chosen(static_cast<Eigen::Index>(rows.size()), J.front().cols());
  for (const TaskJacobian& at : J) {
    for (Eigen::Index i = 0; i < chosen.rows(); ++i) chosen.row(i) = at.row(rows[i]);
    const Measure measure = MeasureOf(chosen, options.task_dimension);
    double value = 0.0;
    switch (options.criterion) {
      case SelectionCriterion::kW:
        value = measure.w;
        break;
      case SelectionCriterion::kSigmaMin:
        value = measure.sigma_min;
        break;
      case SelectionCriterion::kTrace:
        value = measure.size() == 0 ? 0.0 : 1.0 / measure.inverse_trace();
        break;
    }
    // What rounding leaves of a singular value that is 0 is no reason to prefer one set to another.
    if (measure.rank < measure.size()) value = 0.0;
    sum += value;
    least = std::min(least, value);
  }
  return options.over == SelectionOver::kMean ? sum / static_cast<double>(J.size()) : least;
}

Selection SelectFeatures(const std::vector<TaskJacobian>& J, int k,
                         const SelectionOptions& options) {
  Selection selection;
  selection.status = Check(J, k);
  if (selection.status != SelectionStatus::kOk) return selection;

  Candidates candidates(J, options);
  Rows all(candidates.size());
  std::iota(all.begin(), all.end(), 0);
  selection.value_of_all = SelectionValue(J, all, options);
  const std::int64_t most = options.exhaustive_limit / static_cast<std::int64_t>(J.size());
  selection.exhaustive = CountSets(candidates.size(), k, most) <= most;
  Scored best =
      selection.exhaustive ? TryAll(&candidates, k) : ExchangeFromBothEnds(&candidates, k);
  selection.sets = candidates.sets();
  if (!(best.value > 0.0)) {
    selection.status = SelectionStatus::kSingular;
    return selection;
  }
  selection.rows = std::move(best.rows);
  selection.value = best.value;
  return selection;
}

}  // namespace vantage
