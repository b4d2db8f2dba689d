#pragma once

#include <Eigen/Core>

#include "vantage/config/sim_options.h"

namespace vantage::sim {

/// By how much the goal has moved `time` seconds after the start, in world axes [m].
[[nodiscard]] Eigen::Vector3d GoalShift(const GoalMotion& motion, double time) noexcept;

/// A bound of its speed [m/s].
[[nodiscard]] double GreatestSpeed(const GoalMotion& motion) noexcept;

}  // namespace vantage::sim
