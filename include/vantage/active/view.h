#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "vantage/camera/camera_model.h"
#include "vantage/features/feature_set.h"
#include "vantage/features/marker.h"
#include "vantage/math/sizes.h"
#include "vantage/observability/measures.h"
#include "vantage/robot/arm_model.h"
#include "vantage/robot/kinematics.h"

/// @file
/// What a camera would see of the arm from somewhere, by the model: the ground the view planner, the
/// trigger and the offline placement share.

namespace vantage {

/// What the servo looks at. Constant during a run, but for the goal.
struct ViewModel {
  ArmModel arm;                 ///< The arm that carries the markers; its capsules may hide them.
  CameraModel camera;           ///< Intrinsics; where it stands is an argument of its own.
  FeatureSet features;          ///< Rows that the servo steers by, over the points below.
  std::vector<Marker> markers;  ///< On the end effector, poses in E; index = point of `features`.
};

/// Throws ConfigError when the features' points and the markers do not correspond, a marker's radius
/// is not positive or its normal is no unit vector.
void Validate(const ViewModel& model);

/// Demands on a view.
struct ViewLimits {
  double margin{20.0};        ///< Distance of every marker to the image border [px].
  double min_depth{0.3};      ///< [m].
  double max_depth{20.0};     ///< [m].
  double max_incidence{1.3};  ///< Angle between a marker's normal and the ray to it [rad].
  /// Short semi-axis of a disc's image: what a detector finds, and some [px].
  double min_semi_axis{2.0};
};

/// First thing that spoils a view, in the order they are checked.
enum class ViewFault : int {
  kNone = 0,
  kBehind,      ///< A marker is behind the camera.
  kTooNear,     ///< Nearer than min_depth.
  kTooFar,      ///< Beyond max_depth.
  kOutOfImage,  ///< Outside the image, margin included.
  kFacesAway,   ///< Seen from behind or too obliquely.
  kHidden,      ///< A link of the arm stands before it.
  kTooSmall,    ///< Its disc's image is too flat or too small to be found.
};

/// A marker centre with its normal, in the world.
struct PlacedMarker {
  Eigen::Vector3d p_W;       ///< Centre [m].
  Eigen::Vector3d normal_W;  ///< Unit; the side it is seen from.
  double radius;             ///< Of the disc [m]; see kRingRadii and kPlateRadii.
};

/// The arm at one configuration, with all that views of it need. Computed once for many cameras.
struct ArmSample {
  JointVector q;                          ///< Joints [rad or m].
  Kinematics kinematics;                  ///< Pose and Jacobian of the end effector at q.
  std::vector<PlacedMarker> markers;      ///< The end effector's.
  std::vector<PointJacobian> J_marker_W;  ///< Of the markers' centres: no camera is in it.
  /// Bodies of the links in the world, which may hide markers.
  std::vector<PlacedCapsule> capsules;
};
/// The arm at these joints, as views of it need it.
[[nodiscard]] ArmSample SampleArm(const ViewModel& model, const JointVector& q);
/// The same into storage that is kept. Real-time safe once *sample was filled for this model.
void SampleArm(const ViewModel& model, const JointVector& q, ArmSample* sample);

/// The first fault of `marker` seen from X_WC that is not occlusion. Real-time safe.
[[nodiscard]] ViewFault CheckMarkerUnobstructed(const CameraModel& camera, const ViewLimits& limits,
                                                const Eigen::Isometry3d& X_WC,
                                                const PlacedMarker& marker) noexcept;

/// Where rays to a marker start: a little before its face, so that a capsule whose skin the face lies on
/// is no obstacle [m].
[[nodiscard]] Eigen::Vector3d SightOf(const PlacedMarker& marker) noexcept;

/// The body that a ray from SightOf(marker) must not meet for the capsule not to hide the marker: the
/// capsule grown by the width of the marker's ring. None for a capsule that the marker's centre lies in
/// or touches: that one carries the marker and hides it only from behind. Real-time safe.
[[nodiscard]] std::optional<PlacedCapsule> ObstacleTo(const PlacedMarker& marker,
                                                      const PlacedCapsule& capsule) noexcept;

/// True when a capsule stands between the camera's centre and the marker: the segment from the
/// marker's centre to the camera comes nearer to the capsule's surface than the marker's ring is wide.
/// What is behind a marker's own body is for CheckMarkerUnobstructed() to find. Real-time safe.
[[nodiscard]] bool IsHidden(const Eigen::Vector3d& p_WC, const PlacedMarker& marker,
                            const std::vector<PlacedCapsule>& capsules) noexcept;

/// True when the plate that another marker is drawn on (a disc a little wider than its ring) stands between the
/// camera's centre and a part of the marker's ring. A marker does not cover itself. Real-time safe.
[[nodiscard]] bool IsCovered(const Eigen::Vector3d& p_WC, const PlacedMarker& marker,
                             const std::vector<PlacedMarker>& others) noexcept;

/// The first fault of seeing `marker` from X_WC; occlusion by `capsules` last. Real-time safe.
[[nodiscard]] ViewFault CheckMarker(const CameraModel& camera, const ViewLimits& limits,
                                    const Eigen::Isometry3d& X_WC, const PlacedMarker& marker,
                                    const std::vector<PlacedCapsule>& capsules) noexcept;

/// The same with everything that can stand before the marker: the arm's body, and the plates of its markers and
/// of the scene's. Real-time safe.
[[nodiscard]] ViewFault CheckMarkerAmong(const CameraModel& camera, const ViewLimits& limits,
                                         const Eigen::Isometry3d& X_WC, const PlacedMarker& marker,
                                         const ArmSample& arm,
                                         const std::vector<PlacedMarker>& scene_markers) noexcept;

/// Composite Jacobian of all the model's markers at the sample, visible or not, as long as they are in
/// front of the camera (rows of points behind are left out, as are rows without a derivative). Closed
/// forms, equal to FeatureSet's rows times the arm's Jacobian. Real-time safe.
[[nodiscard]] TaskJacobian CompositeJacobian(const ViewModel& model, const ArmSample& sample,
                                             const Eigen::Isometry3d& X_WC) noexcept;

/// Name as printed: "NONE", "BEHIND", "OUT_OF_IMAGE", ...
[[nodiscard]] const char* Name(ViewFault fault) noexcept;

}  // namespace vantage
