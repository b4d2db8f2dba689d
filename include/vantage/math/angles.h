#pragma once

/// @file
/// Pi and the degree. Angles are in radians everywhere but in files and on the screen.

namespace vantage {

/// Half a turn [rad].
inline constexpr double kPi = 3.14159265358979323846;
/// One degree [rad]: `30.0 * kDegree`.
inline constexpr double kDegree = kPi / 180.0;
/// One radian in degrees; to print angles, and to write them to files.
inline constexpr double kDegreesPerRadian = 180.0 / kPi;

}  // namespace vantage
