#pragma once

#include <vector>

#include <Eigen/Core>

#include "vantage/math/sizes.h"

/// @file
/// Measures of motion: manipulability w_r, observability w_v and the composite w_c (paper, eqs. 5, 17,
/// 20, in the form of docs/paper.md): the product of the s largest singular values, s = min of the
/// dimensions that bound the rank. Everything here needs Eigen alone.
///
/// Units: a measure is in whatever the Jacobian's entries are in. Metres and radians of a twist are
/// not comparable: w_v and w_r depend on the unit of length (see ScaleTwistOfImage()); w_c does not,
/// but for arms with prismatic joints (see ScaleJoints()).

namespace vantage {

/// Dimension m of the task: twists of a body in space.
inline constexpr int kTaskDimension = 6;

/// Relative tolerance of ranks where none is given: σ_i counts when σ_i > kRankTolerance * σ_1.
inline constexpr double kRankTolerance = 1e-9;

/// Any Jacobian: column-major matrices and blocks of them bind without a copy. Expressions would be
/// copied to the heap: evaluate them into a bounded type first. At most kMaxRows rows and kMaxRows
/// columns, and not more than kMaxJoints of both.
using JacobianRef = Eigen::Ref<const Eigen::MatrixXd>;

/// Why w_c is low.
enum class LowCause : int {
  kNone = 0,      ///< It is not.
  kView = 1,      ///< w_v or the coupling of view and arm: a camera move can help.
  kArm = 2,       ///< The arm does not move the points that way: no camera move can help.
  kFeatures = 3,  ///< Fewer feature rows than joints or task dimensions to be seen.
};

/// As programs print it: "NONE", "VIEW", "ARM", "FEATURES".
[[nodiscard]] const char* Name(LowCause cause) noexcept;

/// What a measure could be made of.
enum class MeasureStatus : int {
  kOk = 0,
  kEmpty = 1,      ///< No rows or no columns: no feature is seen.
  kNotFinite = 2,  ///< An entry is NaN or infinite.
  kTooLarge = 3,   ///< More rows or columns than the bounded types hold.
};

/// As programs print it: "OK", "EMPTY", "NOT_FINITE", "TOO_LARGE".
[[nodiscard]] const char* Name(MeasureStatus status) noexcept;

/// Singular values of one Jacobian and what follows from them. Never holds a NaN: where the status is
/// not kOk, sigma is empty, w, sigma_min and rank are 0, log_w is -inf and condition is inf.
struct Measure {
  MeasureStatus status{MeasureStatus::kEmpty};  ///< kOk: the rest was measured.
  /// σ_1 >= ... >= σ_s. Storage inside the object.
  Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kMaxRows, 1> sigma;
  double w{0.0};          ///< Product of sigma. 0 for s = 0.
  double log_w{0.0};      ///< Sum of log sigma; -inf when one is 0.
  double sigma_min{0.0};  ///< σ_s: the E-criterion of experiment design.
  double condition{0.0};  ///< σ_1 / σ_s; inf when σ_s is 0.
  int rank{0};            ///< Count of σ_i > tolerance · σ_1.

  /// s: how many singular values count.
  [[nodiscard]] int size() const noexcept { return static_cast<int>(sigma.size()); }

  /// w^(1/s): the geometric mean singular value; one threshold carries over arms with it. 0 for s = 0.
  [[nodiscard]] double geometric_mean() const noexcept;

  /// σ_s / σ_1; 0 where the condition number is infinite.
  [[nodiscard]] double inverse_condition() const noexcept;

  /// Sum of 1/σ_i²: the A-criterion, trace of the covariance of a motion computed from features with
  /// independent errors of unit variance. inf when a σ_i is 0, 0 for s = 0.
  [[nodiscard]] double inverse_trace() const noexcept;
};

/// Measures of J from its s = min(rows, columns, task_dimension) largest singular values: w_v of J_v
/// (k×6), w_r of J_r (6×n) and w_c of J_c (k×n), whose rank the task dimension caps (paper, the line
/// after eq. 11).
///
/// Singular values by one-sided Jacobi rotations after a pivoted QR: each is good to some 1e-15 σ_1.
///
/// @param rank_tolerance  Relative to σ_1; that of the entries where they were measured or rounded.
/// Real-time safe.
[[nodiscard]] Measure MeasureOf(const JacobianRef& J, int task_dimension = kTaskDimension,
                                double rank_tolerance = kRankTolerance) noexcept;

/// w of one Jacobian without its singular values.
struct Volume {
  MeasureStatus status{MeasureStatus::kEmpty};  ///< As Measure's.
  double w{0.0};                                ///< As Measure's.
  double log_w{0.0};                            ///< As Measure's.
  /// Of the triangle's diagonal, which bounds the singular values within small factors.
  int rank{0};
};

/// w of J where no singular value is left out, that is where task_dimension does not cap
/// s = min(rows, columns): so it is for J_v (k×6) and J_r (6×n). The product of the moduli of the diagonal of
/// a pivoted QR decomposition is that of the singular values, as exactly, at a fifth of MeasureOf()'s time; so is
/// that of the pivots of a square matrix, or of what the rows of a wide one add to the span of those before: they
/// are used where they leave no doubt of the rank.
/// Real-time safe.
[[nodiscard]] Volume VolumeOf(const JacobianRef& J,
                              double rank_tolerance = kRankTolerance) noexcept;

/// The s largest singular triplets of one Jacobian, J = Σ σ_i u_i v_iᵀ.
struct SingularSystem {
  Measure measure;  ///< The values σ_i, largest first, and what follows from them.
  /// rows×s; column i is σ_i u_i: the axes of the ellipsoid {J x : |x| <= 1} (paper, eqs. 7, 22). The
  /// image of a joint motion of unit speed, in feature units.
  TaskJacobian axes;
  /// columns×s, orthonormal; column i is v_i: the motion that axis i is the image of. Where σ_i is 0 to
  /// rounding, still a direction that J maps to 0.
  TaskJacobian directions;
};

/// Singular values, axes and directions. Empty matrices where the status is not kOk. Real-time safe.
[[nodiscard]] SingularSystem Decompose(const JacobianRef& J, int task_dimension = kTaskDimension,
                                       double rank_tolerance = kRankTolerance) noexcept;

/// The singular vectors on the side where J has fewer rows or columns: v_i, or u_i where J is wide. Real-time
/// safe.
[[nodiscard]] TaskJacobian VectorsOf(const SingularSystem& system) noexcept;

/// The same as Decompose(J), to rounding, faster where the vectors of a similar matrix are known: those of the
/// period before.
/// @param vectors  VectorsOf() that matrix' system. Any matrix will do: what does not help is not used.
/// Real-time safe.
[[nodiscard]] SingularSystem DecomposeNear(const JacobianRef& J,
                                           const TaskJacobian& vectors) noexcept;

/// What a control period measures of J_c = J_v J_r.
struct CompositeSystem {
  SingularSystem system;  ///< Of J_c.
  Volume arm;             ///< Of J_r.
  TaskJacobian earlier;   ///< The singular vectors of the period before.
};

/// Decompose(J_c) and VolumeOf(J_r), to rounding, faster where the system of the period before is known: the search
/// starts where its vectors would be if they went on as they went. Of an arm with more joints than the task has
/// dimensions J_c is decomposed in an orthonormal basis of the joint motions that move E, which tells the volume
/// of J_r as well.
/// @param composite  In: of the period before; any will do, what does not help is not used. Out: of this one.
/// @pre J_c = J_v J_r.
/// Real-time safe.
void DecomposeComposite(const FeatureJacobian& J_v, const ArmJacobian& J_r, const TaskJacobian& J_c,
                        CompositeSystem* composite) noexcept;

/// A pseudo-inverse, or a matrix of an ellipsoid.
using PseudoInverseMatrix =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMaxRows, kMaxRows>;
/// Moore-Penrose inverse J^+ (columns×rows) over the singular values that count for the rank. Real-time
/// safe.
[[nodiscard]] PseudoInverseMatrix PseudoInverse(const SingularSystem& system) noexcept;

/// (J Jᵀ)^+ (rows×rows): the ellipsoid is {y in range(J) : yᵀ (J Jᵀ)^+ y <= 1} (docs/paper.md, eqs. 7
/// and 22). Real-time safe.
[[nodiscard]] PseudoInverseMatrix EllipsoidMatrix(const SingularSystem& system) noexcept;

/// Volume of the ellipsoid in its s dimensions: π^(s/2) / Γ(s/2 + 1) · w. Real-time safe.
[[nodiscard]] double EllipsoidVolume(const Measure& measure) noexcept;

/// What became of a gradient.
enum class GradientStatus : int {
  kOk = 0,
  kNotMeasured = 1,  ///< The measure's own status is not kOk.
  kSingular = 2,     ///< rank < s: w is 0 with a kink, log w has no limit there.
};

/// As programs print it: "OK", "NOT_MEASURED", "SINGULAR".
[[nodiscard]] const char* Name(GradientStatus status) noexcept;

/// ∂(log w)/∂J; with the chain rule over what moves J, the gradient of log w, and w times it that of w.
struct LogGradient {
  /// Whether there is a gradient, or why not.
  GradientStatus status{GradientStatus::kNotMeasured};
  TaskJacobian by_J;  ///< rows×columns: Σ u_i v_iᵀ / σ_i over the s values. 0×0 where not kOk.
};

/// @pre where more than s singular values are there, σ_s > σ_(s+1): so it is for every J whose rank the
///   task dimension caps.
/// Real-time safe.
[[nodiscard]] LogGradient GradientOfLog(const SingularSystem& system) noexcept;

/// Bounds of |Δr| / |Δv|, Δr = J^+ Δv the motion computed from an error Δv of the features (paper,
/// eq. 12).
struct ErrorBounds {
  /// 1/σ_1. For k > m it holds for Δv in range(J): the rest of Δv moves nothing.
  double lower{0.0};
  /// 1/σ_s; inf when rank < s. For k < m it holds for the least-norm Δr alone.
  double upper{0.0};
  bool lower_needs_range{false};         ///< rows > columns.
  bool upper_needs_minimum_norm{false};  ///< rows < columns.
};

/// @param rows, columns  Size of the Jacobian that was measured.
/// Both bounds are inf where the status is not kOk or J is 0. Real-time safe.
[[nodiscard]] ErrorBounds BoundErrors(const Measure& measure, int rows, int columns) noexcept;

/// How much of w_v and w_r the composite keeps.
struct Coupling {
  /// w_c / (w_v w_r). 1 whenever m <= min(k, n). For k = n <= m it is the product of the cosines of the
  /// principal angles between what the features see (row space of J_v) and what the arm can do (column
  /// space of J_r). Elsewhere it has the unit of left-over singular values and may exceed 1.
  double ratio{0.0};
  /// w_c / (product over its s values of σ_i(J_v) σ_i(J_r)): at most 1 (Horn), for every k, m and n.
  double horn{0.0};
};

/// Both factors are 0 where w_c is 0; ratio is 0 where w_v or w_r is. Real-time safe.
[[nodiscard]] Coupling CouplingOf(const Measure& view, const Measure& arm,
                                  const Measure& composite) noexcept;

/// Jacobian of the whitened features: C^(-1/2) J, with C = F Fᵀ the covariance of the features' errors
/// and C^(-1/2) = F^-1. In its terms w_v of k >= m features is 1/sqrt(det Cov) of the computed twist:
/// the D-criterion. Rows may then mix pixels, radians and areas.
///
/// @param covariance  k×k, symmetric.
/// @return false, and *J as it was, when sizes differ or the covariance is not positive definite.
/// Real-time safe.
[[nodiscard]] bool Whiten(const JacobianRef& covariance, TaskJacobian* J) noexcept;

/// Characteristic length ℓ [m] of an arm's motion: ratio of the Frobenius norms of the translation and
/// the rotation rows of J_r; 1 where either is 0. With it a metre and a radian weigh alike.
/// Real-time safe.
[[nodiscard]] double CharacteristicLength(const ArmJacobian& J_r) noexcept;

/// J_r and J_v for twists (v, ℓ ω), all in m/s. J_c does not change. Real-time safe.
/// @pre length > 0.
[[nodiscard]] ArmJacobian ScaleTwistOfArm(const ArmJacobian& J_r, double length) noexcept;
/// The same for an image Jacobian: its rotational columns in metres of `length` [m].
[[nodiscard]] FeatureJacobian ScaleTwistOfImage(const FeatureJacobian& J_v, double length) noexcept;

/// J with column j times scale(j): with ℓ [m] for prismatic joints and 1 for revolute ones, all columns
/// are per radian. Real-time safe.
/// @pre scale.size() == J.cols().
[[nodiscard]] TaskJacobian ScaleJoints(const TaskJacobian& J, const JointVector& scale) noexcept;

/// ∂P/∂q of a point fixed to the end effector, from J_r and the vector from E's origin to P in world
/// axes [m]. Real-time safe.
[[nodiscard]] PointJacobian PointJacobianOf(const ArmJacobian& J_r,
                                            const Eigen::Vector3d& p_EP_W) noexcept;

/// J_r v_i for every direction v_i of J_c: the twists of E, in world axes, that they stand for (6×s, a unit of joint
/// motion each). What the measures of points of the end effector share. Real-time safe.
/// @pre J_r has as many columns as J_c, at least one.
[[nodiscard]] ArmJacobian TwistsOf(const SingularSystem& composite,
                                   const ArmJacobian& J_r) noexcept;

/// Finds the cause of a low w_c before a camera moves (docs/paper.md): what could any view see? All that a
/// camera has to go by is how the joints move the points, so the arm is the cause
/// - when the points together do not move in as many directions as J_c has singular values: w_c is 0 for
///   every camera;
/// - when the joint motion v_s that the features see worst hardly moves the points: by less than 2 % of
///   what joint motions usually (root mean square) move them by.
/// Otherwise that motion does move them, and this view hides it.
///
/// @param composite   Decomposition of J_c.
/// @param points      ∂P_i/∂q of the points that the features are made of and that the joints move before
///                    the camera; of a carried camera, of points of the scene as if E carried them.
/// @param rows_needed Rows the task needs: min(rows of the full feature set, n, m).
/// @param low         Whether the measure that counts is below its threshold.
/// @return kFeatures when fewer rows than needed are there, J_c is empty or there are no points, whether
///   low or not: with fewer rows s is smaller and w_c says nothing of what is not seen.
/// @pre the points have as many columns as J_c.
/// Real-time safe.
[[nodiscard]] LowCause DiagnoseLowMeasure(const SingularSystem& composite,
                                          const std::vector<PointJacobian>& points, int rows_needed,
                                          bool low) noexcept;

/// The same for points fixed to the end effector, whose Jacobians share J_r: faster.
/// @param arm     VolumeOf(J_r).
/// @param twists  TwistsOf(composite, J_r).
/// @param p_EP_W  From E's origin to each point, in world axes [m].
[[nodiscard]] LowCause DiagnoseLowMeasure(const SingularSystem& composite, const Volume& arm,
                                          const ArmJacobian& J_r, const ArmJacobian& twists,
                                          const std::vector<Eigen::Vector3d>& p_EP_W,
                                          int rows_needed, bool low) noexcept;

/// Worst motion of any of the points that a feature error of one pixel (norm over all rows) may hide:
/// max over points i and joint motions with |J_c δq| <= 1 of |A_i δq| [mm/px].
///
/// @param composite  Decomposition of J_c, rows in pixels.
/// @param points     A_i = ∂P_i/∂q.
/// @return inf when a motion that J_c does not see at all moves a point (J_c is singular or has too few
///   rows), or J_c is empty. 0 when there are no points.
/// Real-time safe.
[[nodiscard]] double WorstMillimetresPerPixel(const SingularSystem& composite,
                                              const std::vector<PointJacobian>& points) noexcept;

/// The same for points fixed to the end effector, whose Jacobians share J_r: faster.
/// @param twists  TwistsOf(composite, J_r).
/// @param p_EP_W  From E's origin to each point, in world axes [m].
[[nodiscard]] double WorstMillimetresPerPixel(const SingularSystem& composite,
                                              const ArmJacobian& J_r, const ArmJacobian& twists,
                                              const std::vector<Eigen::Vector3d>& p_EP_W) noexcept;

}  // namespace vantage
