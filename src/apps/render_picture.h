#pragma once

#include <opencv2/core.hpp>

#include "sim/render/renderer.h"

namespace vantage {

/// A picture for people as OpenCV wants it: blue, green, red.
[[nodiscard]] cv::Mat RenderPicture(sim::Renderer* renderer, const Eigen::Isometry3d& X_WC,
                                    const sim::SceneState& state);

}  // namespace vantage
