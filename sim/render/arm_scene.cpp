#include "sim/render/arm_scene.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "sim/render/visual_bodies.h"
#include "vantage/robot/kinematics.h"

namespace vantage::sim {
namespace {

using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Vector3d;

// A joint's axis in the world, with the radius of the arm where it crosses it.
struct JointAxis {
  Vector3d p_W;  // The point of the axis nearest to the arm's body.
  Vector3d direction_W;
  double radius;
};

// Link i at q and with joint i moved alone differ by a motion about, or along, that joint's axis.
Isometry3d MotionOfJoint(const ArmModel& arm, const JointVector& q, int joint, double step) {
  JointVector moved = q;
  moved[joint] += step;
  const Isometry3d X_WL = ComputeLinkPoses(arm, q)[joint];
  return ComputeLinkPoses(arm, moved)[joint] * X_WL.inverse();
}

std::optional<JointAxis> FindAxis(const ArmModel& arm, const JointVector& q, int joint,
                                  const std::vector<PlacedCapsule>& capsules) {
  constexpr double kStep = 1.0;  // [rad]; well away from 0 and π.
  const Isometry3d motion = MotionOfJoint(arm, q, joint, kStep);
  const AngleAxisd turn(motion.linear());
  const Vector3d d = turn.axis();
  // Points of the axis stay where they are: (I - R) p = t, of which the part along d is free.
  const Vector3d p = (Eigen::Matrix3d::Identity() - motion.linear() + d * d.transpose())
                         .colPivHouseholderQr()
                         .solve(motion.translation());
  std::optional<JointAxis> axis;
  double best = std::numeric_limits<double>::infinity();
  for (const PlacedCapsule& capsule : capsules) {
    if (capsule.link != joint && capsule.link != joint - 1) continue;
    // Ends are where joints sit: prefer the end of a capsule that the axis passes nearest to.
    for (const Vector3d& end : {capsule.p_WA, capsule.p_WB}) {
      const Vector3d nearest = p + d * d.dot(end - p);
      const double distance = (nearest - end).norm();
      if (distance > 1.2 * capsule.radius || distance >= best - 1e-9) continue;
      best = distance;
      axis = JointAxis{nearest, d, capsule.radius};
    }
  }
  return axis;
}

// Struts from the end effector's origin to its markers' plates, where they are not on the arm itself.
void AddStruts(const std::vector<Marker>& markers, const ArmLook& look, Scene* scene) {
  TriangleMesh mesh;
  for (const Marker& marker : markers) {
    const double thickness = 0.3 * marker.radius;
    const Vector3d foot = marker.p - 1.5 * thickness * marker.normal;
    if (foot.norm() < 3.0 * marker.radius) continue;
    Append(&mesh, CapsuleMesh(Vector3d::Zero(), foot, thickness, 10));
  }
  if (mesh.triangles() > 0) scene->bodies.push_back({kToolFrame, mesh, look.joint, 0.15F});
}

}  // namespace

std::vector<Body> MakeArmBodies(const ArmModel& arm, const ArmLook& look,
                                std::vector<std::string>* warnings) {
  const JointVector q = JointVector::Zero(arm.size());
  const LinkPoses X_WL = ComputeLinkPoses(arm, q);
  std::vector<PlacedCapsule> capsules;
  PlaceCapsules(arm, q, &capsules);
  const auto has_visual = [&](int link) {
    return std::any_of(arm.visuals().begin(), arm.visuals().end(),
                       [&](const ArmVisual& visual) { return visual.link == link; });
  };

  std::vector<Body> bodies = MakeVisualBodies(arm, look.mesh, look.segments, warnings);
  for (const PlacedCapsule& capsule : capsules) {
    if (has_visual(capsule.link)) continue;
    const bool base = capsule.link < 0;
    const Isometry3d X_BW = base ? Isometry3d::Identity() : X_WL[capsule.link].inverse();
    TriangleMesh mesh =
        CapsuleMesh(X_BW * capsule.p_WA, X_BW * capsule.p_WB, capsule.radius, look.segments);
    bodies.push_back({base ? kWorldFrame : capsule.link, std::move(mesh),
                      base ? look.base : look.link, base ? 0.15F : 0.3F});
  }
  if (!arm.visuals().empty()) return bodies;
  for (int joint = 0; joint < arm.size(); ++joint) {
    if (arm.joint_kinds()[joint] != JointKind::kRevolute) continue;
    const std::optional<JointAxis> axis = FindAxis(arm, q, joint, capsules);
    if (!axis) continue;
    const double half = 1.18 * axis->radius;
    const Isometry3d X_LW = X_WL[joint].inverse();
    const Vector3d a = X_LW * (axis->p_W - half * axis->direction_W);
    const Vector3d b = X_LW * (axis->p_W + half * axis->direction_W);
    bodies.push_back(
        {joint, CylinderMesh(a, b, 0.92 * axis->radius, 0.14 * axis->radius), look.joint, 0.35F});
  }
  return bodies;
}

Scene MakeArmScene(const ArmModel& arm, const std::vector<Marker>& tool_markers,
                   const std::vector<Marker>& goal_markers, const ArmLook& look,
                   std::vector<std::string>* warnings) {
  Scene scene;
  scene.bodies = MakeArmBodies(arm, look, warnings);
  const JointVector q = JointVector::Zero(arm.size());
  std::vector<PlacedCapsule> placed;
  PlaceCapsules(arm, q, &placed);
  for (std::size_t i = 0; i < placed.size(); ++i) {
    Capsule capsule = arm.capsules()[i];
    if (capsule.link < 0) {  // The base's frame is the arm's own business: take it as placed.
      capsule = {kWorldFrame, placed[i].p_WA, placed[i].p_WB, placed[i].radius};
    }
    scene.capsules.push_back(capsule);
  }
  const auto add = [&](int frame, const std::vector<Marker>& markers) {
    for (const Marker& marker : markers) scene.markers.push_back({frame, marker, look.plate});
  };
  add(kToolFrame, tool_markers);
  add(kGoalFrame, goal_markers);
  AddStruts(tool_markers, look, &scene);
  return scene;
}

}  // namespace vantage::sim
