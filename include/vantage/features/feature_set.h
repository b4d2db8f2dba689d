#pragma once

#include <array>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "vantage/camera/camera_model.h"
#include "vantage/camera/pinhole.h"
#include "vantage/math/sizes.h"

/// @file
/// Visual features v (paper, eq. 1) over image points, with ViSP's interaction matrices.

namespace vantage {

enum class FeatureKind {
  kPointX,     ///< u of a point [px]. points = {i}.
  kPointY,     ///< v of a point [px]. points = {i}.
  kDistance,   ///< Distance of two image points [px]. {i, j}.
  kAngle,      ///< atan2(v_j - v_i, u_j - u_i) [rad]. {i, j}.
  kEdgeAngle,  ///< Signed angle from edge i->j to edge k->l [rad]. {i, j, k, l}.
  kArea,       ///< Signed shoelace area of a polygon [px²]. {i, j, k, ...}.
  kCentroidX,  ///< u of the points' centroid [px]. {i, ...}.
  kCentroidY,  ///< v of the points' centroid [px]. {i, ...}.
};

/// One feature row: a kind over image points, named by their index in the point list.
struct Feature {
  FeatureKind kind{FeatureKind::kPointX};
  std::vector<int> points;
};

/// One image point that features are computed from.
struct PointView {
  ImagePoint image;  ///< Undistorted normalised coordinates and depth.
  /// False: the rows that need it are left out, as they are where depth is below kMinDepth or a value
  /// is not finite.
  bool visible{false};
  bool on_body{true};  ///< Moves with the end effector (false: fixed in the world).
};

using PointViews = std::vector<PointView>;

/// Feature values and their derivatives; k rows, one for each feature whose points are all visible.
struct FeatureRows {
  FeatureVector s;         ///< k values [px, rad, px²].
  FeatureJacobian L;       ///< k×6: ds/dt = L V_WC_C, all points fixed in the world.
  FeatureJacobian L_body;  ///< k×6: the part of L that comes from points on the end effector.
  std::array<int, kMaxRows> feature{};  ///< Index of the feature that each row belongs to.

  [[nodiscard]] int size() const noexcept { return static_cast<int>(s.size()); }
};

/// An ordered list of features.
class FeatureSet {
 public:
  /// Throws ConfigError when a feature has the wrong number of points, names a point outside
  /// [0, num_points) or the same point as both ends of an edge, or there are no features or more than
  /// kMaxRows, no points or more than kMaxPoints.
  FeatureSet(std::vector<Feature> features, int num_points);

  [[nodiscard]] const std::vector<Feature>& features() const noexcept { return features_; }
  [[nodiscard]] int num_points() const noexcept { return num_points_; }

  /// Both coordinates of each of num_points points: (u_0, v_0, u_1, v_1, ...).
  [[nodiscard]] static FeatureSet AllPoints(int num_points);

  /// Values and interaction matrices at the given points. Rows whose value has no derivative there
  /// (coincident image points of a distance or an angle) are left out, as those not visible are.
  ///
  /// Real-time safe but for the allocations of ViSP's interaction(): 10 for each point used, and 3
  /// more in the first call of a thread.
  /// @pre points.size() == num_points().
  void Evaluate(const CameraModel& camera, const PointViews& points, FeatureRows* rows) const;

 private:
  std::vector<Feature> features_;
  int num_points_{0};
};

/// Image Jacobian J_v of points on the end effector, seen by a camera that stands elsewhere
/// (eye-to-hand): ds/dt = J_v V_WE_W, J_v = -L_body Ad, with V_WE_W the velocity of E's origin [m/s]
/// and its angular velocity [rad/s] in world axes (paper, eq. 2). Real-time safe.
[[nodiscard]] FeatureJacobian ImageJacobian(const FeatureJacobian& L_body,
                                            const Eigen::Isometry3d& X_WC,
                                            const Eigen::Vector3d& p_WE) noexcept;

/// Image Jacobian J_v of a camera carried by the end effector (eye-in-hand): ds/dt = J_v V_WE_W,
/// J_v = (L - L_body) Ad. Points on the end effector stand still in its image. Real-time safe.
[[nodiscard]] FeatureJacobian ImageJacobianEyeInHand(const FeatureRows& rows,
                                                     const Eigen::Isometry3d& X_WC,
                                                     const Eigen::Vector3d& p_WE) noexcept;

/// Error s - s_goal row by row; angles are wrapped to (-π, π]. Real-time safe.
/// @pre a row of s and s_goal belong to the same feature.
[[nodiscard]] FeatureVector FeatureError(const FeatureSet& set, const FeatureRows& current,
                                         const FeatureRows& goal) noexcept;

}  // namespace vantage
