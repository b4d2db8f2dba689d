#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "sim/render/scene.h"
#include "vantage/camera/camera_model.h"
#include "vantage/vision/image.h"

/// @file
/// Where a marker lies in an image: what the renderer's marker program needs.

namespace vantage::sim {

/// A marker, with its ring and the face of its plate, in one image.
struct MarkerQuad {
  int index{0};        ///< In Scene::markers.
  PixelWindow bounds;  ///< Holds every pixel it touches; may reach beyond the image.
  Eigen::Vector2d reference{Eigen::Vector2d::Zero()};  ///< Pixel (with distortion: ideal ray).
  /// From (pixel or ideal ray) - reference to the marker's plane, in units of the disc's radius,
  /// homogeneous. Relative to the reference so that single precision suffices.
  Eigen::Matrix3d to_plane{Eigen::Matrix3d::Identity()};
  Eigen::Vector3d inverse_depth{
      Eigen::Vector3d::Zero()};  ///< 1/Z of its plane = dot with (x, y, 1).
  double depth{0.0};             ///< Of its centre [m].
  double cos_incidence{0.0};     ///< Of the ray to it; > 0.
  double lift{0.0};              ///< It is drawn as if this much nearer [m].
};

/// nullopt when the marker turns its back to the camera or is not wholly in front of it.
/// @param radii  How much of its plane is to be in the bounds: a circle of so many of the disc's radii.
[[nodiscard]] std::optional<MarkerQuad> PlaceMarker(const CameraModel& camera,
                                                    const Eigen::Isometry3d& X_CF,
                                                    const Marker& marker, double radii);

/// How far towards the camera a marker at p_WM must be lifted to come out of the capsules that its
/// centre lies in or touches [m]; 0 when there are none.
[[nodiscard]] double MarkerLift(const std::vector<Capsule>& capsules, const SceneState& state,
                                const Eigen::Vector3d& p_WM, const Eigen::Vector3d& p_WC);

}  // namespace vantage::sim
