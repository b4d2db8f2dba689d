#pragma once

#include <cmath>

#include <Eigen/Geometry>

#include "vantage/messaging/codec.h"
#include "vantage/messaging/panda.h"

/// @file
/// One value of each message type with every field set to something of its own.

namespace vantage::test {

inline Eigen::Isometry3d SamplePose() {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.translation() = Eigen::Vector3d(0.5, -1.25, 2.0);
  X.linear() =
      Eigen::AngleAxisd(1.1, Eigen::Vector3d(1.0, -2.0, 0.5).normalized()).toRotationMatrix();
  return X;
}

inline JointState SampleJointState() {
  JointState value;
  value.stamp = FromMicroseconds(1'234'567);
  value.q = JointVector::LinSpaced(6, -1.0, 1.0);
  value.qdot = JointVector::LinSpaced(6, 0.1, 0.6);
  return value;
}

inline JointCommand SampleJointCommand() {
  JointCommand value;
  value.stamp = FromMicroseconds(2'345'678);
  value.q = JointVector::LinSpaced(7, -2.0, 2.0);
  value.qdot = JointVector::LinSpaced(7, 0.2, 0.9);
  return value;
}

inline CameraPose SampleCameraPose() {
  return {FromMicroseconds(3'456'789), SamplePose()};
}

inline ImageFeatures SampleImageFeatures() {
  ImageFeatures value;
  value.stamp = FromMicroseconds(4'000'500);
  value.exposure = FromMicroseconds(4'000'000);
  value.X_WC = SamplePose();
  value.count = 5;
  for (int i = 0; i < value.count; ++i) {
    value.markers[i].id = 10 + i;
    value.markers[i].valid = i != 2;
    if (i != 2) value.markers[i].pixel = Eigen::Vector2d(100.25 + i, 200.5 - i);
  }
  return value;
}

inline ObservabilityReport SampleObservability() {
  ObservabilityReport value;
  value.stamp = FromMicroseconds(5'000'000);
  value.seq = 77;
  value.k = 8;
  value.n = 3;
  value.w_v = 1.5e17;
  value.w_r = 0.25;
  value.composite.sigma = Eigen::Vector3d(400.0, 200.0, 100.0);
  value.composite.w = 8e6;
  value.w_c = value.composite.w;
  value.composite.log_w = std::log(8e6);
  value.composite.sigma_min = 100.0;
  value.composite.condition = 4.0;
  value.composite.rank = 3;
  value.sigma_min_v = 12.0;
  value.sigma_min_r = 0.125;
  value.axes.resize(8, 3);
  for (int i = 0; i < 24; ++i) value.axes(i % 8, i / 8) = 10.0 * i - 100.0;
  value.mm_per_px = 7.5;
  value.threshold = 120.0;
  value.trigger_value = 200.0;
  value.trigger_measure = TriggerMeasure::kSigmaMin;
  value.triggered = true;
  value.cause = LowCause::kView;
  value.active_state = ActiveState::kMoving;
  value.active_reason = ActiveReason::kMarkerAtRisk;
  value.camera_moves = 4;
  return value;
}

inline ServoStatus SampleServoStatus() {
  ServoStatus value;
  value.stamp = FromMicroseconds(6'000'000);
  value.seq = 99;
  value.state = ServoState::kHolding;
  value.reason = HoldReason::kStaleFeatures;
  value.error_px = 3.5;
  value.markers_seen = 3;
  value.markers_needed = 4;
  value.loop_time_us = 6.25;
  value.loop_time_max_us = 31.5;
  value.loop_time_p50_us = 5.5;
  value.loop_time_p99_us = 7.25;
  value.loop_time_p999_us = 9.75;
  value.lateness_p999_us = 41.0;
  value.lateness_max_us = 55.5;
  value.deadline_misses = 1;
  value.refused_messages = 21;
  value.refused_by = {1, 2, 3, 4, 5, 6};
  value.dropped_messages = 3;
  value.stops = 5;
  value.stops_by[2] = 2;
  value.stops_by[7] = 3;
  value.calibration = {0.0031, 0.0073, -0.005, 0.0054, 0.0012};
  return value;
}

inline GroundTruth SampleGroundTruth() {
  GroundTruth value;
  value.stamp = FromMicroseconds(6'500'000);
  value.q = JointVector::LinSpaced(3, -0.5, 0.5);
  value.worst_error = 0.02;
  value.rms_error = 0.01;
  value.limit_violations = 2;
  return value;
}

inline CameraImage SampleCameraImage() {
  CameraImage value;
  value.stamp = FromMicroseconds(7'000'000);
  value.width = 5;
  value.height = 4;
  value.row_stride = 8;
  value.data.resize(32);
  for (int i = 0; i < 32; ++i) value.data[i] = static_cast<std::uint8_t>(7 * i);
  return value;
}

inline ServoRecord SampleServoRecord() {
  ServoRecord value;
  value.stamp = FromMicroseconds(8'000'000);
  value.start = FromMicroseconds(1'000'000);
  value.lost = 3;
  PeriodRecord period;
  period.seq = 41;
  period.camera_step = 7;
  period.lateness = Duration(12'345);
  period.execution = Duration(6'789);
  period.inputs.now = Time(Duration(7'900'000'123));
  value.periods.push_back(period);  // One that took nothing, and one that took all there is.
  period.seq = 42;
  period.inputs.enabled = false;
  period.inputs.has_joints = period.inputs.has_pose = period.inputs.has_features = true;
  period.inputs.joints = SampleJointState();
  period.inputs.joints.stamp = Time(Duration(7'899'999'001));
  period.inputs.pose = {Time(Duration(7'899'999'002)), SamplePose()};
  period.inputs.features = SampleImageFeatures();
  period.inputs.features.exposure = Time(Duration(3'999'999'999));
  value.periods.push_back(period);
  value.camera_steps.push_back({7, Time(Duration(7'890'000'001)), FromMicroseconds(7'891'000)});
  return value;
}

inline ServoSetup SampleServoSetup() {
  ServoSetup value;
  value.stamp = FromMicroseconds(9'000'000);
  value.start = FromMicroseconds(1'000'000);
  value.program = "vantage-servo 0.1.0";
  value.scenario_name = "some-scenario";
  value.scenario = "robot:\n  name: x\n";
  value.active_camera = false;
  return value;
}

inline PandaStatus SamplePandaStatus() {
  PandaStatus value;
  value.stamp = FromMicroseconds(1'000'000);
  value.q = JointVector::LinSpaced(7, -1.0, 1.0);
  value.qdot = JointVector::LinSpaced(7, 0.1, 0.7);
  value.mode = PandaMode::kMove;
  value.velocity_control = true;
  return value;
}

template <typename Value>
Bytes Encoded(const Value& value) {
  Bytes bytes;
  Encode(value, &bytes);
  return bytes;
}

}  // namespace vantage::test
