#include "vantage/camera/pinhole.h"

namespace vantage {

std::optional<ImagePoint> Project(const Eigen::Vector3d& p_CP) noexcept {
  if (!p_CP.allFinite() || p_CP.z() < kMinDepth) return std::nullopt;
  return ImagePoint{p_CP.head<2>() / p_CP.z(), p_CP.z()};
}

}  // namespace vantage
