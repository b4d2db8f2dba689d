#pragma once

#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "vantage/math/angles.h"
#include "vantage/math/sizes.h"
#include "vantage/math/spatial.h"
#include "vantage/robot/arm_visual.h"

/// @file
/// Arm models: constant data of one arm (Pinocchio's "Model"). World frame W is the arm's world;
/// link i is the body moved by joints 0..i; link -1 is the base.

namespace vantage {

/// Of the two Denavit-Hartenberg conventions, Craig's (modified) or the distal one.
enum class DhConvention {
  kStandard,  ///< A = Rz(theta) Tz(d) Tx(a) Rx(alpha).
  kModified,  ///< Craig: A = Rx(alpha) Tx(a) Rz(theta) Tz(d).
};

/// A joint turns [rad] or slides [m].
enum class JointKind { kRevolute, kPrismatic };

/// One row of a Denavit-Hartenberg table. Revolute: theta = q + offset; prismatic: d = q + offset.
struct DhRow {
  JointKind kind{JointKind::kRevolute};  ///< Which of theta and d the joint moves.
  double theta{0.0};                     ///< [rad]; of prismatic joints.
  double d{0.0};                         ///< [m]; of revolute joints.
  double a{0.0};                         ///< [m].
  double alpha{0.0};                     ///< [rad].
  double offset{0.0};                    ///< [rad] or [m].
};

/// One joint and the link it moves, in general form: X_(i-1)i = X_before M(q) X_after, with M a
/// turn about z (revolute) or a shift along z (prismatic). Any serial arm can be written so.
struct JointTransform {
  JointKind kind{JointKind::kRevolute};  ///< What M(q) is: a turn [rad] or a shift [m].
  /// From the link before to the joint.
  Eigen::Isometry3d X_before{Eigen::Isometry3d::Identity()};
  Eigen::Isometry3d X_after{Eigen::Isometry3d::Identity()};  ///< From the moved joint to its link.
};

/// Bounds of one joint.
struct JointLimits {
  double lower{-kPi};         ///< [rad] or [m].
  double upper{kPi};          ///< [rad] or [m]; > lower.
  double velocity{1.0};       ///< [rad/s] or [m/s]; > 0.
  double acceleration{10.0};  ///< [rad/s²] or [m/s²]; > 0.
};

/// A cylinder with round ends, fixed to a link: its body for occlusion.
struct Capsule {
  int link{-1};                                   ///< Link it moves with; -1: base.
  Eigen::Vector3d p_LA{Eigen::Vector3d::Zero()};  ///< One end of the axis, in the link's frame [m].
  Eigen::Vector3d p_LB{Eigen::Vector3d::Zero()};  ///< The other end [m]; equal to p_LA: a ball.
  double radius{0.0};                             ///< [m]; > 0.
};

/// Constant model of one serial arm with n <= kMaxJoints joints. Cheap to copy (shared state), and
/// safe to use from several threads at once.
class ArmModel {
 public:
  /// From a DH table. `base` places the first DH frame in W, `tool` the end effector E in the last.
  /// Without joint names they are "joint1", "joint2", ...
  /// Throws ConfigError when sizes do not agree, there is no joint or more than kMaxJoints, a limit
  /// is empty, two joints have one name, a capsule has no body or no link, or a value is not finite.
  ArmModel(std::string name, DhConvention convention, const std::vector<DhRow>& rows,
           std::vector<JointLimits> limits, const Eigen::Isometry3d& X_WBase,
           const Eigen::Isometry3d& X_LastE, std::vector<Capsule> capsules = {},
           std::vector<std::string> joint_names = {});

  /// From joints in general form; the rest as above.
  ArmModel(std::string name, const std::vector<JointTransform>& joints,
           std::vector<JointLimits> limits, const Eigen::Isometry3d& X_WBase,
           const Eigen::Isometry3d& X_LastE, std::vector<Capsule> capsules = {},
           std::vector<std::string> joint_names = {});

  [[nodiscard]] const std::string& name() const noexcept;
  [[nodiscard]] int size() const noexcept;  ///< Number of joints n.
  [[nodiscard]] const std::vector<std::string>& joint_names() const noexcept;
  [[nodiscard]] const std::vector<JointKind>& joint_kinds() const noexcept;
  [[nodiscard]] const std::vector<JointLimits>& limits() const noexcept;
  [[nodiscard]] const std::vector<Capsule>& capsules() const noexcept;
  /// Visible bodies; empty when the arm's description has none.
  [[nodiscard]] const std::vector<ArmVisual>& visuals() const noexcept;
  [[nodiscard]] const Eigen::Isometry3d& X_WBase() const noexcept;  ///< Pose of the base, link -1.
  [[nodiscard]] const Eigen::Isometry3d& X_LastE() const noexcept;  ///< E in the last link.

  /// The same arm with another set of limits (throws as the constructor does).
  [[nodiscard]] ArmModel WithLimits(std::vector<JointLimits> limits) const;
  /// The same arm with another end effector frame (throws as the constructor does).
  [[nodiscard]] ArmModel WithTool(const Eigen::Isometry3d& X_LastE) const;
  /// The same arm standing elsewhere (throws as the constructor does).
  [[nodiscard]] ArmModel WithBase(const Eigen::Isometry3d& X_WBase) const;

  /// The same arm with another look. Throws ConfigError when a visual has no link, no pose or no size.
  [[nodiscard]] ArmModel WithVisuals(std::vector<ArmVisual> visuals) const;

  struct Data;
  [[nodiscard]] const Data& data() const noexcept { return *data_; }

 private:
  explicit ArmModel(std::shared_ptr<const Data> data);
  std::shared_ptr<const Data> data_;
};

/// Every joint within its position limits, and finite. Real-time safe.
/// @pre q.size() == arm.size().
[[nodiscard]] bool WithinLimits(const ArmModel& arm, const JointVector& q) noexcept;

/// q moved into the position limits; a NaN stays one. Real-time safe.
/// @pre q.size() == arm.size().
[[nodiscard]] JointVector ClampToLimits(const ArmModel& arm, const JointVector& q) noexcept;

}  // namespace vantage
