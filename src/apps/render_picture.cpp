#include "render_picture.h"

#include <opencv2/imgproc.hpp>

namespace vantage {

cv::Mat RenderPicture(sim::Renderer* renderer, const Eigen::Isometry3d& X_WC,
                      const sim::SceneState& state) {
  ColourImage image;
  renderer->RenderColour(X_WC, state, &image);
  const cv::Mat rgb(image.height, image.width, CV_8UC3, image.pixels.data());
  cv::Mat bgr;
  cv::cvtColor(rgb, bgr, cv::COLOR_RGB2BGR);
  return bgr;
}

}  // namespace vantage
