#pragma once

#include <array>
#include <limits>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "vantage/active/active_camera.h"
#include "vantage/camera/camera_pose.h"
#include "vantage/features/marker.h"
#include "vantage/robot/joint_state.h"
#include "vantage/servo/calibration_estimator.h"
#include "vantage/servo/goal_estimator.h"
#include "vantage/servo/history.h"
#include "vantage/servo/image_track.h"
#include "vantage/servo/reference_path.h"
#include "vantage/servo/servo_options.h"
#include "vantage/servo/servo_report.h"

/// @file
/// One visual servo: measured features, joints and camera pose in, joint velocities and live
/// observability out. It knows neither transport nor simulator, and no clock but the time it is given.

namespace vantage {

/// Where the markers of the end effector have to go, as points in the world.
struct ServoGoal {
  /// One for each marker of the view [m]: known, or the prior of the goal's marker (without offset). The
  /// prior may be off as a whole; how the markers stand to one another is known.
  std::vector<Eigen::Vector3d> p_WG;
  /// Ids of the goal's own markers in the scene, one for each marker of the view; empty: the goal is
  /// known and not seen.
  std::vector<int> marker_ids;
  /// Goal points stand this far from the goal's markers, so that the arm does not hide them [m]; known.
  Eigen::Vector3d offset_W{Eigen::Vector3d::Zero()};
  double prior_sigma{0.05};    ///< Standard deviation of a prior [m]; > 0.
  double marker_radius{0.01};  ///< Of the goal's markers [m].
  /// Greatest speed of the goal's markers [m/s]; 0: they stand. Markers that move are followed by their
  /// image velocity.
  double max_speed{0.0};
  std::vector<Eigen::Vector3d>
      normals;  ///< Of the goal's markers in the world, unit; one for each id.
};

/// What the servo works on.
struct ServoTask {
  ViewModel view;  ///< Arm, camera, features and the end effector's markers.
  ServoGoal goal;  ///< Where those markers have to go.
};

/// Result of one control period.
struct ServoOutput {
  JointCommand command;  ///< Safe to send whatever the status says.
  ServoStatus status;    ///< Loop times and message counters are the caller's to fill in.
  /// CompleteReport() fills in the rest before it is published.
  ObservabilityReport observability;
  FeatureVector error;  ///< Image error e, row by row [px, rad, px²].
  /// k×6: image Jacobian by the twist of E in world axes [px per m or rad]. The observability was
  /// measured on it and the next; without rows or columns before the first time.
  FeatureJacobian J_v{0, 6};
  ArmJacobian J_r{6, 0};  ///< 6×n: that twist by the joints.
};

/// What the active camera needs of one period: everything in it is measured or estimated.
struct ServoSnapshot {
  bool valid{false};    ///< False until all inputs were seen once.
  ActiveInputs active;  ///< q_goal and goal_markers are the camera task's to fill in.
  std::array<Eigen::Vector3d, kMaxPoints> p_WG{};      ///< Estimated goal points [m].
  std::array<Eigen::Vector3d, kMaxPoints> p_marker{};  ///< Estimated markers of the goal [m].
  int goal_count{0};  ///< Entries of both arrays in use: one for each marker of the view.
};

/// How long before its period a servo is rehearsed: see Servo::Rehearse() and RunPeriodic(). A rehearsal with cold
/// caches takes less than half of it, and wakes on virtual machines come up to 0.14 ms late.
inline constexpr Duration kRehearsalLead = std::chrono::microseconds(200);

/// The servo. Set-up may throw; Accept() and Step() are real-time safe but for ViSP's interaction
/// matrices (10 allocations for each point and its goal).
class Servo {
 public:
  /// Throws ConfigError when options or sizes do not fit together.
  Servo(ServoTask task, const ServoOptions& options, const TriggerOptions& trigger);

  /// Inputs. Each is checked (sizes, finite, increasing stamps, not from the future); false, and
  /// nothing changed, when it is refused. Refusals are counted by reason in the status.
  bool Accept(const JointState& state, Time now) noexcept;
  bool Accept(const CameraPose& pose, Time now) noexcept;
  bool Accept(const ImageFeatures& features, Time now) noexcept;
  /// What the active camera last said.
  void Accept(const ActiveOutput& active) noexcept;
  /// The operator's wish: false brings the arm to rest, keeps it there and ends a FAULT; true lets it go on.
  void SetEnabled(bool enabled) noexcept { enabled_ = enabled; }

  /// One control period that ends in a command valid for options.period.
  [[nodiscard]] const ServoOutput& Step(Time now) noexcept;

  /// Of a copy of a servo: the period at `now` as if all its inputs came in again. What it reads and runs is in the
  /// caches afterwards, for the servo that it is a copy of. Nothing is done before the first complete set of inputs.
  void Rehearse(Time now) noexcept;

  [[nodiscard]] const ServoSnapshot& snapshot() const noexcept { return snapshot_; }

 private:
  struct CalibrationView {
    Eigen::Vector3d p_CM;
    Eigen::Matrix3d R_WC;
  };
  static constexpr int kHistory = 512;

  bool Refuse(InputFault fault) noexcept;
  [[nodiscard]] HoldReason CheckInputs(Time now) const noexcept;
  [[nodiscard]] Twist CameraTwist() const noexcept;
  void PredictState(Time now) noexcept;
  void UseImage() noexcept;
  Eigen::Isometry3d UpdateCalibration(const JointVector& q) noexcept;
  [[nodiscard]] bool NewView(std::size_t marker) noexcept;
  void PlaceGoalMarker(std::size_t marker) noexcept;
  void FitGoalLayout() noexcept;
  [[nodiscard]] double GoalSigma() const noexcept;
  [[nodiscard]] bool Carried(std::size_t marker) const noexcept;
  void UseGoalImage(std::size_t marker, const Eigen::Vector2d& measured, double time) noexcept;
  [[nodiscard]] HoldReason PredictRows(Time now) noexcept;
  [[nodiscard]] bool PredictPathRows() noexcept;
  [[nodiscard]] ServoLawOptions LawHere() const noexcept;
  [[nodiscard]] Eigen::Vector2d PathCorrection(const Eigen::Isometry3d& X_CW,
                                               std::size_t marker) const noexcept;
  [[nodiscard]] FeatureVector ErrorRate(const FeatureRows& target) noexcept;
  [[nodiscard]] JointVector SelfMotion() const noexcept;
  [[nodiscard]] double StartEffort(Time now) noexcept;
  [[nodiscard]] HoldReason Control(Time now) noexcept;
  void ReportMeasures() noexcept;
  void AverageError() noexcept;
  [[nodiscard]] double RemainingMillimetres(const SingularSystem& system,
                                            const ArmJacobian& twists) const noexcept;
  [[nodiscard]] int RowsNeeded() const noexcept;
  void JudgeProgress(Time now) noexcept;
  [[nodiscard]] bool ArmFollows() noexcept;
  [[nodiscard]] HoldReason WhyStanding() const noexcept;
  void Command(Time now, const JointVector& qdot) noexcept;

  ServoTask task_;
  ServoOptions options_;
  TriggerOptions trigger_;
  bool enabled_{true};
  bool fault_{false};         // latched until SetEnabled(false)
  std::vector<bool> needed_;  // markers that some feature uses
  int markers_needed_{0};
  std::vector<JointLimits> limits_;  // with the margin

  History<JointVector, kHistory> joints_;
  History<Eigen::Isometry3d, kHistory> poses_;
  Twist V_WC_C_{Twist::Zero()};  // of the camera, read off its newest poses
  // What is wrong with the calibration, and by it the camera and where the newest image was taken from.
  CalibrationEstimator calibration_;
  CameraModel camera_;
  Eigen::Isometry3d X_WC_exposure_{Eigen::Isometry3d::Identity()};
  // Where a marker was, and was seen from, when the calibration was last compared with it.
  std::array<std::optional<CalibrationView>, kMaxPoints> calibrated_at_{};
  ImageFeatures features_;
  bool has_features_{false};
  bool image_is_new_{false};
  // Per marker of the view: what was measured less the model's at the exposure it was last seen in, in
  // normalised coordinates.
  std::array<Eigen::Vector2d, kMaxPoints> offset_{};
  std::array<Eigen::Vector2d, kMaxPoints> seen_at_{};  // measured, normalised
  std::array<std::optional<Time>, kMaxPoints> last_seen_{};
  // Per marker of the goal: what was measured less its estimate, in normalised coordinates.
  std::array<Eigen::Vector2d, kMaxPoints> goal_offset_;
  std::array<ImageTrack, kMaxPoints> goal_tracks_;               // of goals that move
  Eigen::Isometry3d X_WC_image_{Eigen::Isometry3d::Identity()};  // of the image before
  int markers_lost_{0};  // needed, and not in the newest image
  std::array<std::optional<Time>, kMaxPoints> goal_last_seen_{};
  std::array<std::optional<Eigen::Isometry3d>, kMaxPoints> goal_seen_from_{};
  int goals_lost_{0};  // markers of the goal that were not seen lately
  std::vector<GoalPointEstimator> goal_;
  std::array<Eigen::Vector3d, kMaxPoints> p_WMarker_{};  // of the goal, as believed
  std::array<double, kMaxPoints> arrival_weight_{};      // of what the arm says of their depth
  std::array<double, kMaxPoints> layout_weight_{};       // of what their distances in the image say
  std::array<Eigen::Vector3d, kMaxPoints> p_WLayout_{};  // where those put them
  double layout_sigma_{std::numeric_limits<double>::infinity()};  // of their depth [m]
  ActiveOutput active_;

  Time last_step_{};

  // Of the period under way.
  bool camera_moves_{false};
  double dt_{0.0};      // since the last one, at most the nominal period [s]
  double late_{0.0};    // what was left of it [s]
  JointVector q_;       // now, as read
  JointVector q_true_;  // with the encoders' zeros corrected
  JointVector qdot_;    // last commanded
  std::optional<Time> moving_since_;
  Eigen::Isometry3d X_WC_measured_{Eigen::Isometry3d::Identity()};
  Eigen::Isometry3d X_WC_{Eigen::Isometry3d::Identity()};  // with its calibration corrected
  Kinematics kinematics_;
  PointViews current_, wanted_;
  PointViews wanted_soon_;  // goals that move, kSoon later
  FeatureRows current_rows_, goal_rows_, soon_rows_;
  std::vector<Eigen::Vector3d> p_EM_W_;  // from E's origin to each marker, in world axes
  CompositeSystem composite_;            // of this period, or of the one before
  PathReference reference_;
  Eigen::Isometry3d X_WE_goal_{Eigen::Isometry3d::Identity()};  // at active_.q_goal
  double remaining_mm_{0.0};  // worst marker's distance to its goal point, by the image
  PointViews ahead_;          // the reference's points
  FeatureRows path_rows_;     // of them

  // Convergence and stall.
  std::optional<Time> below_since_;  // error below the tolerance
  std::optional<Time> best_since_;   // smallest error so far
  double best_error_{0.0};
  double best_way_{0.0};  // least distance to the goal's joints so far
  bool stalled_{false};
  bool uncertified_{false};
  FeatureVector mean_error_;  // over the settling time, about
  bool arrived_{false};       // near its goal by the image, in a view that certifies it

  ServoOutput output_;
  ServoSnapshot snapshot_;
};

}  // namespace vantage
