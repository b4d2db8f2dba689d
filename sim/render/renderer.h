#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include <Eigen/Geometry>

#include "sim/render/gl_context.h"
#include "sim/render/scene.h"
#include "vantage/camera/camera_model.h"
#include "vantage/vision/image.h"

namespace vantage::sim {

/// Values of an IdImage.
inline constexpr std::uint16_t kIdBackground = 0;
inline constexpr std::uint16_t kIdFloor = 1;
/// + index in Scene::bodies; the plates of Scene::markers come after them, in their order.
inline constexpr std::uint16_t kIdBody = 100;
inline constexpr std::uint16_t kIdDisc = 10000;  ///< + index in Scene::markers: its disc.
inline constexpr std::uint16_t kIdRing = 20000;  ///< + index in Scene::markers: its ring.

/// Draws a scene through one camera model, from any pose, off screen.
///
/// The grey image is what the simulated camera delivers. The edges of marker discs and of their rings carry their exact
/// coverage of each pixel; all other edges are sharp, for speed. The same call gives the same pixels.
///
/// Not thread-safe: one thread at a time. Several renderers may live in one process.
class Renderer {
 public:
  /// Compiles the programs and draws grey images once, so that later calls take a steady time.
  /// Throws RenderError, and ConfigError when the scene or the camera is out of bounds (more than
  /// kMaxMarkers markers, a body fixed to no frame, image larger than the GL allows, ...).
  Renderer(std::unique_ptr<GlContext> context, const CameraModel& camera, Scene scene);
  ~Renderer();
  Renderer(Renderer&&) noexcept;
  Renderer& operator=(Renderer&&) noexcept;

  [[nodiscard]] const CameraModel& camera() const noexcept;

  /// The whole image. `*image` takes the camera's size.
  void RenderGrey(const Eigen::Isometry3d& X_WC, const SceneState& state, GreyImage* image);

  /// The image inside some windows, where it is the whole image's to the bit. What is outside of them
  /// keeps its old value in part, and is not to be used. Windows are clipped to the image.
  void RenderGrey(const Eigen::Isometry3d& X_WC, const SceneState& state,
                  const std::vector<PixelWindow>& windows, GreyImage* image);

  /// For people: per-pixel light, shadows on the floor, smooth edges.
  void RenderColour(const Eigen::Isometry3d& X_WC, const SceneState& state, ColourImage* image);

  /// What each pixel centre shows and how deep it lies; infinite depth for the background. A marker
  /// takes the depth of its plane.
  void RenderIds(const Eigen::Isometry3d& X_WC, const SceneState& state, IdImage* ids,
                 DepthImage* depth = nullptr);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace vantage::sim
