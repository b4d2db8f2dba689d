#include <cmath>

#include "vantage/config/loaders.h"
#include "vantage/math/angles.h"

namespace vantage {
namespace {

using Eigen::AngleAxisd;
using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double kFarthest = 1000.0;  // [m]

Eigen::Matrix3d RollPitchYaw(const Vector3d& degrees) {
  const Vector3d rpy = degrees * kDegree;
  return (AngleAxisd(rpy.z(), Vector3d::UnitZ()) * AngleAxisd(rpy.y(), Vector3d::UnitY()) *
          AngleAxisd(rpy.x(), Vector3d::UnitX()))
      .toRotationMatrix();
}

Eigen::Matrix3d LoadQuaternion(const Section& section) {
  const Eigen::VectorXd q = section.Numbers("quaternion", {-1.001, 1.001, ""}, 4, 4,
                                            "Orientation as (w, x, y, z), of length 1.");
  if (std::abs(q.norm() - 1.0) > 1e-3) {
    section.Fail("quaternion", "must have length 1, has " + std::to_string(q.norm()));
  }
  return Quaterniond(q(0), q(1), q(2), q(3)).normalized().toRotationMatrix();
}

Vector3d LoadPosition(const Section& section) {
  return section.Vector3("position", {-kFarthest, kFarthest, "m"}, Vector3d(0, 0, 0),
                         "Origin of the frame.");
}

// The rotation that quaternion or rpy_deg give.
Eigen::Matrix3d LoadRotation(const Section& section) {
  if (section.FormOf("quaternion") != Section::Form::kAbsent) {
    if (section.FormOf("rpy_deg") != Section::Form::kAbsent) {
      section.Fail("rpy_deg", "must not be given beside quaternion");
    }
    return LoadQuaternion(section);
  }
  return RollPitchYaw(section.Vector3(
      "rpy_deg", {-360.0, 360.0, "deg"}, Vector3d(0, 0, 0),
      "Orientation as roll, pitch, yaw: R = Rz(yaw) Ry(pitch) Rx(roll), as URDF has it."));
}

}  // namespace

Eigen::Isometry3d LoadPose(const Section& parent, const std::string& key, bool required,
                           const std::string& help) {
  const Section section = required ? parent.Child(key, help) : parent.OptionalChild(key, help);
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.translation() = LoadPosition(section);
  X.linear() = LoadRotation(section);
  return X;
}

Eigen::Isometry3d LoadCameraPose(const Section& parent, const std::string& key,
                                 const std::string& help) {
  if (parent.FormOf(key) != Section::Form::kMapping) return LoadPose(parent, key, true, help);
  const Section section = parent.Child(key, help);
  if (section.FormOf("look_at") == Section::Form::kAbsent) {
    return LoadPose(parent, key, true, help);
  }
  const Vector3d position = LoadPosition(section);
  const Vector3d target =
      section.Vector3("look_at", {-kFarthest, kFarthest, "m"}, kRequired,
                      "Camera: point that the optical axis passes through, instead of rpy_deg.");
  const double roll = section.Degrees("roll_deg", {-3600.0, 3600.0, "deg"}, 0.0,
                                      "Camera: turn about the optical axis; at 0 the image's rows "
                                      "are level.");
  const Vector3d offset = position - target;
  if (!(offset.norm() > 1e-6)) section.Fail("look_at", "must not be the position itself");
  return SphericalPose(RigOrientation::kLookAt, target,
                       {offset.norm(), std::atan2(offset.head<2>().norm(), offset.z()),
                        std::atan2(offset.y(), offset.x()), roll});
}

}  // namespace vantage
