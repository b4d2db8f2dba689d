#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "vantage/robot/arm_visual.h"

/// @file
/// Capsules round bodies.

namespace vantage {

/// Triangles of a body; they need not close.
struct TriangleSurface {
  std::vector<Eigen::Vector3d> points;                  ///< [m].
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< Indices of points.
};

/// [m³].
[[nodiscard]] double Volume(const CapsuleShape& capsule) noexcept;

/// True when the whole of `inner` lies in `outer`, to `tolerance` [m].
[[nodiscard]] bool Contains(const CapsuleShape& outer, const CapsuleShape& inner,
                            double tolerance = 1e-9) noexcept;

/// The smallest capsule, by volume, that holds every point; a local search from several axes finds
/// it. No thinner than 0.1 mm.
/// @pre points is not empty; all are finite.
[[nodiscard]] CapsuleShape FitCapsule(const std::vector<Eigen::Vector3d>& points);

/// The smallest capsule round a cylinder about z, centred at the origin.
/// @pre radius > 0, length >= 0 [m].
[[nodiscard]] CapsuleShape FitCapsuleToCylinder(double radius, double length);

/// Up to max_count capsules that hold a surface between them: every point of every triangle lies in
/// one. The surface is cut by planes, at each cut where the total volume falls most, as long as it
/// falls below `gain` times the volume of the part that is cut.
/// @pre the surface has a triangle; max_count >= 1; gain in (0, 1).
[[nodiscard]] std::vector<CapsuleShape> FitCapsules(const TriangleSurface& surface, int max_count,
                                                    double gain = 0.85);

}  // namespace vantage
