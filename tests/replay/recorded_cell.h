#pragma once

#include <optional>
#include <string>
#include <vector>

#include "vantage/config/scenario.h"
#include "vantage/messaging/channels.h"
#include "vantage/messaging/event_log.h"
#include "vantage/robot/kinematics.h"
#include "vantage/servo/camera_task.h"
#include "vantage/servo/servo.h"

/// @file
/// A servo on a noise-free cell, recorded as vantage-servo records itself: what comes out is what a log
/// of a run holds.

namespace vantage::test {

/// Runs the scenario for `periods` control periods of 2 ms and gives the events of its log.
class RecordedCell {
 public:
  explicit RecordedCell(const std::string& scenario, Time start = FromMicroseconds(5'000'000))
      : scenario_(LoadScenario(scenario)),
        start_(start),
        now_(start),
        servo_(scenario_.task, scenario_.servo, scenario_.active.trigger),
        camera_task_(scenario_.task, scenario_.rig, scenario_.q_c_start, scenario_.active),
        q_(scenario_.sim.q_start),
        X_WC_(RigPose(scenario_.rig, scenario_.q_c_start)) {
    ServoSetup setup;
    setup.stamp = setup.start = start;
    setup.program = "test 1.0";
    setup.scenario_name = scenario_.name;
    setup.scenario = SelfContainedScenario(scenario).text;
    Log(kServoSetupChannel, setup);
  }

  std::vector<LoggedEvent> Run(int periods) {
    for (int i = 0; i < periods; ++i) Period(i);
    return events_;
  }

 private:
  void Period(int i) {
    now_ += std::chrono::milliseconds(2);
    PeriodRecord period;
    PeriodInputs& inputs = period.inputs;
    // A little after the grid, as threads are.
    inputs.now = now_ + Duration(137 * (i % 7));
    inputs.has_joints = i % 3 != 1;  // Now and then none has come in time.
    inputs.joints = {now_, q_, JointVector::Zero(q_.size())};
    inputs.has_pose = i % 4 == 0;
    inputs.pose = {now_, X_WC_};
    inputs.has_features = i % 8 == 0;
    if (inputs.has_features) inputs.features = Look();
    inputs.has_active = pending_ && i % 10 == 3;
    if (inputs.has_active) {
      inputs.active = *pending_;
      period.camera_step = record_steps_;
      pending_.reset();
    }
    const ServoOutput& output = RunPeriod(&servo_, inputs);
    period.seq = output.status.seq;
    q_ += 0.002 * output.command.qdot;
    Log(kJointCommandChannel, output.command);
    record_.periods.push_back(period);
    if (i % 10 == 1 && servo_.snapshot().valid) StepCamera();
    if (i % 10 != 9) return;
    Log(kObservabilityChannel, output.observability);
    Log(kServoStatusChannel, output.status);
    record_.stamp = now_;
    record_.start = start_;
    Log(kServoInputsChannel, record_);
    record_.periods.clear();
    record_.camera_steps.clear();
  }

  void StepCamera() {
    pending_ = camera_task_.Step(servo_.snapshot());
    const CameraPose command{now_, pending_->X_WC};
    record_.camera_steps.push_back({++record_steps_, servo_.snapshot().active.now, command.stamp});
    Log(kCameraPoseCommandChannel, command);
    X_WC_ = pending_->X_WC;
  }

  [[nodiscard]] ImageFeatures Look() const {
    ImageFeatures features;
    features.stamp = now_;
    features.exposure = now_;
    features.X_WC = X_WC_;
    const ViewModel& view = scenario_.task.view;
    const Eigen::Isometry3d X_CE = X_WC_.inverse() * EndEffectorPose(view.arm, q_);
    for (const Marker& marker : view.markers) {
      const auto image = Project(X_CE * marker.p);
      MarkerMeasurement& seen = features.markers[features.count++];
      seen.id = marker.id;
      seen.valid = image.has_value();
      if (image) {
        seen.pixel = {view.camera.u0 + view.camera.fx * image->n.x(),
                      view.camera.v0 + view.camera.fy * image->n.y()};
      }
    }
    return features;
  }

  template <typename Value>
  void Log(const char* channel, const Value& value) {
    LoggedEvent event{1'700'000'000'000'000 + ToMicroseconds(now_), channel, {}};
    Encode(value, &event.data);
    events_.push_back(std::move(event));
  }

  Scenario scenario_;
  Time start_, now_;
  Servo servo_;
  CameraTask camera_task_;
  JointVector q_;
  Eigen::Isometry3d X_WC_;
  std::optional<ActiveOutput> pending_;  // Of the camera, not yet taken.
  std::int64_t record_steps_{0};
  ServoRecord record_;
  std::vector<LoggedEvent> events_;
};

inline void WriteLog(const std::vector<LoggedEvent>& events, const std::string& path) {
  EventLogWriter log(path);
  for (const LoggedEvent& event : events) log.Write(event);
}

}  // namespace vantage::test
