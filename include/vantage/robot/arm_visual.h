#pragma once

#include <optional>
#include <string>
#include <variant>

#include <Eigen/Core>
#include <Eigen/Geometry>

/// @file
/// What an arm looks like, as far as its description says so. Drawing is for others.

namespace vantage {

/// Axis-aligned about the shape's origin.
struct BoxShape {
  Eigen::Vector3d size{Eigen::Vector3d::Ones()};  ///< Edge lengths [m]; > 0.
};

/// About the shape's z axis, centred at its origin.
struct CylinderShape {
  double radius{0.0};  ///< [m]; > 0.
  double length{0.0};  ///< [m]; > 0.
};

/// A ball about the shape's origin.
struct SphereShape {
  double radius{0.0};  ///< [m]; > 0.
};

/// A cylinder with round ends; a ball when they coincide.
struct CapsuleShape {
  Eigen::Vector3d p_A{Eigen::Vector3d::Zero()};  ///< One end of the axis [m].
  Eigen::Vector3d p_B{Eigen::Vector3d::Zero()};  ///< The other end [m].
  double radius{0.0};                            ///< [m]; > 0.
};

/// A mesh file, its coordinates times `scale`.
struct MeshShape {
  std::string path;                                ///< Of an existing file.
  Eigen::Vector3d scale{Eigen::Vector3d::Ones()};  ///< May mirror.
};

/// What a link's visual geometry can be.
using Shape = std::variant<BoxShape, CylinderShape, SphereShape, CapsuleShape, MeshShape>;

/// One visible body of an arm.
struct ArmVisual {
  int link{-1};  ///< Link it moves with, as in Capsule; -1: base.
  Eigen::Isometry3d X_LV{Eigen::Isometry3d::Identity()};  ///< The shape in the link's frame.
  Shape shape;  ///< What it looks like, about its own origin.
  /// Red, green, blue; 0 to 1. None: the mesh's own colours, or whatever the drawer likes.
  std::optional<Eigen::Vector3f> colour;
};

}  // namespace vantage
