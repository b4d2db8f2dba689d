#pragma once

#include <Eigen/Core>

#include "vantage/math/sizes.h"

/// @file
/// Measures of motion: manipulability w_r, observability w_v and the composite w_c (paper, eqs. 5, 17,
/// 20, in the form of docs/paper.md): the product of the s largest singular values, s = min of the
/// dimensions that bound the rank. Everything here needs Eigen alone.

namespace vantage {

/// Why w_c is low.
enum class LowCause : int {
  kNone = 0,      ///< It is not.
  kView = 1,      ///< w_v or the coupling of view and arm: a camera move can help.
  kArm = 2,       ///< w_r ~ 0: no camera move can help.
  kFeatures = 3,  ///< Fewer feature rows than joints or task dimensions to be seen.
};

/// Singular values of one Jacobian and what follows from them.
struct Measure {
  /// σ_1 >= ... >= σ_s, s = rows that count (see Measures). Storage inside the object.
  Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kMaxRows, 1> sigma;
  double w{0.0};           ///< Product of sigma. 0 for s = 0.
  double log_w{0.0};       ///< Sum of log sigma; -inf when one is 0.
  double sigma_min{0.0};   ///< σ_s.
  double condition{0.0};   ///< σ_1 / σ_s; inf when σ_s is 0.
  int rank{0};             ///< Count of σ_i > tolerance · σ_1.

  /// w^(1/s): the geometric mean singular value; one threshold carries over arms with it.
  [[nodiscard]] double geometric_mean() const noexcept;
};

/// Relative tolerance of ranks: σ_i counts when σ_i > kRankTolerance * σ_1.
inline constexpr double kRankTolerance = 1e-9;

}  // namespace vantage
