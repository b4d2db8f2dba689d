#pragma once

#include <optional>

#include <Eigen/Core>

/// @file
/// Pinhole projection. C is the camera's optical frame: Cx right, Cy down, Cz forward.

namespace vantage {

/// Points nearer than this to the plane Cz = 0 are not projected [m].
inline constexpr double kMinDepth = 1e-3;

/// Image of a point P on the plane Cz = 1, with the depth that its derivatives need.
struct ImagePoint {
  Eigen::Vector2d n{Eigen::Vector2d::Zero()};  ///< Normalised coordinates (X/Z, Y/Z) [-].
  double depth{1.0};                           ///< Z of P in C [m]; at least kMinDepth.
};

/// Projects P into the image plane of C.
///
/// @param p_CP  Position of P in C [m].
/// @return nullopt when P is behind, or nearly in, the plane Cz = 0, or is not finite. To lose a
///   point is normal operation, so it is a value and not an exception.
/// Real-time safe.
[[nodiscard]] std::optional<ImagePoint> Project(const Eigen::Vector3d& p_CP) noexcept;

}  // namespace vantage
