#pragma once

#include <Eigen/Core>

#include "vantage/camera/pinhole.h"

namespace vantage {

/// Interaction matrix of an image point from ViSP's vpFeaturePoint (2×6, normalised units).
///
/// @pre point.depth >= kMinDepth and every value is finite: ViSP throws and prints otherwise.
/// ViSP allocates 10 times a call; the first call of a thread makes the feature it keeps (3 more).
[[nodiscard]] Eigen::Matrix<double, 2, 6> VispPointInteraction(const ImagePoint& point);

}  // namespace vantage
