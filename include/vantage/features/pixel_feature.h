#pragma once

#include <array>

#include <Eigen/Core>

#include "vantage/features/feature_set.h"
#include "vantage/math/sizes.h"

/// @file
/// Closed forms of the features over pixels: for code that evaluates many views, or needs second
/// derivatives. FeatureSet takes interaction matrices from ViSP; tests hold the two equal.

namespace vantage {

/// Pixels of a point list, from the principal point [px], by the point's index.
using PixelArray = std::array<Eigen::Vector2d, kMaxPoints>;

/// Value of a feature and its derivative by the pixels it is made of.
struct PixelRow {
  double value{0.0};  ///< Less the principal point's share: see PrincipalPointShare().
  /// gradient[i]: by the pixel of the i-th of feature.points. Entries past their number are not set.
  std::array<Eigen::Vector2d, kMaxPoints> gradient;
};

/// Evaluates one feature.
///
/// @param pixels  Entries that the feature does not name are not read.
/// @param focal   Focal length [px]: points nearer than a billionth of it coincide.
/// @return kOk, kCoincident or kUndefined; *row is not to be used in the last two.
/// Real-time safe.
[[nodiscard]] RowStatus EvaluatePixels(const Feature& feature, const PixelArray& pixels,
                                       double focal, PixelRow* row) noexcept;

/// Second derivative of a feature by all pixels (u_0, v_0, u_1, v_1, ...) of its point list: 2P×2P,
/// symmetric; 0×0 when it is linear in them.
/// @pre EvaluatePixels() gives kOk.
[[nodiscard]] Eigen::MatrixXd PixelHessian(const Feature& feature, const PixelArray& pixels,
                                           int num_points);

/// What the principal point adds to the value: u0 or v0 for coordinates, 0 for the rest. Real-time safe.
[[nodiscard]] double PrincipalPointShare(const Feature& feature,
                                         const CameraModel& camera) noexcept;

}  // namespace vantage
