#include "vantage/robot/urdf.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "message_text.h"
#include "urdf_chain.h"
#include "urdf_document.h"
#include "urdf_geometry.h"
#include "vantage/math/angles.h"
#include "vantage/math/error.h"

namespace vantage {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr double kContinuousRange = 2.0 * kPi;  // Each way [rad].
constexpr double kContinuousSpeed = 1.0;        // Of continuous joints without a limit [rad/s].

// Of capsules that replace meshes, as a share of the chain's length; and its bounds [m].
constexpr double kStandInShare = 0.04;
constexpr double kThinnestStandIn = 0.01;
constexpr double kThickestStandIn = 0.08;

// Rotation that takes z to a unit axis; exact for axes along the frame's.
Isometry3d AlignZ(const Vector3d& axis) {
  Isometry3d X = Isometry3d::Identity();
  if (axis == Vector3d::UnitZ()) return X;
  const Vector3d x = axis.unitOrthogonal();
  X.linear() << x, axis.cross(x), axis;
  return X;
}

JointLimits ReadLimits(const UrdfDocument& document, const urdf::Joint& joint,
                       const UrdfOptions& options, std::vector<std::string>* notes) {
  const bool continuous = joint.type == urdf::Joint::CONTINUOUS;
  JointLimits limits{-kContinuousRange, kContinuousRange, kContinuousSpeed, 0.0};
  if (!continuous && joint.limits == nullptr) {
    document.FailJoint(joint.name, "needs <limit lower upper velocity>");
  }
  if (!continuous) {
    limits.lower = joint.limits->lower;
    limits.upper = joint.limits->upper;
    if (!std::isfinite(limits.lower) || !std::isfinite(limits.upper) ||
        !(limits.upper > limits.lower)) {
      document.FailJoint(joint.name, "limit: upper must be above lower, are " +
                                         Text({limits.upper}) + " and " + Text({limits.lower}));
    }
  }
  if (joint.limits != nullptr) {
    limits.velocity = joint.limits->velocity;
    if (!std::isfinite(limits.velocity) || !(limits.velocity > 0.0)) {
      document.FailJoint(joint.name, "limit: velocity must be > 0, is " + Text({limits.velocity}));
    }
  }
  limits.acceleration = limits.velocity / options.acceleration_time;
  if (continuous) {
    notes->push_back(
        document.Joint(joint.name) + " is continuous: its range is taken as -360 to 360 deg" +
        (joint.limits == nullptr ? ", its greatest speed as " + Text({kContinuousSpeed}) + " rad/s"
                                 : ""));
  }
  return limits;
}

Vector3d ReadAxis(const UrdfDocument& document, const urdf::Joint& joint) {
  const Vector3d axis = ToEigen(joint.axis);
  if (!axis.allFinite() || !(axis.norm() > 1e-6)) {
    document.FailJoint(joint.name, "axis must be finite and not zero");
  }
  // As it is when it is a unit vector: to divide might cost the last digit.
  return std::abs(axis.squaredNorm() - 1.0) < 1e-15 ? axis : axis.normalized();
}

}  // namespace

UrdfArm LoadUrdfArm(const std::string& path, const std::string& base_link,
                    const std::string& tip_link, const UrdfOptions& options) {
  if (!std::isfinite(options.acceleration_time) || !(options.acceleration_time > 0.0)) {
    throw ConfigError("", "acceleration_time",
                      "must be finite and > 0 s, is " + Text({options.acceleration_time}));
  }
  const UrdfDocument document(path);
  const UrdfChain chain = FindChain(document, base_link, tip_link);
  const auto moving = MovingJoints(document, chain);
  std::vector<std::string> warnings = document.complaints();
  for (std::string& warning : warnings) warning = path + ": " + warning;
  std::vector<std::string> notes;

  std::vector<std::string> frozen;
  const std::map<std::string, Attachment> attachments = AttachLinks(document, chain, &frozen);
  std::vector<JointTransform> joints;
  std::vector<JointLimits> limits;
  std::vector<std::string> names;
  double length = 0.0;
  for (const auto& joint : moving) {
    const Isometry3d X_PJ = ToEigen(joint->parent_to_joint_origin_transform);
    if (!X_PJ.matrix().allFinite()) {
      document.FailJoint(joint->name, "has an origin that is not finite");
    }
    const Isometry3d X_axis = AlignZ(ReadAxis(document, *joint));
    const Isometry3d X_before = attachments.at(joint->parent_link_name).X_LU * X_PJ;
    joints.push_back(
        {joint->type == urdf::Joint::PRISMATIC ? JointKind::kPrismatic : JointKind::kRevolute,
         X_before * X_axis, X_axis.inverse()});
    limits.push_back(ReadLimits(document, *joint, options, &notes));
    names.push_back(joint->name);
    length += X_before.translation().norm();
  }
  const Isometry3d X_LastE = attachments.at(chain.tip_link).X_LU;
  length += X_LastE.translation().norm();

  UrdfBodies bodies =
      MakeBodies(document, attachments, options.package_folders,
                 std::clamp(kStandInShare * length, kThinnestStandIn, kThickestStandIn), &warnings);
  if (!chain.other_tips.empty()) {
    notes.push_back(path + ": the end effector is link '" + chain.tip_link +
                    "'; on the same body: " + Listed(chain.other_tips));
  }
  if (!frozen.empty()) {
    notes.push_back(path + ": joints off the chain to '" + chain.tip_link +
                    "' do not move: " + Listed(frozen));
  }
  notes.push_back(path +
                  ": URDF has no acceleration limits; each joint reaches its greatest speed in " +
                  Text({options.acceleration_time}) + " s");
  const ArmModel arm = ArmModel(document.model().getName(), joints, limits, Isometry3d::Identity(),
                                X_LastE, std::move(bodies.capsules), names)
                           .WithVisuals(std::move(bodies.visuals));
  return {arm, chain.base_link, chain.tip_link, std::move(warnings), std::move(notes)};
}

}  // namespace vantage
