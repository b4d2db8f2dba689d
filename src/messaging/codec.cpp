#include "vantage/messaging/codec.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <iterator>
#include <limits>

#include <bot_core/image_t.hpp>
#include <bot_core/rigid_transform_t.hpp>
#include <vantage_msgs/image_features_t.hpp>
#include <vantage_msgs/joint_command_t.hpp>
#include <vantage_msgs/joint_state_t.hpp>
#include <vantage_msgs/observability_t.hpp>
#include <vantage_msgs/servo_status_t.hpp>
#include <vantage_msgs/sim_truth_t.hpp>

#include "wire.h"

namespace vantage {
namespace {

constexpr double kQuaternionTolerance = 1e-3;
constexpr int kMaxImageSide = 16384;  // [px]

void CheckPose(const double* position, const double* wxyz, Checks* checks) noexcept {
  checks->Magnitude(position, 3).Finite(wxyz, 4);
  const double norm =
      std::sqrt(wxyz[0] * wxyz[0] + wxyz[1] * wxyz[1] + wxyz[2] * wxyz[2] + wxyz[3] * wxyz[3]);
  checks->Require(std::abs(norm - 1.0) <= kQuaternionTolerance, Refusal::kOutOfRange);
}

Eigen::Isometry3d ToPose(const double* position, const double* wxyz) noexcept {
  const Eigen::Quaterniond rotation(wxyz[0], wxyz[1], wxyz[2], wxyz[3]);
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.translation() = Eigen::Vector3d(position[0], position[1], position[2]);
  X.linear() = rotation.normalized().toRotationMatrix();
  return X;
}

void FromPose(const Eigen::Isometry3d& X, double* position, double* wxyz) noexcept {
  const Eigen::Quaterniond rotation(X.linear());
  for (int i = 0; i < 3; ++i) position[i] = X.translation()[i];
  wxyz[0] = rotation.w();
  wxyz[1] = rotation.x();
  wxyz[2] = rotation.y();
  wxyz[3] = rotation.z();
}

// Of joint_state_t and joint_command_t, which differ in the order of their arrays alone.
template <typename Wire>
Refusal CheckJoints(const Wire& wire) noexcept {
  const int n = wire.num_joints;
  Checks checks;
  checks.Require(n >= 1 && n <= kMaxJoints, Refusal::kLimit);
  if (checks.failed()) return checks.result();
  checks.Magnitude(wire.position.data(), n).Magnitude(wire.velocity.data(), n).Stamp(wire.utime);
  return checks.result();
}

template <typename Wire, typename Value>
Refusal DecodeJoints(const void* data, std::size_t size, Value* out) noexcept {
  Wire wire;
  Refusal refusal = DecodeWire(data, size, kMaxStateBytes, &wire);
  if (refusal == Refusal::kNone) refusal = CheckJoints(wire);
  if (refusal != Refusal::kNone) return refusal;
  out->stamp = FromMicroseconds(wire.utime);
  out->q = Eigen::Map<const Eigen::VectorXd>(wire.position.data(), wire.num_joints);
  out->qdot = Eigen::Map<const Eigen::VectorXd>(wire.velocity.data(), wire.num_joints);
  return Refusal::kNone;
}

template <typename Wire, typename Value>
void EncodeJoints(const Value& value, Bytes* out) {
  assert(value.q.size() == value.qdot.size());
  Wire wire;
  wire.utime = ToMicroseconds(value.stamp);
  wire.num_joints = static_cast<std::int32_t>(value.q.size());
  wire.position.assign(value.q.begin(), value.q.end());
  wire.velocity.assign(value.qdot.begin(), value.qdot.end());
  EncodeWire(wire, out);
}

bool HasDuplicates(const std::vector<std::int32_t>& ids) noexcept {
  // At most kMaxMarkers of them: comparing all pairs needs no memory.
  for (std::size_t i = 0; i < ids.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (ids[i] == ids[j]) return true;
    }
  }
  return false;
}

Refusal CheckFeatures(const vantage_msgs::image_features_t& wire) noexcept {
  Checks checks;
  checks.Require(wire.num_markers <= kMaxMarkers, Refusal::kLimit);
  if (checks.failed()) return checks.result();
  CheckPose(wire.camera_position, wire.camera_orientation, &checks);
  for (int i = 0; i < wire.num_markers; ++i) {
    checks.UpTo(1, wire.valid[i]);
    if (wire.valid[i] != 0) checks.Magnitude(&wire.u[i], 1).Magnitude(&wire.v[i], 1);
  }
  checks.Require(!HasDuplicates(wire.id), Refusal::kOutOfRange);
  checks.Stamp(wire.utime).Stamp(wire.exposure_utime);
  return checks.Require(wire.exposure_utime <= wire.utime, Refusal::kBadTime).result();
}

Refusal CheckObservability(const vantage_msgs::observability_t& wire) noexcept {
  Checks checks;
  checks.Require(wire.k >= 0 && wire.k <= kMaxRows && wire.m >= 0 && wire.m <= 6 && wire.n >= 0 &&
                     wire.n <= kMaxJoints && wire.num_sigma <= kMaxRows &&
                     wire.num_axes <= kMaxJoints,
                 Refusal::kLimit);
  if (checks.failed()) return checks.result();
  checks.Finite({wire.w_v, wire.w_r, wire.w_c, wire.geometric_mean, wire.sigma_min_v,
                 wire.sigma_min_r, wire.sigma_min_c, wire.threshold, wire.trigger_value});
  // A singular J_c has log w = -inf and an infinite condition number, and hides any motion.
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  checks.Require(std::isfinite(wire.log_w_c) || wire.log_w_c == -kInfinity, Refusal::kNotFinite);
  checks.Require(std::isfinite(wire.condition) || wire.condition == kInfinity, Refusal::kNotFinite);
  checks.Require(std::isfinite(wire.mm_per_px) || wire.mm_per_px == kInfinity, Refusal::kNotFinite);
  // The logarithm of a number that a double can hold.
  checks.Require(wire.log_w_c <= std::log(std::numeric_limits<double>::max()),
                 Refusal::kOutOfRange);
  checks.Finite(wire.sigma.data(), wire.num_sigma);
  for (const std::vector<double>& axis : wire.axes) checks.Finite(axis.data(), wire.k);
  checks.UpTo(wire.num_sigma, wire.rank)
      .UpTo(static_cast<int>(TriggerMeasure::kInverseCondition), wire.trigger_measure)
      .UpTo(1, wire.triggered)
      .UpTo(static_cast<int>(LowCause::kFeatures), wire.cause)
      .UpTo(static_cast<int>(ActiveState::kDisabled), wire.active_state)
      .UpTo(static_cast<int>(ActiveReason::kStalled), wire.active_reason)
      .NotNegative({wire.seq, wire.camera_moves});
  return checks.Stamp(wire.utime).result();
}

// In the order of InputFault.
constexpr std::int64_t vantage_msgs::servo_status_t::*kRefusedBy[] = {
    &vantage_msgs::servo_status_t::refused_malformed,
    &vantage_msgs::servo_status_t::refused_wrong_size,
    &vantage_msgs::servo_status_t::refused_not_finite,
    &vantage_msgs::servo_status_t::refused_out_of_range,
    &vantage_msgs::servo_status_t::refused_reordered,
    &vantage_msgs::servo_status_t::refused_future,
};
static_assert(std::size(kRefusedBy) == kNumInputFaults);
static_assert(sizeof(vantage_msgs::servo_status_t::stops_by_reason) ==
              kNumHoldReasons * sizeof(std::int64_t));

Refusal CheckStatus(const vantage_msgs::servo_status_t& wire) noexcept {
  Checks checks;
  checks
      .Finite({wire.error_px, wire.loop_time_us, wire.loop_time_max_us, wire.loop_time_p50_us,
               wire.loop_time_p99_us, wire.loop_time_p999_us, wire.lateness_p999_us,
               wire.lateness_max_us, wire.calibration_position, wire.calibration_rotation,
               wire.calibration_focal, wire.calibration_revolute, wire.calibration_prismatic})
      .UpTo(static_cast<int>(ServoState::kFault), wire.state)
      .UpTo(static_cast<int>(HoldReason::kArmNotFollowing), wire.reason)
      .NotNegative({wire.seq, wire.markers_seen, wire.markers_needed, wire.deadline_misses,
                    wire.refused_messages, wire.dropped_messages, wire.stops});
  for (const auto member : kRefusedBy) checks.NotNegative({wire.*member});
  for (const std::int64_t stops : wire.stops_by_reason) checks.NotNegative({stops});
  return checks.Stamp(wire.utime).result();
}

// Bytes of a row of pixels; 0 for compressed formats.
std::int64_t RowBytes(std::int32_t pixelformat, std::int32_t width) noexcept {
  if (pixelformat == bot_core::image_t::PIXEL_FORMAT_GRAY) return width;
  if (pixelformat == bot_core::image_t::PIXEL_FORMAT_RGB) return 3 * std::int64_t{width};
  return 0;
}

Refusal CheckImage(const bot_core::image_t& wire) noexcept {
  Checks checks;
  checks.Require(wire.width >= 1 && wire.width <= kMaxImageSide && wire.height >= 1 &&
                     wire.height <= kMaxImageSide && wire.size >= 1,
                 Refusal::kLimit);
  if (checks.failed()) return checks.result();
  const std::int64_t row = RowBytes(wire.pixelformat, wire.width);
  if (row == 0) {
    checks.Require(wire.pixelformat == bot_core::image_t::PIXEL_FORMAT_MJPEG, Refusal::kOutOfRange);
  } else {
    // The last row need not be filled up to the stride.
    checks.Require(wire.row_stride >= row &&
                       std::int64_t{wire.row_stride} * (wire.height - 1) + row <= wire.size,
                   Refusal::kOutOfRange);
  }
  return checks.Stamp(wire.utime).result();
}

PixelFormat FromWire(std::int32_t pixelformat) noexcept {
  if (pixelformat == bot_core::image_t::PIXEL_FORMAT_GRAY) return PixelFormat::kGray;
  if (pixelformat == bot_core::image_t::PIXEL_FORMAT_RGB) return PixelFormat::kRgb;
  return PixelFormat::kJpeg;
}

std::int32_t ToWire(PixelFormat format) noexcept {
  switch (format) {
    case PixelFormat::kGray:
      return bot_core::image_t::PIXEL_FORMAT_GRAY;
    case PixelFormat::kRgb:
      return bot_core::image_t::PIXEL_FORMAT_RGB;
    case PixelFormat::kJpeg:
      break;
  }
  return bot_core::image_t::PIXEL_FORMAT_MJPEG;
}

}  // namespace

Refusal Decode(const void* data, std::size_t size, JointState* out) noexcept {
  return DecodeJoints<vantage_msgs::joint_state_t>(data, size, out);
}

Refusal Decode(const void* data, std::size_t size, JointCommand* out) noexcept {
  return DecodeJoints<vantage_msgs::joint_command_t>(data, size, out);
}

Refusal Decode(const void* data, std::size_t size, CameraPose* out) noexcept {
  bot_core::rigid_transform_t wire;
  const Refusal refusal = DecodeWire(data, size, kMaxStateBytes, &wire);
  if (refusal != Refusal::kNone) return refusal;
  Checks checks;
  CheckPose(wire.trans, wire.quat, &checks);
  if (checks.Stamp(wire.utime).failed()) return checks.result();
  out->stamp = FromMicroseconds(wire.utime);
  out->X_WC = ToPose(wire.trans, wire.quat);
  return Refusal::kNone;
}

Refusal Decode(const void* data, std::size_t size, ImageFeatures* out) noexcept {
  vantage_msgs::image_features_t wire;
  Refusal refusal = DecodeWire(data, size, kMaxStateBytes, &wire);
  if (refusal == Refusal::kNone) refusal = CheckFeatures(wire);
  if (refusal != Refusal::kNone) return refusal;
  out->stamp = FromMicroseconds(wire.utime);
  out->exposure = FromMicroseconds(wire.exposure_utime);
  out->X_WC = ToPose(wire.camera_position, wire.camera_orientation);
  out->count = wire.num_markers;
  for (int i = 0; i < out->count; ++i) {
    MarkerMeasurement& marker = out->markers[i];
    marker.id = wire.id[i];
    marker.valid = wire.valid[i] != 0;
    marker.pixel = marker.valid ? Eigen::Vector2d(wire.u[i], wire.v[i]) : Eigen::Vector2d::Zero();
  }
  return Refusal::kNone;
}

Refusal Decode(const void* data, std::size_t size, ObservabilityReport* out) noexcept {
  vantage_msgs::observability_t wire;
  Refusal refusal = DecodeWire(data, size, kMaxStateBytes, &wire);
  if (refusal == Refusal::kNone) refusal = CheckObservability(wire);
  if (refusal != Refusal::kNone) return refusal;
  out->stamp = FromMicroseconds(wire.utime);
  out->seq = wire.seq;
  out->k = wire.k;
  out->m = wire.m;
  out->n = wire.n;
  out->w_v = wire.w_v;
  out->w_r = wire.w_r;
  out->w_c = wire.w_c;
  out->composite.sigma = Eigen::Map<const Eigen::VectorXd>(wire.sigma.data(), wire.num_sigma);
  out->composite.w = wire.w_c;
  out->composite.log_w = wire.log_w_c;
  out->composite.sigma_min = wire.sigma_min_c;
  out->composite.condition = wire.condition;
  out->composite.rank = wire.rank;
  out->sigma_min_v = wire.sigma_min_v;
  out->sigma_min_r = wire.sigma_min_r;
  out->axes.resize(wire.num_axes > 0 ? wire.k : 0, wire.num_axes);
  for (int i = 0; i < wire.num_axes; ++i) {
    out->axes.col(i) = Eigen::Map<const Eigen::VectorXd>(wire.axes[i].data(), wire.k);
  }
  out->mm_per_px = wire.mm_per_px;
  out->threshold = wire.threshold;
  out->trigger_value = wire.trigger_value;
  out->trigger_measure = static_cast<TriggerMeasure>(wire.trigger_measure);
  out->triggered = wire.triggered != 0;
  out->cause = static_cast<LowCause>(wire.cause);
  out->active_state = static_cast<ActiveState>(wire.active_state);
  out->active_reason = static_cast<ActiveReason>(wire.active_reason);
  out->camera_moves = wire.camera_moves;
  return Refusal::kNone;
}

Refusal Decode(const void* data, std::size_t size, ServoStatus* out) noexcept {
  vantage_msgs::servo_status_t wire;
  Refusal refusal = DecodeWire(data, size, kMaxStateBytes, &wire);
  if (refusal == Refusal::kNone) refusal = CheckStatus(wire);
  if (refusal != Refusal::kNone) return refusal;
  out->stamp = FromMicroseconds(wire.utime);
  out->seq = wire.seq;
  out->state = static_cast<ServoState>(wire.state);
  out->reason = static_cast<HoldReason>(wire.reason);
  out->error_px = wire.error_px;
  out->markers_seen = wire.markers_seen;
  out->markers_needed = wire.markers_needed;
  out->loop_time_us = wire.loop_time_us;
  out->loop_time_max_us = wire.loop_time_max_us;
  out->loop_time_p50_us = wire.loop_time_p50_us;
  out->loop_time_p99_us = wire.loop_time_p99_us;
  out->loop_time_p999_us = wire.loop_time_p999_us;
  out->lateness_p999_us = wire.lateness_p999_us;
  out->lateness_max_us = wire.lateness_max_us;
  out->deadline_misses = wire.deadline_misses;
  out->refused_messages = wire.refused_messages;
  for (std::size_t i = 0; i < out->refused_by.size(); ++i) out->refused_by[i] = wire.*kRefusedBy[i];
  out->dropped_messages = wire.dropped_messages;
  out->stops = wire.stops;
  std::copy(std::begin(wire.stops_by_reason), std::end(wire.stops_by_reason),
            out->stops_by.begin());
  out->calibration = {wire.calibration_position, wire.calibration_rotation, wire.calibration_focal,
                      wire.calibration_revolute, wire.calibration_prismatic};
  return Refusal::kNone;
}

Refusal Decode(const void* data, std::size_t size, GroundTruth* out) noexcept {
  vantage_msgs::sim_truth_t wire;
  const Refusal refusal = DecodeWire(data, size, kMaxStateBytes, &wire);
  if (refusal != Refusal::kNone) return refusal;
  Checks checks;
  checks.Require(wire.num_joints >= 1 && wire.num_joints <= kMaxJoints, Refusal::kLimit);
  if (checks.failed()) return checks.result();
  checks.Magnitude(wire.position.data(), wire.num_joints)
      .Finite({wire.worst_error, wire.rms_error})
      .NotNegative({wire.limit_violations});
  if (checks.Stamp(wire.utime).failed()) return checks.result();
  out->stamp = FromMicroseconds(wire.utime);
  out->q = Eigen::Map<const Eigen::VectorXd>(wire.position.data(), wire.num_joints);
  out->worst_error = wire.worst_error;
  out->rms_error = wire.rms_error;
  out->limit_violations = wire.limit_violations;
  return Refusal::kNone;
}

Refusal Decode(const void* data, std::size_t size, CameraImage* out) noexcept {
  bot_core::image_t wire;
  Refusal refusal = DecodeWire(data, size, kMaxImageBytes, &wire);
  if (refusal == Refusal::kNone) refusal = CheckImage(wire);
  if (refusal != Refusal::kNone) return refusal;
  out->stamp = FromMicroseconds(wire.utime);
  out->width = wire.width;
  out->height = wire.height;
  out->format = FromWire(wire.pixelformat);
  out->row_stride = out->format == PixelFormat::kJpeg ? 0 : wire.row_stride;
  out->data = std::move(wire.data);
  return Refusal::kNone;
}

void Encode(const JointState& value, Bytes* out) {
  EncodeJoints<vantage_msgs::joint_state_t>(value, out);
}

void Encode(const JointCommand& value, Bytes* out) {
  EncodeJoints<vantage_msgs::joint_command_t>(value, out);
}

void Encode(const CameraPose& value, Bytes* out) {
  bot_core::rigid_transform_t wire;
  wire.utime = ToMicroseconds(value.stamp);
  FromPose(value.X_WC, wire.trans, wire.quat);
  EncodeWire(wire, out);
}

void Encode(const ImageFeatures& value, Bytes* out) {
  vantage_msgs::image_features_t wire;
  wire.utime = ToMicroseconds(value.stamp);
  wire.exposure_utime = ToMicroseconds(value.exposure);
  FromPose(value.X_WC, wire.camera_position, wire.camera_orientation);
  wire.num_markers = value.count;
  for (int i = 0; i < value.count; ++i) {
    const MarkerMeasurement& marker = value.markers[i];
    wire.id.push_back(marker.id);
    wire.u.push_back(marker.pixel.x());
    wire.v.push_back(marker.pixel.y());
    wire.valid.push_back(marker.valid ? 1 : 0);
  }
  EncodeWire(wire, out);
}

void Encode(const ObservabilityReport& value, Bytes* out) {
  assert(value.axes.cols() == 0 || value.axes.rows() == value.k);
  vantage_msgs::observability_t wire;
  wire.utime = ToMicroseconds(value.stamp);
  wire.seq = value.seq;
  wire.k = value.k;
  wire.m = value.m;
  wire.n = value.n;
  wire.w_v = value.w_v;
  wire.w_r = value.w_r;
  wire.w_c = value.w_c;
  wire.log_w_c = value.composite.log_w;
  wire.geometric_mean = value.composite.geometric_mean();
  wire.sigma_min_v = value.sigma_min_v;
  wire.sigma_min_r = value.sigma_min_r;
  wire.sigma_min_c = value.composite.sigma_min;
  wire.condition = value.composite.condition;
  wire.rank = value.composite.rank;
  wire.num_sigma = static_cast<std::int32_t>(value.composite.sigma.size());
  wire.sigma.assign(value.composite.sigma.begin(), value.composite.sigma.end());
  wire.num_axes = static_cast<std::int32_t>(value.axes.cols());
  for (int i = 0; i < wire.num_axes; ++i) {
    wire.axes.emplace_back(value.axes.col(i).begin(), value.axes.col(i).end());
  }
  wire.mm_per_px = value.mm_per_px;
  wire.threshold = value.threshold;
  wire.trigger_value = value.trigger_value;
  wire.trigger_measure = static_cast<std::int32_t>(value.trigger_measure);
  wire.triggered = value.triggered ? 1 : 0;
  wire.cause = static_cast<std::int32_t>(value.cause);
  wire.cause_name = Name(value.cause);
  wire.active_state = static_cast<std::int32_t>(value.active_state);
  wire.active_state_name = Name(value.active_state);
  wire.active_reason = static_cast<std::int32_t>(value.active_reason);
  wire.active_reason_name = Name(value.active_reason);
  wire.camera_moves = value.camera_moves;
  EncodeWire(wire, out);
}

void Encode(const ServoStatus& value, Bytes* out) {
  vantage_msgs::servo_status_t wire;
  wire.utime = ToMicroseconds(value.stamp);
  wire.seq = value.seq;
  wire.state = static_cast<std::int32_t>(value.state);
  wire.state_name = Name(value.state);
  wire.reason = static_cast<std::int32_t>(value.reason);
  wire.reason_name = Name(value.reason);
  wire.error_px = value.error_px;
  wire.markers_seen = value.markers_seen;
  wire.markers_needed = value.markers_needed;
  wire.loop_time_us = value.loop_time_us;
  wire.loop_time_max_us = value.loop_time_max_us;
  wire.loop_time_p50_us = value.loop_time_p50_us;
  wire.loop_time_p99_us = value.loop_time_p99_us;
  wire.loop_time_p999_us = value.loop_time_p999_us;
  wire.lateness_p999_us = value.lateness_p999_us;
  wire.lateness_max_us = value.lateness_max_us;
  wire.deadline_misses = value.deadline_misses;
  wire.refused_messages = value.refused_messages;
  for (std::size_t i = 0; i < value.refused_by.size(); ++i) {
    wire.*kRefusedBy[i] = value.refused_by[i];
  }
  wire.dropped_messages = value.dropped_messages;
  wire.stops = value.stops;
  std::copy(value.stops_by.begin(), value.stops_by.end(), std::begin(wire.stops_by_reason));
  wire.calibration_position = value.calibration.position;
  wire.calibration_rotation = value.calibration.rotation;
  wire.calibration_focal = value.calibration.focal;
  wire.calibration_revolute = value.calibration.revolute;
  wire.calibration_prismatic = value.calibration.prismatic;
  EncodeWire(wire, out);
}

void Encode(const GroundTruth& value, Bytes* out) {
  vantage_msgs::sim_truth_t wire;
  wire.utime = ToMicroseconds(value.stamp);
  wire.num_joints = static_cast<std::int32_t>(value.q.size());
  wire.position.assign(value.q.begin(), value.q.end());
  wire.worst_error = value.worst_error;
  wire.rms_error = value.rms_error;
  wire.limit_violations = value.limit_violations;
  EncodeWire(wire, out);
}

void Encode(const CameraImage& value, Bytes* out) {
  bot_core::image_t wire;
  wire.utime = ToMicroseconds(value.stamp);
  wire.width = value.width;
  wire.height = value.height;
  wire.row_stride = value.row_stride;
  wire.pixelformat = ToWire(value.format);
  wire.size = static_cast<std::int32_t>(value.data.size());
  wire.data = value.data;
  wire.nmetadata = 0;
  EncodeWire(wire, out);
}

}  // namespace vantage
