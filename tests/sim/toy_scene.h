#pragma once

#include <memory>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "sim/render/arm_scene.h"
#include "sim/render/renderer.h"

/// @file
/// A scene for tests of rendering and detection: an arm of three links, its poses by hand.

namespace vantage::sim::test {

/// Camera at p_W that looks at a target, image up as near to world z as it goes.
inline Eigen::Isometry3d LookAt(const Eigen::Vector3d& p_W, const Eigen::Vector3d& target_W,
                                double roll = 0.0) {
  const Eigen::Vector3d forward = (target_W - p_W).normalized();
  Eigen::Vector3d right = forward.cross(Eigen::Vector3d::UnitZ());
  right = right.norm() > 1e-6 ? right.normalized() : Eigen::Vector3d::UnitX();
  Eigen::Isometry3d X_WC = Eigen::Isometry3d::Identity();
  X_WC.linear() << right, forward.cross(right), forward;
  X_WC.linear() = X_WC.linear() * Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitZ());
  X_WC.translation() = p_W;
  return X_WC;
}

/// Poses of the toy arm's links and tool at joint angles (pan, shoulder, elbow).
inline SceneState ToyState(double pan, double shoulder, double elbow) {
  using Eigen::AngleAxisd;
  using Eigen::Vector3d;
  SceneState state;
  state.X_WL[0] = Eigen::Isometry3d(AngleAxisd(pan, Vector3d::UnitZ()));
  state.X_WL[0].translation().z() = 0.35;
  state.X_WL[1] = state.X_WL[0] * AngleAxisd(shoulder, Vector3d::UnitY());
  state.X_WL[2] =
      state.X_WL[1] * Eigen::Translation3d(0.45, 0.0, 0.0) * AngleAxisd(elbow, Vector3d::UnitY());
  state.X_WE = state.X_WL[2] * Eigen::Translation3d(0.42, 0.0, 0.0);
  return state;
}

/// Four dots in a square on the tool, facing up or ahead, alternately dark and bright if so asked.
inline std::vector<Marker> ToolMarkers(double radius, double spread, const Eigen::Vector3d& normal,
                                       bool both_polarities) {
  std::vector<Marker> markers;
  const Eigen::Vector3d e1 = normal.unitOrthogonal();
  const Eigen::Vector3d e2 = normal.cross(e1);
  for (int i = 0; i < 4; ++i) {
    Marker marker;
    marker.id = i + 1;
    marker.p = 0.09 * normal + spread * ((i & 1) != 0 ? 1.0 : -1.0) * e1 +
               spread * ((i & 2) != 0 ? 1.0 : -1.0) * e2;
    marker.normal = normal;
    marker.radius = radius;
    marker.dark = !both_polarities || i % 2 == 0;
    markers.push_back(marker);
  }
  return markers;
}

inline Scene ToyScene(const std::vector<Marker>& tool_markers,
                      const std::vector<Marker>& world_markers) {
  using Eigen::Vector3d;
  const ArmLook look;
  Scene scene;
  const auto capsule = [&](int frame, const Vector3d& a, const Vector3d& b, double radius) {
    scene.bodies.push_back(
        {frame, CapsuleMesh(a, b, radius), frame < 0 ? look.base : look.link, 0.3F});
    scene.capsules.push_back({frame, a, b, radius});
  };
  const auto drum = [&](int frame, double radius) {
    scene.bodies.push_back({frame,
                            CylinderMesh({0.0, -1.2 * radius, 0.0}, {0.0, 1.2 * radius, 0.0},
                                         0.95 * radius, 0.12 * radius),
                            look.joint, 0.35F});
  };
  scene.bodies.push_back(
      {kWorldFrame, CylinderMesh({0, 0, 0}, {0, 0, 0.06}, 0.16, 0.012, 48), look.base, 0.2F});
  capsule(kWorldFrame, {0, 0, 0.05}, {0, 0, 0.26}, 0.075);
  capsule(0, {0, 0, -0.05}, {0, 0, 0}, 0.078);
  capsule(1, {0, 0, 0}, {0.45, 0, 0}, 0.06);
  capsule(2, {0, 0, 0}, {0.40, 0, 0}, 0.048);
  drum(1, 0.078);
  drum(2, 0.06);
  for (const auto& [frame, markers] :
       {std::pair{kToolFrame, tool_markers}, {kWorldFrame, world_markers}}) {
    for (const Marker& marker : markers) scene.markers.push_back({frame, marker, look.plate});
  }
  return scene;
}

inline CameraModel Camera(int width = 640, int height = 480, double focal = 600.0) {
  CameraModel camera;
  camera.fx = camera.fy = focal;
  camera.width = width;
  camera.height = height;
  camera.u0 = 0.5 * (width - 1);
  camera.v0 = 0.5 * (height - 1);
  return camera;
}

inline Renderer MakeRenderer(const CameraModel& camera, Scene scene,
                             GlBackend backend = GlBackend::kOsmesa) {
  return Renderer(MakeGlContext(backend), camera, std::move(scene));
}

}  // namespace vantage::sim::test
