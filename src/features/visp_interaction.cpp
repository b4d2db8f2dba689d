#include "visp_interaction.h"

#include <visp3/visual_features/vpFeaturePoint.h>

namespace vantage {

Eigen::Matrix<double, 2, 6> VispPointInteraction(const ImagePoint& point) {
  // Kept by the thread: making a vpFeaturePoint allocates too.
  thread_local vpFeaturePoint feature;
  feature.set_xyZ(point.n.x(), point.n.y(), point.depth);
  const vpMatrix L = feature.interaction();
  return Eigen::Map<const Eigen::Matrix<double, 2, 6, Eigen::RowMajor>>(L.data);
}

}  // namespace vantage
