#pragma once

#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "vantage/camera/camera_model.h"
#include "vantage/math/spatial.h"
#include "vantage/observability/measures.h"

/// @file
/// Measures of one motion for many cameras at once: a motion is a list of samples, each with points and
/// their derivatives by the joints, which no camera is part of; a camera then costs projections and small
/// determinants alone. Runs on SIMD lanes, with the instruction set chosen at run time.

namespace vantage {

/// One image coordinate of one point: a feature row of the batch.
struct BatchRow {
  int point{0};  ///< Index in BatchSample::p_W.
  int axis{0};   ///< 0: x, 1: y.
};

/// One configuration of the motion.
struct BatchSample {
  std::vector<Eigen::Vector3d> p_W;  ///< Points [m].
  std::vector<PointJacobian> J_p_W;  ///< dP/dq of each, 3×n [m/rad or 1].
  double weight{1.0};                ///< Of the sample in the sum over the motion; >= 0.
};

/// How the points move.
enum class BatchBody {
  kRigid,  ///< As one body: J_c has rank 6 at most, s = min(k, n, 6).
  kFree,   ///< Each by itself: s = min(k, n).
};

/// What is computed of each J_c. Greater is better in each.
enum class BatchMeasure {
  kW,                 ///< w: product of the s largest singular values [px^s/rad^s].
  kLogW,              ///< log w; -inf for w = 0.
  kSigmaMin,          ///< σ_s [px/rad].
  kInverseCondition,  ///< σ_s / σ_1 [-].
  kNegativeTrace,     ///< -Σ 1/σ_i² [rad²/px²]; -inf for σ_s = 0.
};

/// Arithmetic of a batch.
enum class BatchPrecision {
  kDouble,  ///< w good to some 1e-13 · condition.
  kSingle,  ///< Half the time; to order cameras by.
};

/// Instruction sets that the kernels were built for, worst first.
enum class BatchIsa { kBaseline = 0, kAvx2, kAvx512 };

/// Those that this machine runs; the last is the best.
[[nodiscard]] std::vector<BatchIsa> AvailableIsas();
/// "SSE2" ("baseline" on other machines than x86-64), "AVX2" or "AVX-512".
[[nodiscard]] std::string Name(BatchIsa isa);

/// The motion, prepared for evaluation. Constant; safe to share between threads.
class BatchScene {
 public:
  /// @param samples  At least one; all with the same p points (1 to 16) and n joints (1 to 16).
  /// @param rows     Feature rows, at most 16, in the order of the points. Empty: both coordinates of
  ///   every point. (x1, y1, x2), (x1, y1) and, for rigid points, both coordinates of three or more with
  ///   n >= 6 have closed forms; the rest is computed by orthogonalisation.
  /// @param unit     Length that single precision is scaled by: about the distance of cameras to the
  ///   points [m]. 0: taken from the spread of the points.
  /// Throws ConfigError (key "batch...") when sizes do not agree or a value is not finite.
  explicit BatchScene(std::vector<BatchSample> samples, BatchBody body = BatchBody::kRigid,
                      std::vector<BatchRow> rows = {}, double unit = 0.0);
  ~BatchScene();
  BatchScene(BatchScene&&) noexcept;
  BatchScene& operator=(BatchScene&&) noexcept;

  [[nodiscard]] const std::vector<BatchSample>& samples() const noexcept;
  [[nodiscard]] const std::vector<BatchRow>& rows() const noexcept;
  [[nodiscard]] int joints() const noexcept;
  /// s: how many singular values count.
  [[nodiscard]] int rank() const noexcept;
  /// Sum of the samples' weights.
  [[nodiscard]] double total_weight() const noexcept;
  /// Which closed form serves it: "triple", "pair", "rigid six" or "generic".
  [[nodiscard]] std::string form() const;
  /// How many of the points bound depth and image coordinates from every view (those on the convex hull).
  [[nodiscard]] int hull_size() const noexcept;

  struct Data;
  [[nodiscard]] const Data& data() const noexcept { return *data_; }

 private:
  std::unique_ptr<const Data> data_;
};

/// Intrinsics that all cameras of a batch share. The zoom of each multiplies fx, fy and skew.
struct BatchLens {
  double fx{1.0};      ///< Focal length along u [px]; 1: features in normalised coordinates.
  double fy{1.0};      ///< Focal length along v [px]; 1 as fx.
  double skew{0.0};    ///< Shift of u by a unit of Y/Z [px].
  double x_min{-1e6};  ///< Left end of the field of view, X/Z at zoom 1 [-].
  double x_max{1e6};   ///< Right end, X/Z at zoom 1 [-].
  double y_min{-1e6};  ///< Upper end, Y/Z at zoom 1 [-].
  double y_max{1e6};   ///< Lower end, Y/Z at zoom 1 [-].

  /// The camera's matrix; the largest upright rectangle of undistorted coordinates inside the image
  /// less `margin` [px]. Throws ConfigError (key "batch.margin") when nothing is left of it.
  [[nodiscard]] static BatchLens FromCamera(const CameraModel& camera, double margin);
};

/// Demands on a view that concern points alone. Depths in [m].
struct DepthLimits {
  double min{1e-3};  ///< Least Z of a point in the camera frame [m].
  double max{1e6};   ///< Greatest Z of a point in the camera frame [m].
};

/// A capsule that may stand before a marker.
struct BatchCapsule {
  Eigen::Vector3d p_WA;  ///< One end of the axis [m].
  Eigen::Vector3d p_WB;  ///< The other end [m].
  double radius{0.0};    ///< [m]; > 0.
};

/// A box that stands in the world.
struct BatchBox {
  Eigen::Isometry3d X_WB{Eigen::Isometry3d::Identity()};  ///< Pose of its centre.
  Eigen::Vector3d half{Eigen::Vector3d::Zero()};          ///< Half edge lengths [m]; >= 0.
};

/// A marker at one sample: where sight to it starts, its normal, what may hide it.
struct BatchSight {
  Eigen::Vector3d p_W{Eigen::Vector3d::Zero()};        ///< Where rays to it start: SightOf() [m].
  Eigen::Vector3d normal_W{Eigen::Vector3d::UnitZ()};  ///< Unit normal of its face.
  std::vector<BatchCapsule> capsules;                  ///< That may hide it at this sample.
};

/// What may come between the cameras and the markers. Constant; safe to share between threads.
class BatchObstacles {
 public:
  /// @param sights         Of every marker at every sample.
  /// @param boxes          At most 16.
  /// @param max_incidence  Largest angle between a marker's normal and the ray to the camera [rad]; pi or
  ///   more: any side will do.
  /// @param unit           Length that single precision is scaled by [m]; > 0.
  /// Throws ConfigError (key "batch...") when there are too many boxes, or a radius or the unit is not
  /// positive.
  BatchObstacles(std::vector<BatchSight> sights, std::vector<BatchBox> boxes, double max_incidence,
                 double unit = 1.0);
  ~BatchObstacles();
  BatchObstacles(BatchObstacles&&) noexcept;
  BatchObstacles& operator=(BatchObstacles&&) noexcept;

  struct Data;
  [[nodiscard]] const Data& data() const noexcept { return *data_; }

 private:
  std::unique_ptr<const Data> data_;
};

/// Poses and zooms of many cameras, laid out for the kernels.
class BatchCameras {
 public:
  /// Space for `count` cameras. Contents are unspecified until set.
  void Resize(int count);
  [[nodiscard]] int size() const noexcept { return count_; }
  /// @pre 0 <= i < size(). Threads may set different cameras at once.
  void Set(int i, const Eigen::Isometry3d& X_WC, double zoom = 1.0) noexcept;
  /// As many cameras as there are sources, camera i turned and zoomed as camera source[i] of others; their
  /// centres are left to Move(). @pre source holds indices below from.size().
  void Turn(const BatchCameras& from, const std::vector<int>& source);
  /// Another centre [m] for a camera that was set; the rest stays.
  void Move(int i, const Eigen::Vector3d& p_WC) noexcept;

  /// One value of all cameras: of the rows of R_CW, one after the other, then the centre [m], then the zoom.
  /// @pre 0 <= f <= 12.
  [[nodiscard]] const double* field(int f) const noexcept { return data_.data() + f * stride_; }

 private:
  int count_{0};
  int stride_{0};
  std::vector<double> data_;
};

/// Results for cameras [first, first + count) of a batch; entry 0 belongs to the first. Only what was asked
/// for is written.
struct BatchScores {
  std::vector<double> sum;    ///< Σ weight · measure over the samples.
  std::vector<double> least;  ///< Least measure of all samples.
};

/// Margins of the constraints, worst over samples and points: negative where one is broken. Those of near,
/// far and image may be too small where they are positive, by as much as the motion bends between every
/// eighth sample (some mm); sign and negative values are exact.
struct BatchMargins {
  std::vector<double> near;  ///< Least depth less the lower limit [m].
  std::vector<double> far;   ///< Upper limit less the greatest depth [m].
  /// How much nearer the camera could come along its axis before a point leaves the field of view [m].
  std::vector<double> image;
  std::vector<double> occlusion;  ///< Distance of the rays to obstacles, exact near 0 [m].
  /// n·(ray) - cos(max) |ray|: how far inside the cone of admitted views the camera is [m].
  std::vector<double> facing;
};

/// Measures of every sample for one camera.
struct BatchProfile {
  std::vector<double> w;  ///< Of each sample.
  /// 6×N: derivatives of w by the camera's twist, (v, ω) in camera axes; empty unless asked for.
  Eigen::Matrix<double, 6, Eigen::Dynamic> gradient;
};

/// Runs the kernels of one instruction set. Stateless.
class BatchEvaluator {
 public:
  /// The best that this machine runs.
  BatchEvaluator();
  /// Throws ConfigError when this machine does not run `isa`.
  explicit BatchEvaluator(BatchIsa isa);

  [[nodiscard]] BatchIsa isa() const noexcept { return isa_; }
  /// Cameras that are evaluated at once.
  [[nodiscard]] int lanes(BatchPrecision precision) const noexcept;

  /// Sums and, when `with_least`, least values. A sample with a point of a row behind the camera counts
  /// as w = 0. kSigmaMin, kInverseCondition and kNegativeTrace take some 20 times the time of kW.
  void Score(const BatchScene& scene, const BatchCameras& cameras, int first, int count,
             const BatchLens& lens, BatchMeasure measure, BatchPrecision precision, bool with_least,
             BatchScores* scores) const;

  /// Writes near, far and image. `least_image` is what a marker's own size takes of the image's margin [m]: the
  /// margin is what is left of it, and as exact near 0 as without.
  void CheckFrustum(const BatchScene& scene, const BatchCameras& cameras, int first, int count,
                    const BatchLens& lens, const DepthLimits& limits, BatchPrecision precision,
                    BatchMargins* margins, double least_image = 0.0) const;

  /// Writes occlusion and facing.
  void CheckObstacles(const BatchObstacles& obstacles, const BatchCameras& cameras, int first,
                      int count, BatchPrecision precision, BatchMargins* margins) const;

  /// w of every sample for one camera, and its derivatives.
  void Profile(const BatchScene& scene, const Eigen::Isometry3d& X_WC, double zoom,
               const BatchLens& lens, bool with_gradient, BatchProfile* profile) const;

 private:
  BatchIsa isa_;
};

/// J_c (k×n) of one sample for one camera, by the plain formula: the ground that the kernels are tested
/// against. Rows of points that are not in front of the camera are NaN.
[[nodiscard]] Eigen::MatrixXd PlainJacobian(const BatchScene& scene, int sample,
                                            const Eigen::Isometry3d& X_WC, double zoom,
                                            const BatchLens& lens);

}  // namespace vantage
