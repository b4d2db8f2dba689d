#pragma once

#include <Eigen/Geometry>

#include "vantage/math/time.h"

namespace vantage {

/// Where a camera is, as its rig measured it, or should be.
struct CameraPose {
  Time stamp{};                                           ///< When it was measured.
  Eigen::Isometry3d X_WC{Eigen::Isometry3d::Identity()};  ///< Camera optical frame in the world.
};

}  // namespace vantage
