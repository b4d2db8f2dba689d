#include "sim/render/scene.h"

#include <cassert>

namespace vantage::sim {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

Isometry3d MarkerFrame(const Marker& marker) {
  Isometry3d X = Isometry3d::Identity();
  X.linear() =
      Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), marker.normal).toRotationMatrix();
  X.translation() = marker.p;
  return X;
}

// Height of the face and width of the bevel in the marker's radii.
TriangleMesh Plate(const Marker& marker, double height, double bevel, int sides) {
  const double r = marker.radius;
  TriangleMesh plate;
  Append(
      &plate,
      CylinderMesh({0.0, 0.0, -0.6 * r}, {0.0, 0.0, height * r}, kPlateRadii * r, bevel * r, sides),
      MarkerFrame(marker));
  return plate;
}

}  // namespace

Eigen::Isometry3d FramePose(const SceneState& state, int frame) noexcept {
  if (frame == kWorldFrame) return Eigen::Isometry3d::Identity();
  if (frame == kToolFrame) return state.X_WE;
  if (frame == kGoalFrame) return state.X_WG;
  assert(frame >= 0 && frame < kMaxJoints);
  return state.X_WL[frame];
}

TriangleMesh MarkerPlate(const Marker& marker) {
  return Plate(marker, -0.02, 0.1, 28);
}

TriangleMesh PlainMarkerPlate(const Marker& marker) {
  return Plate(marker, 0.0, 0.0, kPlainPlateSides);
}

}  // namespace vantage::sim
