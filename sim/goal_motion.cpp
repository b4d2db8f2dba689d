#include "sim/goal_motion.h"

#include <cmath>

#include "vantage/math/angles.h"

namespace vantage::sim {

Eigen::Vector3d GoalShift(const GoalMotion& motion, double time) noexcept {
  const double phase = 2.0 * kPi * time / motion.period;
  return 0.5 * ((1.0 - std::cos(phase)) * motion.a + (1.0 - std::cos(2.0 * phase)) * motion.b);
}

double GreatestSpeed(const GoalMotion& motion) noexcept {
  return 2.0 * kPi / motion.period * (0.5 * motion.a.norm() + motion.b.norm());
}

}  // namespace vantage::sim
