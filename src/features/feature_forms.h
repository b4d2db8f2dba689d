#pragma once

#include <vector>

#include <Eigen/Core>

#include "jet.h"
#include "vantage/features/pixel_feature.h"

/// @file
/// Private to the module: features as functions of a few quantities of their points, which in turn are
/// polynomials of the pixels.

namespace vantage {

/// A feature of two points by (e, c): the edge e = p_j - p_i and the centre c = (p_i + p_j) / 2.
using PairJet = Jet<4>;

[[nodiscard]] bool IsPair(FeatureKind kind) noexcept;
[[nodiscard]] bool IsSegment(FeatureKind kind) noexcept;
[[nodiscard]] bool IsMoment(FeatureKind kind) noexcept;

/// @pre IsPair(kind), and e is not 0.
[[nodiscard]] PairJet PairForm(FeatureKind kind, const Eigen::Vector2d& e,
                               const Eigen::Vector2d& c) noexcept;

/// The quantities that moment features are made of: x_g, y_g, μ_20, μ_11, μ_02.
using MomentVector = Eigen::Matrix<double, 5, 1>;
using MomentJet = Jet<5>;

[[nodiscard]] MomentVector MomentsOf(const std::vector<int>& points,
                                     const PixelArray& pixels) noexcept;

/// True for the kinds that are made of a MomentVector; kMomentBasic and kMomentCentred are sums.
[[nodiscard]] bool IsMadeOfMoments(FeatureKind kind) noexcept;

/// @return kOk, kCoincident or kUndefined.
[[nodiscard]] RowStatus CheckMoments(FeatureKind kind, const MomentVector& moments, double focal,
                                     std::size_t count) noexcept;

/// @pre IsMadeOfMoments(feature.kind), and CheckMoments() gives kOk.
[[nodiscard]] MomentJet MomentForm(const Feature& feature, const MomentVector& moments) noexcept;

}  // namespace vantage
