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

}  // namespace

Eigen::Isometry3d FramePose(const SceneState& state, int frame) noexcept {
  if (frame == kWorldFrame) return Eigen::Isometry3d::Identity();
  if (frame == kToolFrame) return state.X_WE;
  if (frame == kGoalFrame) return state.X_WG;
  assert(frame >= 0 && frame < kMaxJoints);
  return state.X_WL[frame];
}

TriangleMesh MarkerPlate(const Marker& marker) {
  const double r = marker.radius;
  TriangleMesh plate;
  // Its face lies a little behind the marker.
  Append(&plate,
         CylinderMesh({0.0, 0.0, -0.6 * r}, {0.0, 0.0, -0.02 * r}, kPlateRadii * r, 0.1 * r, 28),
         MarkerFrame(marker));
  return plate;
}

}  // namespace vantage::sim
