#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "vantage/camera/camera_model.h"
#include "vantage/camera/pinhole.h"
#include "vantage/math/sizes.h"

/// @file
/// Visual features v (paper, eq. 1) over image points, with ViSP's interaction matrices.
///
/// Features are in pixels where the camera model is a camera's. InUnits() makes the model that gives the
/// same features in normalised or metric units.

namespace vantage {

/// What is measured of points in the image.
enum class FeatureKind {
  kPointX,     ///< u of a point [px]. points = {i}.
  kPointY,     ///< v of a point [px]. points = {i}.
  kDistance,   ///< Distance of two image points [px]. {i, j}.
  kAngle,      ///< atan2(v_j - v_i, u_j - u_i) [rad]. {i, j}.
  kEdgeAngle,  ///< Signed angle from edge i->j to edge k->l [rad]. {i, j, k, l}.
  kArea,       ///< Signed shoelace area of a polygon [px²]. {i, j, k, ...}.
  kCentroidX,  ///< u of the points' centroid [px]. {i, ...}.
  kCentroidY,  ///< v of the points' centroid [px]. {i, ...}.

  // The segment from i to j as vpFeatureSegment has it. {i, j}.
  kSegmentX,              ///< u of its centre [px].
  kSegmentY,              ///< v of its centre [px].
  kSegmentLength,         ///< Length l [px].
  kSegmentAngle,          ///< atan2(v_j - v_i, u_j - u_i) [rad].
  kSegmentXNormalised,    ///< (u of its centre - u0) / l [-].
  kSegmentYNormalised,    ///< (v of its centre - v0) / l [-].
  kSegmentInverseLength,  ///< 1 / l [1/px].

  // Moments of a set of points as vpFeatureMoment* have them: sums over the points' pixels from the
  // principal point, x = u - u0 and y = v - v0. {i, ...}; those about the centroid need two points.
  kMomentBasic,           ///< m_pq = Σ x^p y^q [px^(p+q)], 1 <= p + q <= 3.
  kMomentCentred,         ///< μ_pq = Σ (x - x_g)^p (y - y_g)^q [px^(p+q)], 2 <= p + q <= 3.
  kMomentX,               ///< u of the gravity centre [px].
  kMomentY,               ///< v of the gravity centre [px].
  kMomentArea,            ///< a = μ_20 + μ_02 [px²].
  kMomentAreaNormalised,  ///< a_n = Z* sqrt(a*/a) [m].
  kMomentXNormalised,     ///< a_n x_g [px m].
  kMomentYNormalised,     ///< a_n y_g [px m].
  kMomentAlpha,           ///< Orientation ½ atan2(2 μ_11, μ_20 - μ_02) [rad], in (-π/2, π/2].
};

/// One feature row: a kind over image points, named by their index in the point list.
struct Feature {
  FeatureKind kind{FeatureKind::kPointX};  ///< What is measured, and so the unit of the row.
  std::vector<int> points;                 ///< As many and in the order that the kind asks for.
  int order_x{0};                          ///< p of kMomentBasic and kMomentCentred.
  int order_y{0};                          ///< q of kMomentBasic and kMomentCentred.
  double desired_area{1.0};                ///< a* of the normalised moments [px²]; > 0.
  double desired_depth{1.0};               ///< Z* of the normalised moments [m]; > 0.
};

/// The kind as files name it: "point_x", "segment_length", ... Empty for what is not a kind.
[[nodiscard]] const char* NameOf(FeatureKind kind) noexcept;

/// How many points a feature names.
struct PointCount {
  int least;  ///< Fewest; 1 or more.
  int most;   ///< Most; below `least`: none fits.
};

/// The number of points that a feature of the kind takes; none fits what is not a kind.
[[nodiscard]] PointCount PointsOf(FeatureKind kind) noexcept;

/// Every kind, in the order of the enumeration.
[[nodiscard]] const std::vector<FeatureKind>& AllFeatureKinds();

/// Units of the features' image coordinates.
enum class ImageUnits {
  kPixels,      ///< As the camera gives them, skew included.
  kNormalised,  ///< On the plane at unit distance [-].
  kMetric,      ///< On the image plane of focal length f [m], as the paper has it.
};

/// The camera that sees the same in other units; without distortion unless units are pixels.
/// @param focal_length  f [m] of kMetric.
[[nodiscard]] CameraModel InUnits(const CameraModel& camera, ImageUnits units,
                                  double focal_length = 1.0) noexcept;

/// One image point that features are computed from.
struct PointView {
  ImagePoint image;  ///< Undistorted normalised coordinates and depth.
  /// False: the rows that need it are left out, as they are where depth is below kMinDepth or a value
  /// is not finite.
  bool visible{false};
  bool on_body{true};  ///< Moves with the end effector (false: fixed in the world).
};

/// All points of a set, in its order.
using PointViews = std::vector<PointView>;

/// The image of a point at p_CP. One behind or nearly in the camera's plane keeps its depth, is not
/// visible and is never projected; one that is not finite keeps that. Real-time safe.
[[nodiscard]] PointView ViewOf(const Eigen::Vector3d& p_CP, bool on_body) noexcept;

/// Where the interaction matrices come from. Both give the same to rounding (a test holds them to it).
enum class InteractionSource : int {
  kVisp = 0,        ///< ViSP's feature classes.
  kClosedForm = 1,  ///< PointInteraction() and the chain rule; allocates nothing.
};

/// What became of one feature.
enum class RowStatus : int {
  kOk = 0,            ///< It has a row.
  kNotSeen = 1,       ///< A point of it is not visible.
  kBehindCamera = 2,  ///< A point of it is behind the camera or nearer than kMinDepth.
  kNotFinite = 3,     ///< A point of it is NaN or infinite.
  kCoincident = 4,    ///< Points that it needs apart coincide in the image: no derivative there.
  kUndefined = 5,     ///< The points have no orientation (kMomentAlpha of a symmetric set).
};

/// As programs print it: "OK", "NOT_SEEN", "BEHIND_CAMERA", "NOT_FINITE", "COINCIDENT", "UNDEFINED".
[[nodiscard]] const char* NameOf(RowStatus status) noexcept;

/// Feature values and their derivatives; k rows, one for each feature whose points are all visible.
struct FeatureRows {
  FeatureVector s;         ///< k values, each in the unit of its feature's kind.
  FeatureJacobian L;       ///< k×6: ds/dt = L V_WC_C, all points fixed in the world.
  FeatureJacobian L_body;  ///< k×6: the part of L that comes from points on the end effector.
  std::array<int, kMaxRows> feature{};  ///< Index of the feature that each row belongs to.
  /// What became of each feature of the set, by its index; kNotSeen past the set's size.
  std::array<RowStatus, kMaxRows> status{};

  [[nodiscard]] int size() const noexcept { return static_cast<int>(s.size()); }
};

/// An ordered list of features.
class FeatureSet {
 public:
  /// Throws ConfigError when a feature has the wrong number of points, names a point outside
  /// [0, num_points) or the same point as both ends of an edge, has an order, desired area or depth out
  /// of its range, or there are no features or more than kMaxRows, no points or more than kMaxPoints.
  FeatureSet(std::vector<Feature> features, int num_points);

  [[nodiscard]] const std::vector<Feature>& features() const noexcept { return features_; }
  [[nodiscard]] int num_points() const noexcept { return num_points_; }

  /// Both coordinates of each of num_points points: (u_0, v_0, u_1, v_1, ...).
  [[nodiscard]] static FeatureSet AllPoints(int num_points);

  /// Values and interaction matrices at the given points. Rows whose value has no derivative there
  /// (coincident image points of a distance or an angle) are left out, as those not visible are;
  /// rows->status says why.
  ///
  /// ViSP's interaction matrices are vpFeaturePoint's by the chain rule; vpFeatureSegment's and
  /// vpFeatureMoment*'s where their model holds, that is where all points of the feature are on one body
  /// (and, for moments, in one plane), and the points' elsewhere.
  ///
  /// Real-time safe but for the allocations of ViSP's interaction(): 10 for each point used, and 3
  /// more in the first call of a thread. Segments and moments cost those of ViSP's classes for them.
  /// @pre points.size() == num_points().
  void Evaluate(const CameraModel& camera, const PointViews& points, FeatureRows* rows,
                InteractionSource source = InteractionSource::kVisp) const;

  /// Values alone: rows->L and rows->L_body come out without rows. Real-time safe.
  /// @pre As Evaluate().
  void EvaluateValues(const CameraModel& camera, const PointViews& points, FeatureRows* rows) const;

 private:
  void EvaluateRows(const CameraModel& camera, const PointViews& points, InteractionSource source,
                    bool with_gradient, FeatureRows* rows) const;

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

/// Error s - s_goal row by row; angles are wrapped to (-π, π], kMomentAlpha to (-π/2, π/2], as its
/// orientation has no head. Real-time safe.
/// @pre a row of s and s_goal belong to the same feature.
[[nodiscard]] FeatureVector FeatureError(const FeatureSet& set, const FeatureRows& current,
                                         const FeatureRows& goal) noexcept;

}  // namespace vantage
