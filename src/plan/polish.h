#pragma once

#include "search_space.h"
#include "vantage/plan/placement_model.h"

namespace vantage::plan {

/// The local optimum near q_c to rounding, by sequential quadratic programming over the limits that are
/// near. Never worse than q_c where that keeps all limits.
///
/// @param scorer  Counts the evaluations.
/// @see D. Kraft, "A software package for sequential quadratic programming", DFVLR-FB 88-28, 1988
///   (NLopt's SLSQP).
[[nodiscard]] RigVector Polish(const PlacementModel& model, const SearchSpace& space,
                               const RigVector& q_c, CameraScorer* scorer);

}  // namespace vantage::plan
