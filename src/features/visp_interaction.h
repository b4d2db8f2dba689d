#pragma once

#include <vector>

#include <Eigen/Core>

#include "vantage/camera/pinhole.h"

namespace vantage {

/// Interaction matrix of an image point from ViSP's vpFeaturePoint (2×6, normalised units).
///
/// @pre point.depth >= kMinDepth and every value is finite: ViSP throws and prints otherwise.
/// ViSP allocates 10 times a call; the first call of a thread makes the feature it keeps (3 more).
[[nodiscard]] Eigen::Matrix<double, 2, 6> VispPointInteraction(const ImagePoint& point);

/// Interaction matrix of (x_c, y_c, l, alpha) of the segment from i to j, from ViSP's vpFeatureSegment
/// (normalised units).
/// @pre As VispPointInteraction(), and the points do not coincide.
[[nodiscard]] Eigen::Matrix<double, 4, 6> VispSegmentInteraction(const ImagePoint& i,
                                                                 const ImagePoint& j);

/// The plane of points in the image: A x + B y + C = 1/Z.
struct ImagePlane {
  double A, B, C;
};

/// Interaction matrices of the moments of a set of points, p + q <= kMaxMomentOrder (normalised units).
inline constexpr int kMaxMomentOrder = 3;
struct MomentInteraction {
  using Row = Eigen::Matrix<double, 1, 6>;
  Eigen::Matrix<double, 2, 6> centre;                     ///< (x_g, y_g).
  Row basic[kMaxMomentOrder + 1][kMaxMomentOrder + 1];    ///< [p][q]: m_pq, p + q >= 1.
  Row centred[kMaxMomentOrder + 1][kMaxMomentOrder + 1];  ///< [p][q]: μ_pq, p + q >= 2.
};

/// From ViSP's vpFeatureMomentGravityCenter, vpFeatureMomentBasic and vpFeatureMomentCentered.
/// @pre points is not empty, all lie in the plane, and every value is finite.
[[nodiscard]] MomentInteraction VispMomentInteraction(const std::vector<Eigen::Vector2d>& points,
                                                      const ImagePlane& plane);

}  // namespace vantage
