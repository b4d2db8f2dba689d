#pragma once

#include "vantage/math/sizes.h"

namespace vantage {

/// Outcome of MinimiseInBox().
struct BoxSolution {
  JointVector x;        ///< Within the box, exactly.
  int active{0};        ///< Components at a bound.
  bool optimal{false};  ///< The Karush-Kuhn-Tucker conditions hold; false: iteration limit reached.
};

/// Minimiser of ½ xᵀ H x - gᵀ x within lower <= x <= upper, by an active set that starts from
/// `start` clamped to the box.
///
/// @param H  n×n, symmetric positive definite.
/// @pre lower <= upper, all finite.
/// Real-time safe: at most 3n + 10 factorisations of at most n×n.
/// @see P. B. Stark, R. L. Parker, "Bounded-variable least-squares", Computational Statistics 10,
///   1995.
[[nodiscard]] BoxSolution MinimiseInBox(const JointMatrix& H, const JointVector& g,
                                        const JointVector& lower, const JointVector& upper,
                                        const JointVector& start) noexcept;

}  // namespace vantage
