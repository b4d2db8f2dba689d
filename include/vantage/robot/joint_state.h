#pragma once

#include "vantage/math/sizes.h"
#include "vantage/math/time.h"

namespace vantage {

/// Measured state of an arm.
struct JointState {
  Time stamp{};      ///< When the encoders were read.
  JointVector q;     ///< Positions [rad or m].
  JointVector qdot;  ///< Velocities [rad/s or m/s].
};

/// Command to an arm that takes velocities; `q` is the integral of what was commanded, for arms that
/// take positions.
struct JointCommand {
  Time stamp{};      ///< When the command was computed.
  JointVector qdot;  ///< Velocities [rad/s or m/s].
  JointVector q;     ///< Positions [rad or m].
};

}  // namespace vantage
