#pragma once

#include <vector>

#include <Eigen/Core>

#include "vantage/active/rig_motion.h"
#include "vantage/camera/camera_rig.h"

/// @file
/// Where a rig could put its camera, and the ways there.

namespace vantage {

/// Camera positions spread evenly over the rig's workspace: a Fibonacci sphere with varied radius,
/// points along a rail, a low-discrepancy set in a box, a ball round the aim as far as an arm reaches it.
/// Heads aim at aim_W; roll is that of q_c. The first one is q_c itself with its head aimed. Locked axes keep
/// the value of q_c.
[[nodiscard]] std::vector<RigVector> CandidatePositions(const CameraRig& rig, const RigVector& q_c,
                                                        const Eigen::Vector3d& aim_W, int count);

/// Coordinates close to q_c: one step along each free axis, both ways. `scale` 1 is a tenth of a
/// workspace [m or rad].
[[nodiscard]] std::vector<RigVector> Neighbours(const CameraRig& rig, const RigVector& q_c,
                                                const Eigen::Vector3d& aim_W, double scale);

/// Rolls worth a try besides the one of q_c: by eighths of a turn, the nearest of those that differ
/// by half turns, within the limits. Empty where the rig cannot roll.
[[nodiscard]] std::vector<double> OtherRolls(const CameraRig& rig, const RigVector& q_c);

/// Ways from one view to another: direct, and bent over the top, under, wide, and the long way round
/// where the rig has them. Inside the limits; heads keep aiming at aim_W.
[[nodiscard]] std::vector<RigPath> PathsBetween(const CameraRig& rig, const RigVector& from,
                                                const RigVector& to, const Eigen::Vector3d& aim_W);

/// True when some axis of the rig can move.
[[nodiscard]] bool CanMove(const CameraRig& rig) noexcept;

}  // namespace vantage
