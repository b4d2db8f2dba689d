#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "vantage/active/active_camera.h"
#include "vantage/camera/camera_pose.h"
#include "vantage/features/marker.h"
#include "vantage/math/time.h"
#include "vantage/robot/joint_state.h"
#include "vantage/servo/servo.h"

/// @file
/// The inputs of a servo as its periods took them: content of SERVO_INPUTS and SERVO_SETUP. A servo is a
/// function of these, whatever its threads did; so they are what a replay needs.

namespace vantage {

/// What one control period takes from its mailboxes.
struct PeriodInputs {
  Time now{};                ///< The servo's clock when the period began.
  bool enabled{true};        ///< False: the operator has told the servo to stop, for good.
  bool has_joints{false};    ///< `joints` is new; inputs that are not new have no meaning.
  bool has_pose{false};      ///< `pose` is new.
  bool has_features{false};  ///< `features` is new.
  bool has_active{false};    ///< `active` is new.
  JointState joints;         ///< Newest measured joints.
  CameraPose pose;           ///< Newest measured camera pose.
  ImageFeatures features;    ///< Of the newest image.
  ActiveOutput active;       ///< Of the newest step of the active camera.
};

/// One control period: hands the inputs to the servo and steps it. The one way a servo is run, on the
/// wall clock, on simulated time and in a replay. A servo that it has stopped stays stopped: whoever wants it to
/// move again, after a FAULT too, starts the program anew. Real-time safe as Servo is.
const ServoOutput& RunPeriod(Servo* servo, const PeriodInputs& inputs) noexcept;

/// One control period as recorded.
struct PeriodRecord {
  std::int64_t seq{0};  ///< Control periods since the start; this is one.
  /// Without `active`, which follows from camera_step.
  PeriodInputs inputs;
  std::int64_t camera_step{0};  ///< Step of the active camera that `active` came from; 0: none.
  Duration lateness{0};         ///< Begin of the period after its deadline.
  Duration execution{0};        ///< Execution time of the period before this one.
};

/// One step of the active camera as recorded.
struct CameraStepRecord {
  std::int64_t step{0};  ///< 1, 2, 3, ...
  Time snapshot{};       ///< `now` of the period whose snapshot it looked at.
  Time command{};        ///< Stamp of the pose command it gave; Time{}: none.
};

/// A piece of the record.
struct ServoRecord {
  Time stamp{};          ///< When it was sent.
  Time start{};          ///< When the servo was started, in whole microseconds.
  std::int64_t lost{0};  ///< Periods and steps that could not be recorded, since the start.
  std::vector<PeriodRecord> periods;           ///< Those since the piece before, in order.
  std::vector<CameraStepRecord> camera_steps;  ///< The same of the active camera.
};

/// What a servo was started with.
struct ServoSetup {
  Time stamp{};               ///< When it was sent.
  Time start{};               ///< When the servo was started.
  std::string program;        ///< Name and version.
  std::string scenario_name;  ///< Of the scenario.
  std::string scenario;       ///< As YAML, with the arm's description in it.
  bool active_camera{true};   ///< False: started with the camera held fixed.
};

}  // namespace vantage
