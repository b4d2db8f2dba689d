#pragma once

/// @file
/// Most of what one servo can hold. Storage of the control period has these sizes.

namespace vantage {

inline constexpr int kMaxJoints = 16;            ///< Most joints of one arm.
inline constexpr int kMaxPoints = 16;            ///< Most image points one servo can use.
inline constexpr int kMaxRows = 2 * kMaxPoints;  ///< Most feature rows k.
inline constexpr int kMaxRigAxes = 16;           ///< Most coordinates of a camera rig.

}  // namespace vantage
