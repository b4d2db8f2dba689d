#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "vantage/camera/camera_rig.h"
#include "vantage/math/angles.h"
#include "vantage/observability/batch.h"
#include "vantage/plan/arm_motion.h"

/// @file
/// What a camera's place is worth (paper, eqs. 13 to 16 and 23, in the form of docs/placement.md) and what
/// it must keep, for many cameras at once.

namespace vantage {

/// Which Jacobian is measured along the motion.
enum class PlanQuantity {
  kComposite,    ///< J_c: w_c (eqs. 14, 16).
  kView,         ///< J_v: w_v (eq. 13).
  kWeightedSum,  ///< k_v w_v + k_r w_r (eq. 23), or k_v log w_v + k_r log w_r.
  kProduct,      ///< w_v w_r; the sum of the logarithms for kLogW.
};

/// Over the motion.
enum class PlanAggregate {
  kIntegral,  ///< Trapezoid rule over time.
  kWorst,     ///< The least value (minimax, eq. 16).
};

/// The motions of the end effector that J_v maps.
enum class ViewTask {
  kBody,   ///< Its twist, m = 6; lengths in m.
  kPlane,  ///< Translation along W's x and y, m = 2: the paper's planar arm.
  kSpace,  ///< Translation, m = 3.
};

/// What a placement makes great.
struct PlanObjective {
  PlanQuantity quantity{PlanQuantity::kComposite};    ///< Which Jacobian is measured.
  PlanAggregate aggregate{PlanAggregate::kIntegral};  ///< From that of each sample to one number.
  BatchMeasure measure{BatchMeasure::kW};  ///< Of one sample; kWeightedSum has kW and kLogW alone.
  ViewTask task{ViewTask::kBody};          ///< Of kView, kWeightedSum and kProduct.
  double k_v{1.0};                         ///< Weight of w_v in kWeightedSum; >= 0.
  double k_r{1.0};                         ///< Weight of w_r in kWeightedSum; >= 0.
};

/// What every view of the whole motion must keep.
struct PlanLimits {
  DepthLimits depth;                 ///< [m].
  std::optional<DepthLimits> focus;  ///< Depths at which the lens is sharp [m].
  /// Radius of the ball about each marker's centre that has to be in the field of view [m]; >= 0.
  double rim{0.0};
  double max_incidence{kPi};       ///< Between a marker's normal and the ray to it [rad]; pi: any.
  bool occlusion{true};            ///< Whether the arm's capsules hide markers.
  std::vector<BatchBox> boxes;     ///< Things that hide markers; at most 16.
  std::vector<BatchBox> keep_out;  ///< Where the camera's centre must not be.
  double clearance{0.0};           ///< Distance it keeps from those [m]; >= 0.
};

/// How well the camera will stand where it is placed: standard deviations along each axis.
struct PoseUncertainty {
  double position{0.0};  ///< [m].
  double rotation{0.0};  ///< [rad].
  /// The worst of the perturbed poses counts; false: their mean. All of them keep the limits.
  bool worst{false};

  [[nodiscard]] bool none() const noexcept { return position == 0.0 && rotation == 0.0; }
};

/// A camera to place: data.
struct PlacementProblem {
  CameraRig rig;        ///< Its axes' limits are the workspace.
  RigVector q_c_start;  ///< Where the camera stands now, within the limits.
  BatchLens lens;       ///< Intrinsics and field of view, image margin taken off.
  ArmMotion motion;     ///< What the camera is to see; one sample at least.
  /// In the world; to be seen throughout the motion as the arm's own are (goals, for instance). At most
  /// kMaxPoints together with the arm's.
  std::vector<PlacedMarker> scene_markers;
  std::vector<BatchRow> rows;   ///< Feature rows; empty: both coordinates of every marker.
  PlanObjective objective;      ///< What is to be great.
  PlanLimits limits;            ///< What every view along the motion must keep.
  PoseUncertainty uncertainty;  ///< How far off its place the camera may stand; none by default.
};

/// Limits, in the order of PlanMargins.
enum class PlanLimit : int { kNear = 0, kFar, kImage, kHidden, kFacing, kKeepOut };
/// Number of PlanLimit's values.
inline constexpr int kPlanLimits = 6;

/// How far inside each limit a view is, worst over motion and markers [m]: negative where it is broken.
/// See BatchMargins and IndexOf().
using PlanMargins = std::array<double, kPlanLimits>;

/// Where PlanMargins holds a limit's margin.
[[nodiscard]] constexpr std::size_t IndexOf(PlanLimit limit) noexcept {
  return static_cast<std::size_t>(limit);
}

/// Makes a limit's margin `value` [m] where that is less.
inline void Tighten(PlanLimit limit, double value, PlanMargins* margins) noexcept {
  double& margin = (*margins)[IndexOf(limit)];
  margin = std::min(margin, value);
}

/// By how much a camera is too near for least depth and field of view: stepping back along its optical axis
/// by so much keeps both [m]; not above 0: it keeps them where it is.
[[nodiscard]] inline double TooNear(const PlanMargins& margins) noexcept {
  return -std::min(margins[IndexOf(PlanLimit::kNear)], margins[IndexOf(PlanLimit::kImage)]);
}

/// Name as printed: "least depth", "field of view", ...
[[nodiscard]] const char* Name(PlanLimit limit) noexcept;

/// Margins of this size count as kept, per metre of PlacementModel::unit() [-].
inline constexpr double kMarginTolerance = 1e-9;

/// A problem, prepared. Constant; safe to share between threads.
class PlacementModel {
 public:
  /// Throws ConfigError when sizes or values do not fit.
  explicit PlacementModel(PlacementProblem problem);
  ~PlacementModel();
  PlacementModel(PlacementModel&&) noexcept;

  [[nodiscard]] const PlacementProblem& problem() const noexcept { return problem_; }
  [[nodiscard]] const BatchScene& scene() const noexcept { return scene_; }
  /// Every point that must be seen: the scene's own and those of the scene's markers.
  [[nodiscard]] const BatchScene& points() const noexcept { return points_ ? *points_ : scene_; }
  /// Point `j` of that at a sample: the arm's markers come first.
  [[nodiscard]] const PlacedMarker& marker(int sample, int j) const noexcept;
  [[nodiscard]] int markers() const noexcept;
  /// Null where nothing can hide a marker and every side of it will do.
  [[nodiscard]] const BatchObstacles* obstacles() const noexcept { return obstacles_.get(); }
  [[nodiscard]] const DepthLimits& depth() const noexcept { return depth_; }
  /// By how much the rim makes the field of view smaller, as a margin of PlanLimit::kImage [m].
  [[nodiscard]] double rim_margin() const noexcept { return rim_margin_; }
  /// Displacements of the camera, in its own frame, that each view must answer for; the first is none.
  [[nodiscard]] const std::vector<Eigen::Isometry3d>& offsets() const noexcept { return offsets_; }
  /// About the distance of the cameras to the points [m].
  [[nodiscard]] double unit() const noexcept { return unit_; }
  /// Middle of the points [m].
  [[nodiscard]] const Eigen::Vector3d& centre_W() const noexcept { return centre_W_; }

  /// The objective that a score of the scene stands for (-cost of the paper; greater is better).
  [[nodiscard]] double Value(double score) const noexcept;
  /// Monotone in the score, of order 1: its logarithm, or the mean of the logarithms.
  [[nodiscard]] double Merit(double score) const noexcept;
  /// Every margin is kept.
  [[nodiscard]] bool Keeps(const PlanMargins& margins) const noexcept {
    double least = margins[0];
    for (const double margin : margins) least = std::min(least, margin);
    return least >= -kMarginTolerance * unit_;
  }
  /// Sum of what is broken, per unit().
  [[nodiscard]] double Violation(const PlanMargins& margins) const noexcept;
  /// "least depth" is the lens' where the focus is what binds.
  [[nodiscard]] std::string NameOf(PlanLimit limit) const;

  /// One sample of the motion by itself: its scene weighs 1.
  struct SampleView {
    BatchScene scene;                    ///< Points that are measured, at that sample alone.
    std::unique_ptr<BatchScene> points;  ///< Null: those of the scene.
  };
  /// Made when first asked for.
  [[nodiscard]] const std::vector<SampleView>& sample_views() const;
  /// What can hide a marker at each sample; empty where nothing can. Made when first asked for, which takes a
  /// small part of the time that sample_views() take.
  [[nodiscard]] const std::vector<BatchObstacles>& sample_obstacles() const;

 private:
  PlacementProblem problem_;
  DepthLimits depth_;
  std::vector<Eigen::Isometry3d> offsets_;
  double unit_{1.0};
  Eigen::Vector3d centre_W_{Eigen::Vector3d::Zero()};
  double factor_{1.0}, constant_{0.0}, rim_margin_{0.0};
  BatchScene scene_;
  std::unique_ptr<BatchScene> points_;
  std::unique_ptr<BatchObstacles> obstacles_;
  struct Lazy;
  std::unique_ptr<Lazy> lazy_;
};

/// Distance of a point to a box, negative inside [m].
[[nodiscard]] double DistanceToBox(const BatchBox& box, const Eigen::Vector3d& p_W) noexcept;

/// Scores many cameras of one problem. Keeps its storage; one thread at a time.
class CameraScorer {
 public:
  /// Scores cameras by a model, which must outlive it.
  explicit CameraScorer(const PlacementModel& model) : model_(model) {}

  /// The cameras that the next calls are about.
  void Load(const std::vector<Eigen::Isometry3d>& X_WC);

  /// Near, far, field of view and keep-out boxes; the rest is left as it is.
  void Frustum(BatchPrecision precision, std::vector<PlanMargins>* margins);
  /// Occlusion and facing.
  void Obstacles(BatchPrecision precision, std::vector<PlanMargins>* margins);
  /// Scores of the scene, see PlacementModel::Value().
  void Scores(BatchPrecision precision, std::vector<double>* scores);

  /// Jacobians measured so far.
  [[nodiscard]] std::int64_t evaluations() const noexcept { return evaluations_; }

 private:
  const PlacementModel& model_;
  BatchEvaluator evaluator_;
  BatchCameras cameras_;
  std::vector<Eigen::Vector3d> p_WC_;
  int count_{0};
  BatchMargins batch_margins_;
  BatchScores batch_scores_;
  std::int64_t evaluations_{0};
};

}  // namespace vantage
