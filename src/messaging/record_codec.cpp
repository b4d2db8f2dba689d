#include <vantage_msgs/servo_inputs_t.hpp>
#include <vantage_msgs/servo_setup_t.hpp>

#include "vantage/math/spatial.h"
#include "vantage/messaging/codec.h"
#include "wire.h"

namespace vantage {
namespace {

constexpr int kMaxRecordPeriods = 1000;  // In one message; a second's worth.

std::int64_t ToNanoseconds(Time time) noexcept {
  return time.time_since_epoch().count();
}

Time FromNanoseconds(std::int64_t ns) noexcept {
  return Time(Duration(ns));
}

Eigen::Isometry3d FromWire(const vantage_msgs::servo_pose_t& wire) noexcept {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) X(row, column) = wire.X_WC[row][column];
  }
  return X;
}

void CheckPose(const vantage_msgs::servo_pose_t& wire, Checks* checks) noexcept {
  checks->Magnitude(&wire.X_WC[0][0], 12)
      .Require(IsPose(FromWire(wire)), Refusal::kOutOfRange)
      .Require(wire.time_ns >= 0, Refusal::kBadTime);
}

void CheckImage(const vantage_msgs::servo_image_t& wire, Checks* checks) noexcept {
  checks->Require(wire.num_markers <= kMaxMarkers, Refusal::kLimit);
  if (checks->failed()) return;
  CheckPose(wire.exposure, checks);
  checks->Magnitude(wire.u.data(), wire.num_markers).Magnitude(wire.v.data(), wire.num_markers);
  for (const std::int32_t valid : wire.valid) checks->UpTo(1, valid);
  checks->Require(wire.sent_ns >= 0, Refusal::kBadTime);
}

void CheckPeriod(const vantage_msgs::servo_period_t& wire, Checks* checks) noexcept {
  checks->Require(wire.num_joints <= kMaxJoints && wire.num_poses <= 1 && wire.num_images <= 1,
                  Refusal::kLimit);
  if (checks->failed()) return;
  checks->Magnitude(wire.position.data(), wire.num_joints)
      .Magnitude(wire.velocity.data(), wire.num_joints)
      .UpTo(1, wire.enabled)
      .NotNegative({wire.seq, wire.camera_step, wire.lateness_ns, wire.execution_ns})
      .Require(wire.time_ns >= 0 && wire.joints_ns >= 0, Refusal::kBadTime);
  for (const auto& pose : wire.pose) CheckPose(pose, checks);
  for (const auto& image : wire.image) CheckImage(image, checks);
}

void ToWire(Time time, const Eigen::Isometry3d& X, vantage_msgs::servo_pose_t* wire) noexcept {
  wire->time_ns = ToNanoseconds(time);
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) wire->X_WC[row][column] = X(row, column);
  }
}

vantage_msgs::servo_image_t ToWire(const ImageFeatures& features) {
  vantage_msgs::servo_image_t wire;
  wire.sent_ns = ToNanoseconds(features.stamp);
  ToWire(features.exposure, features.X_WC, &wire.exposure);
  wire.num_markers = features.count;
  for (int i = 0; i < features.count; ++i) {
    const MarkerMeasurement& marker = features.markers[i];
    wire.id.push_back(marker.id);
    wire.u.push_back(marker.pixel.x());
    wire.v.push_back(marker.pixel.y());
    wire.valid.push_back(marker.valid ? 1 : 0);
  }
  return wire;
}

void FromWire(const vantage_msgs::servo_image_t& wire, ImageFeatures* features) noexcept {
  features->stamp = FromNanoseconds(wire.sent_ns);
  features->exposure = FromNanoseconds(wire.exposure.time_ns);
  features->X_WC = FromWire(wire.exposure);
  features->count = wire.num_markers;
  for (int i = 0; i < wire.num_markers; ++i) {
    features->markers[i] = {wire.id[i], Eigen::Vector2d(wire.u[i], wire.v[i]), wire.valid[i] != 0};
  }
}

vantage_msgs::servo_period_t ToWire(const PeriodRecord& period) {
  const PeriodInputs& inputs = period.inputs;
  vantage_msgs::servo_period_t wire;
  wire.seq = period.seq;
  wire.time_ns = ToNanoseconds(inputs.now);
  wire.enabled = inputs.enabled ? 1 : 0;
  wire.camera_step = period.camera_step;
  wire.lateness_ns = period.lateness.count();
  wire.execution_ns = period.execution.count();
  wire.joints_ns = inputs.has_joints ? ToNanoseconds(inputs.joints.stamp) : 0;
  wire.num_joints = inputs.has_joints ? static_cast<std::int32_t>(inputs.joints.q.size()) : 0;
  if (inputs.has_joints) {
    wire.position.assign(inputs.joints.q.begin(), inputs.joints.q.end());
    wire.velocity.assign(inputs.joints.qdot.begin(), inputs.joints.qdot.end());
  }
  wire.num_poses = inputs.has_pose ? 1 : 0;
  if (inputs.has_pose) {
    wire.pose.emplace_back();
    ToWire(inputs.pose.stamp, inputs.pose.X_WC, &wire.pose.back());
  }
  wire.num_images = inputs.has_features ? 1 : 0;
  if (inputs.has_features) wire.image.push_back(ToWire(inputs.features));
  return wire;
}

void FromWire(const vantage_msgs::servo_period_t& wire, PeriodRecord* period) noexcept {
  PeriodInputs& inputs = period->inputs;
  period->seq = wire.seq;
  period->camera_step = wire.camera_step;
  period->lateness = Duration(wire.lateness_ns);
  period->execution = Duration(wire.execution_ns);
  inputs.now = FromNanoseconds(wire.time_ns);
  inputs.enabled = wire.enabled != 0;
  inputs.has_joints = wire.num_joints > 0;
  if (inputs.has_joints) {
    inputs.joints.stamp = FromNanoseconds(wire.joints_ns);
    inputs.joints.q = Eigen::Map<const Eigen::VectorXd>(wire.position.data(), wire.num_joints);
    inputs.joints.qdot = Eigen::Map<const Eigen::VectorXd>(wire.velocity.data(), wire.num_joints);
  }
  inputs.has_pose = wire.num_poses > 0;
  if (inputs.has_pose)
    inputs.pose = {FromNanoseconds(wire.pose[0].time_ns), FromWire(wire.pose[0])};
  inputs.has_features = wire.num_images > 0;
  if (inputs.has_features) FromWire(wire.image[0], &inputs.features);
}

}  // namespace

Refusal Decode(const void* data, std::size_t size, ServoRecord* out) noexcept {
  vantage_msgs::servo_inputs_t wire;
  const Refusal refusal = DecodeWire(data, size, kMaxRecordBytes, &wire);
  if (refusal != Refusal::kNone) return refusal;
  Checks checks;
  checks.Require(
      wire.num_periods <= kMaxRecordPeriods && wire.num_camera_steps <= kMaxRecordPeriods,
      Refusal::kLimit);
  if (checks.failed()) return checks.result();
  for (const auto& period : wire.periods) CheckPeriod(period, &checks);
  for (const auto& step : wire.camera_steps) {
    checks.NotNegative({step.step}).Require(step.snapshot_ns >= 0, Refusal::kBadTime);
    checks.Stamp(step.command_utime);
  }
  if (checks.NotNegative({wire.lost}).Stamp(wire.utime).Stamp(wire.start_utime).failed())
    return checks.result();
  out->stamp = FromMicroseconds(wire.utime);
  out->start = FromMicroseconds(wire.start_utime);
  out->lost = wire.lost;
  out->periods.resize(wire.periods.size());
  for (std::size_t i = 0; i < wire.periods.size(); ++i) FromWire(wire.periods[i], &out->periods[i]);
  out->camera_steps.clear();
  for (const auto& step : wire.camera_steps) {
    out->camera_steps.push_back(
        {step.step, FromNanoseconds(step.snapshot_ns), FromMicroseconds(step.command_utime)});
  }
  return Refusal::kNone;
}

Refusal Decode(const void* data, std::size_t size, ServoSetup* out) noexcept {
  vantage_msgs::servo_setup_t wire;
  const Refusal refusal = DecodeWire(data, size, kMaxRecordBytes, &wire);
  if (refusal != Refusal::kNone) return refusal;
  Checks checks;
  checks.UpTo(1, wire.active_camera).Stamp(wire.utime).Stamp(wire.start_utime);
  if (checks.failed()) return checks.result();
  out->stamp = FromMicroseconds(wire.utime);
  out->start = FromMicroseconds(wire.start_utime);
  out->program = std::move(wire.program);
  out->scenario_name = std::move(wire.scenario_name);
  out->scenario = std::move(wire.scenario);
  out->active_camera = wire.active_camera != 0;
  return Refusal::kNone;
}

void Encode(const ServoRecord& value, Bytes* out) {
  vantage_msgs::servo_inputs_t wire;
  wire.utime = ToMicroseconds(value.stamp);
  wire.start_utime = ToMicroseconds(value.start);
  wire.lost = value.lost;
  wire.num_periods = static_cast<std::int32_t>(value.periods.size());
  for (const PeriodRecord& period : value.periods) wire.periods.push_back(ToWire(period));
  wire.num_camera_steps = static_cast<std::int32_t>(value.camera_steps.size());
  for (const CameraStepRecord& step : value.camera_steps) {
    wire.camera_steps.emplace_back();
    wire.camera_steps.back().step = step.step;
    wire.camera_steps.back().snapshot_ns = ToNanoseconds(step.snapshot);
    wire.camera_steps.back().command_utime = ToMicroseconds(step.command);
  }
  EncodeWire(wire, out);
}

void Encode(const ServoSetup& value, Bytes* out) {
  vantage_msgs::servo_setup_t wire;
  wire.utime = ToMicroseconds(value.stamp);
  wire.start_utime = ToMicroseconds(value.start);
  wire.program = value.program;
  wire.scenario_name = value.scenario_name;
  wire.scenario = value.scenario;
  wire.active_camera = value.active_camera ? 1 : 0;
  EncodeWire(wire, out);
}

}  // namespace vantage
