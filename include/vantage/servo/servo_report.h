#pragma once

#include <array>
#include <cstdint>
#include <string>

#include <Eigen/Core>

#include "vantage/active/active_camera.h"
#include "vantage/math/sizes.h"
#include "vantage/math/time.h"
#include "vantage/observability/measures.h"

/// @file
/// What a servo says of itself: the content of OBSERVABILITY and SERVO_STATUS.

namespace vantage {

/// States of a servo.
enum class ServoState : int {
  kIdle = 0,           ///< Not started, or stopped by the operator.
  kAcquiring = 1,      ///< Waits for a first complete set of inputs.
  kServoing = 2,       ///< Moves the arm towards the goal.
  kRepositioning = 3,  ///< As kServoing, while the camera moves to a better view.
  kHolding = 4,        ///< At rest or coming to rest for the named reason; resumes by itself.
  kConverged = 5,      ///< Error below the tolerance for the settling time.
  kFault = 6,          ///< At rest; ends only when the operator stops it: see Servo::SetEnabled().
};

/// Why a servo holds, or why it stopped.
enum class HoldReason : int {
  kNone = 0,
  kNoJointState = 1,     ///< None yet.
  kStaleJointState = 2,  ///< Older than its limit.
  kNoCameraPose = 3,
  kStaleCameraPose = 4,
  kNoFeatures = 5,  ///< No image yet.
  kStaleFeatures = 6,
  kTooFewFeatures = 7,     ///< Fewer rows seen than the task needs.
  kNotFinite = 8,          ///< A NaN or infinity in an input or a result.
  kPointBehindCamera = 9,  ///< By the model a marker or its goal is not in front of the camera.
  kArmSingular = 10,       ///< w_r ~ 0 and no way on.
  kJointLimit = 11,        ///< A joint is at its limit and the task wants to go beyond.
  kOperator = 12,          ///< Told to stop.
  kArmNotFollowing = 13,   ///< The arm is far from where it was told to be: a fault.
};

/// How many there are.
inline constexpr int kNumHoldReasons = static_cast<int>(HoldReason::kArmNotFollowing) + 1;

/// Why a message from outside was not used.
enum class InputFault : int {
  kMalformed = 0,   ///< Not a message of its type.
  kWrongSize = 1,   ///< More or fewer joints, markers or rows than fit.
  kNotFinite = 2,   ///< A NaN or an infinity.
  kOutOfRange = 3,  ///< A value that cannot be: a rotation that is none, a time before any.
  kReordered = 4,   ///< Not newer than the one before it: late, twice or frozen.
  kFuture = 5,      ///< Stamped later than now: another clock.
};
/// How many there are.
inline constexpr int kNumInputFaults = static_cast<int>(InputFault::kFuture) + 1;

/// Names as printed and logged: "SERVOING", "STALE_JOINT_STATE", ...
[[nodiscard]] const char* Name(ServoState state) noexcept;
[[nodiscard]] const char* Name(HoldReason reason) noexcept;
[[nodiscard]] const char* Name(InputFault fault) noexcept;  ///< "MALFORMED", "WRONG_SIZE", ...

/// Live observability: content of the OBSERVABILITY channel.
struct ObservabilityReport {
  Time stamp{};         ///< When it was measured: `now` of the period.
  std::int64_t seq{0};  ///< Control periods since the start.
  int k{0};             ///< Feature rows in use.
  int m{6};             ///< Dimension of the task.
  int n{0};             ///< Joints of the arm.
  double w_v{0.0};      ///< Observability, of J_v [px per m or rad, to the power min(k, m)].
  double w_r{0.0};      ///< Manipulability, of J_r [m or rad per rad, to the power min(m, n)].
  double w_c{0.0};      ///< Composite, of J_c [px^s/rad^s].
  Measure composite;    ///< Singular values of J_c and what follows from them.
  /// Smallest singular value of J_v that counts [px per m or rad]. People alone read it and the next:
  /// the control period leaves them to CompleteReport().
  double sigma_min_v{0.0};
  double sigma_min_r{0.0};  ///< The same of J_r [m or rad per rad].
  /// Axes of the observability ellipsoid of J_c: column i is σ_i u_i in feature space [px/rad], k rows.
  TaskJacobian axes;
  double mm_per_px{0.0};  ///< Worst motion of a marker that one pixel of error may hide [mm/px].
  double threshold{0.0};  ///< Of the trigger, in the measure's unit.
  double trigger_value{0.0};  ///< The trigger's measure now, in its unit.
  TriggerMeasure trigger_measure{TriggerMeasure::kGeometricMean};  ///< Which one that is.
  bool triggered{false};                             ///< Below the threshold, hysteresis included.
  LowCause cause{LowCause::kNone};                   ///< Why w_c is low, when it is.
  ActiveState active_state{ActiveState::kWatching};  ///< Of the active camera's newest step.
  ActiveReason active_reason{ActiveReason::kNone};   ///< Why the camera was last asked to move.
  std::int64_t camera_moves{0};                      ///< Moves begun since the start.
};

/// Fills in what the control period has left out. For whoever publishes the report.
void CompleteReport(const FeatureJacobian& J_v, const ArmJacobian& J_r,
                    ObservabilityReport* report) noexcept;

/// What a servo found to be wrong with the calibration of camera and arm: see CalibrationEstimator.
struct CalibrationFound {
  double position{0.0};   ///< Of the camera on its rig: how far off [m].
  double rotation{0.0};   ///< The same, as an angle [rad].
  double focal{0.0};      ///< Of the focal length, as a share of it [-].
  double revolute{0.0};   ///< Of the revolute joint's zero that is off most [rad].
  double prismatic{0.0};  ///< Of the prismatic joint's zero that is off most [m].

  /// Nothing was found, or not looked for.
  [[nodiscard]] bool none() const noexcept {
    return position == 0.0 && rotation == 0.0 && focal == 0.0 && revolute == 0.0 &&
           prismatic == 0.0;
  }
};

/// For people: "camera off by 3.1 mm and 0.42 deg, focal length by +0.50 %, encoders by up to 0.31 deg".
[[nodiscard]] std::string Describe(const CalibrationFound& found);

/// Content of the SERVO_STATUS channel.
struct ServoStatus {
  Time stamp{};                          ///< When this was true: `now` of the period.
  std::int64_t seq{0};                   ///< Control periods since the start.
  ServoState state{ServoState::kIdle};   ///< What it is doing.
  HoldReason reason{HoldReason::kNone};  ///< Why it holds, or why it stopped.
  double error_px{0.0};                  ///< Root mean square error of the feature rows [px].
  int markers_seen{0};                   ///< Of those needed, in the last image.
  int markers_needed{0};          ///< End effector's markers that the features are computed from.
  double loop_time_us{0.0};       ///< Execution time of the last period [us].
  double loop_time_max_us{0.0};   ///< Largest since the start [us].
  double loop_time_p50_us{0.0};   ///< Half of the periods since the start took no longer [us].
  double loop_time_p99_us{0.0};   ///< 99 % of them took no longer [us].
  double loop_time_p999_us{0.0};  ///< 99.9 % of them took no longer [us].
  /// 99.9 % of them began no later than this after their deadline [us].
  double lateness_p999_us{0.0};
  double lateness_max_us{0.0};       ///< Largest delay of a begin after its deadline [us].
  std::int64_t deadline_misses{0};   ///< As LoopReport's, since the start.
  std::int64_t refused_messages{0};  ///< Messages from outside that failed a check.
  std::array<std::int64_t, kNumInputFaults> refused_by{};  ///< The same by InputFault.
  std::int64_t dropped_messages{0};  ///< Messages overwritten by newer ones before they were used.
  std::int64_t stops{0};             ///< Times the servo went from moving to HOLDING or FAULT.
  std::array<std::int64_t, kNumHoldReasons> stops_by{};  ///< The same by HoldReason.
  CalibrationFound calibration;                          ///< So far.

  /// Counts refused messages, of one reason, in refused_messages and refused_by.
  void CountRefused(InputFault fault, std::int64_t messages = 1) noexcept {
    refused_messages += messages;
    refused_by[static_cast<std::size_t>(fault)] += messages;
  }
  /// Counts a stop in stops and stops_by.
  void CountStop(HoldReason why) noexcept {
    ++stops;
    ++stops_by[static_cast<std::size_t>(why)];
  }
};

/// Refusals for people: "3 REORDERED, 1 NOT_FINITE"; "none".
[[nodiscard]] std::string DescribeRefused(const ServoStatus& status);
/// Stops for people: "2 TOO_FEW_FEATURES, 1 STALE_FEATURES"; "none".
[[nodiscard]] std::string DescribeStops(const ServoStatus& status);

}  // namespace vantage
