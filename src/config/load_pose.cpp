#include <cmath>

#include "vantage/config/loaders.h"

namespace vantage {
namespace {

using Eigen::AngleAxisd;
using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double kFarthest = 1000.0;  // [m]

Eigen::Matrix3d RollPitchYaw(const Vector3d& degrees) {
  const Vector3d rpy = degrees * (M_PI / 180.0);
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

}  // namespace

Eigen::Isometry3d LoadPose(const Section& parent, const std::string& key, bool required,
                           const std::string& help) {
  const Section section = required ? parent.Child(key, help) : parent.OptionalChild(key, help);
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.translation() = section.Vector3("position", {-kFarthest, kFarthest, "m"}, Vector3d(0, 0, 0),
                                    "Origin of the frame.");
  if (section.FormOf("quaternion") != Section::Form::kAbsent) {
    X.linear() = LoadQuaternion(section);
    if (section.FormOf("rpy_deg") != Section::Form::kAbsent) {
      section.Fail("rpy_deg", "must not be given beside quaternion");
    }
    return X;
  }
  X.linear() = RollPitchYaw(section.Vector3(
      "rpy_deg", {-360.0, 360.0, "deg"}, Vector3d(0, 0, 0),
      "Orientation as roll, pitch, yaw: R = Rz(yaw) Ry(pitch) Rx(roll), as URDF has it."));
  return X;
}

}  // namespace vantage
