#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "vantage/observability/measures.h"

/// @file
/// Feature selection (paper, section 8): of the rows of J_c that a camera could be steered by, the k that
/// show the arm's motion best, at one configuration or along a trajectory.

namespace vantage {

/// What makes a set of rows good; all grow with it.
enum class SelectionCriterion {
  kW,         ///< w_c (D-optimal): product of the s largest singular values.
  kSigmaMin,  ///< σ_s (E-optimal): what is seen of the motion seen worst.
  kTrace,  ///< 1 / Σ 1/σ_i² (A-optimal): inverse of the summed variance of the computed motion.
};

/// How the configurations of a trajectory count together.
enum class SelectionOver {
  kMean,   ///< Their mean, as in eqs. 13 to 15.
  kWorst,  ///< The least of them, as in eq. 16.
};

/// What makes a choice of features the best.
struct SelectionOptions {
  SelectionCriterion criterion{SelectionCriterion::kW};  ///< Measure of one configuration.
  SelectionOver over{SelectionOver::kMean};  ///< From that of each configuration to one number.
  int task_dimension{kTaskDimension};        ///< m: at most so many singular values count.
  /// Singular values are computed at most this many times for all sets to be tried; where that is not
  /// enough, greedy exchange takes its place.
  std::int64_t exhaustive_limit{200000};
  /// The same for the swaps of two rows that one step of the exchange tries; with more it does without.
  std::int64_t pair_limit{200000};
};

/// How a choice of features went.
enum class SelectionStatus : int {
  kOk = 0,
  kEmpty = 1,      ///< No candidate or no configuration.
  kBadCount = 2,   ///< k is less than 1 or more than the candidates.
  kUneven = 3,     ///< The configurations' matrices differ in size.
  kNotFinite = 4,  ///< An entry is NaN or infinite.
  kSingular = 5,   ///< Every k rows have the value 0: none is better than another.
};

/// As programs print it: "OK", "EMPTY", "BAD_COUNT", "UNEVEN", "NOT_FINITE", "SINGULAR".
[[nodiscard]] const char* Name(SelectionStatus status) noexcept;

/// The features chosen.
struct Selection {
  SelectionStatus status{SelectionStatus::kEmpty};  ///< kOk: the rows are the choice.
  std::vector<int> rows;     ///< Ascending. Empty where the status is not kOk.
  double value{0.0};         ///< The criterion for them.
  double value_of_all{0.0};  ///< The criterion for all candidates together.
  /// All sets were tried: none is better. False: the result of an exchange.
  bool exhaustive{false};
  std::int64_t sets{0};  ///< Sets of rows that were evaluated.
};

/// The criterion for some rows of the candidates.
/// @param rows  Of every matrix of J; each at most once.
/// @pre J is not empty, all of one size, and finite.
[[nodiscard]] double SelectionValue(const std::vector<TaskJacobian>& J,
                                    const std::vector<int>& rows,
                                    const SelectionOptions& options = {});

/// The best k rows. Of sets of equal value the one that comes first in the order of the alphabet.
///
/// Exchange: from the sets that forward selection and backward elimination give, the best swap of one row
/// against another as long as there is one (Fedorov's exchange), then of two; the better of both ends.
///
/// @param J  J_c of all m candidates, one matrix (m×n) for each configuration. A candidate that is not seen
///   at a configuration is a row of zeros there.
/// @see V. V. Fedorov, "Theory of Optimal Experiments", Academic Press 1972, ch. 3.
[[nodiscard]] Selection SelectFeatures(const std::vector<TaskJacobian>& J, int k,
                                       const SelectionOptions& options = {});

}  // namespace vantage
