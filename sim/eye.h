#pragma once

#include <vector>

#include <Eigen/Geometry>

#include "vantage/features/marker.h"
#include "vantage/math/sizes.h"
#include "vantage/vision/marker_detector.h"

namespace vantage::sim {

/// What finds the markers of one image: a detector on rendered pixels, or a projection model.
class Eye {
 public:
  virtual ~Eye() = default;

  /// Takes an image of the true state, and says of each prediction's marker where it is seen.
  ///
  /// @param q_true     Joints [rad or m].
  /// @param X_WG       Frame of the goal's markers: W, unless the goal moves.
  /// @param *features  Gets the markers, in the order of the predictions; stamps and pose are the
  ///   caller's.
  virtual void See(Time now, const Eigen::Isometry3d& X_WC_true, const JointVector& q_true,
                   const Eigen::Isometry3d& X_WG, const std::vector<MarkerPrediction>& predictions,
                   ImageFeatures* features) = 0;
};

}  // namespace vantage::sim
