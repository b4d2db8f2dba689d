#pragma once

#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "vantage/math/sizes.h"
#include "vantage/math/spatial.h"

/// @file
/// Arm models: constant data of one arm (Pinocchio's "Model"). World frame W is the arm's world;
/// link i is the body moved by joints 0..i; link -1 is the base.

namespace KDL {
class Chain;
}

namespace vantage {

enum class DhConvention {
  kStandard,  ///< A = Rz(theta) Tz(d) Tx(a) Rx(alpha).
  kModified,  ///< Craig: A = Rx(alpha) Tx(a) Rz(theta) Tz(d).
};

enum class JointKind { kRevolute, kPrismatic };

/// One row of a Denavit-Hartenberg table. Revolute: theta = q + offset; prismatic: d = q + offset.
struct DhRow {
  JointKind kind{JointKind::kRevolute};
  double theta{0.0};   ///< [rad]; of prismatic joints.
  double d{0.0};       ///< [m]; of revolute joints.
  double a{0.0};       ///< [m].
  double alpha{0.0};   ///< [rad].
  double offset{0.0};  ///< [rad] or [m].
};

/// Bounds of one joint.
struct JointLimits {
  double lower{-3.141592653589793};  ///< [rad] or [m].
  double upper{3.141592653589793};   ///< [rad] or [m]; > lower.
  double velocity{1.0};              ///< [rad/s] or [m/s]; > 0.
  double acceleration{10.0};         ///< [rad/s²] or [m/s²]; > 0.
};

/// A cylinder with round ends, fixed to a link: its body for occlusion.
struct Capsule {
  int link{-1};                                 ///< Link it moves with; -1: base.
  Eigen::Vector3d p_LA{Eigen::Vector3d::Zero()};  ///< One end of the axis, in the link's frame [m].
  Eigen::Vector3d p_LB{Eigen::Vector3d::Zero()};  ///< The other end [m].
  double radius{0.0};                           ///< [m]; > 0.
};

/// Constant model of one serial arm with n <= kMaxJoints joints. Cheap to copy (shared state).
class ArmModel {
 public:
  /// From a DH table. `base` places the first DH frame in W, `tool` the end effector E in the last.
  /// Throws ConfigError when sizes do not agree, there is no joint or more than kMaxJoints, a limit
  /// is empty or a value is not finite.
  ArmModel(std::string name, DhConvention convention, const std::vector<DhRow>& rows,
           std::vector<JointLimits> limits, const Eigen::Isometry3d& X_WBase,
           const Eigen::Isometry3d& X_LastE, std::vector<Capsule> capsules = {});

  [[nodiscard]] const std::string& name() const noexcept;
  [[nodiscard]] int size() const noexcept;  ///< Number of joints n.
  [[nodiscard]] const std::vector<std::string>& joint_names() const noexcept;
  [[nodiscard]] const std::vector<JointKind>& joint_kinds() const noexcept;
  [[nodiscard]] const std::vector<JointLimits>& limits() const noexcept;
  [[nodiscard]] const std::vector<Capsule>& capsules() const noexcept;
  /// The same arm with another set of limits (throws as the constructor does).
  [[nodiscard]] ArmModel WithLimits(std::vector<JointLimits> limits) const;

  struct Data;
  [[nodiscard]] const Data& data() const noexcept { return *data_; }

 private:
  std::shared_ptr<const Data> data_;
};

/// Every joint within its position limits, and finite.
[[nodiscard]] bool WithinLimits(const ArmModel& arm, const JointVector& q) noexcept;

/// q moved into the position limits.
[[nodiscard]] JointVector ClampToLimits(const ArmModel& arm, const JointVector& q) noexcept;

}  // namespace vantage
