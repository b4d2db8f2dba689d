#include "vantage/messaging/panda.h"

#include <drake/lcmt_panda_command.hpp>
#include <drake/lcmt_panda_status.hpp>

#include "wire.h"

namespace vantage {
namespace {

template <typename Wire>
Refusal CheckJoints(const Wire& wire) noexcept {
  const int n = wire.num_joints;
  Checks checks;
  checks.Require(n >= 1 && n <= kMaxJoints, Refusal::kLimit);
  if (checks.failed()) return checks.result();
  checks.Magnitude(wire.joint_position.data(), n).Magnitude(wire.joint_velocity.data(), n);
  return checks.Stamp(wire.utime).result();
}

template <typename Wire, typename Value>
void TakeJoints(const Wire& wire, Value* out) {
  out->stamp = FromMicroseconds(wire.utime);
  out->q = Eigen::Map<const Eigen::VectorXd>(wire.joint_position.data(), wire.num_joints);
  out->qdot = Eigen::Map<const Eigen::VectorXd>(wire.joint_velocity.data(), wire.num_joints);
}

template <typename Value, typename Wire>
void GiveJoints(const Value& value, Wire* wire) {
  wire->utime = ToMicroseconds(value.stamp);
  wire->num_joints = static_cast<std::int32_t>(value.q.size());
  wire->joint_position.assign(value.q.begin(), value.q.end());
  wire->joint_velocity.assign(value.qdot.begin(), value.qdot.end());
}

}  // namespace

const char* Name(PandaMode mode) noexcept {
  switch (mode) {
    case PandaMode::kOther:
      return "OTHER";
    case PandaMode::kIdle:
      return "IDLE";
    case PandaMode::kMove:
      return "MOVE";
    case PandaMode::kGuiding:
      return "GUIDING";
    case PandaMode::kReflex:
      return "REFLEX";
    case PandaMode::kUserStopped:
      return "USER_STOPPED";
    case PandaMode::kAutomaticErrorRecovery:
      return "AUTOMATIC_ERROR_RECOVERY";
  }
  return "UNKNOWN";
}

Refusal Decode(const void* data, std::size_t size, PandaStatus* out) noexcept {
  drake::lcmt_panda_status wire;
  Refusal refusal = DecodeWire(data, size, kMaxStateBytes, &wire);
  if (refusal == Refusal::kNone) refusal = CheckJoints(wire);
  if (refusal == Refusal::kNone) {
    refusal = Checks()
                  .UpTo(static_cast<int>(PandaMode::kAutomaticErrorRecovery), wire.robot_mode)
                  .result();
  }
  if (refusal != Refusal::kNone) return refusal;
  TakeJoints(wire, out);
  out->mode = static_cast<PandaMode>(wire.robot_mode);
  out->position_control = wire.position_control_enabled != 0;
  out->velocity_control = wire.velocity_control_enabled != 0;
  return Refusal::kNone;
}

Refusal Decode(const void* data, std::size_t size, PandaCommand* out) noexcept {
  drake::lcmt_panda_command wire;
  Refusal refusal = DecodeWire(data, size, kMaxStateBytes, &wire);
  if (refusal == Refusal::kNone) refusal = CheckJoints(wire);
  if (refusal != Refusal::kNone) return refusal;
  TakeJoints(wire, out);
  out->position_control = wire.position_control_expected != 0;
  return Refusal::kNone;
}

void Encode(const PandaStatus& value, Bytes* out) {
  drake::lcmt_panda_status wire;
  GiveJoints(value, &wire);
  const std::vector<double> zeros(wire.joint_position.size());
  wire.joint_position_desired = wire.joint_position;
  wire.joint_velocity_desired = wire.joint_velocity;
  wire.joint_acceleration_desired = zeros;
  wire.joint_torque = zeros;
  wire.joint_torque_desired = zeros;
  wire.joint_torque_external = zeros;
  wire.control_command_success_rate = 1.0;
  wire.robot_mode = static_cast<std::int8_t>(value.mode);
  wire.robot_utime = wire.utime;
  wire.position_control_enabled = value.position_control ? 1 : 0;
  wire.velocity_control_enabled = value.velocity_control ? 1 : 0;
  wire.torque_control_enabled = 0;
  EncodeWire(wire, out);
}

void Encode(const PandaCommand& value, Bytes* out) {
  drake::lcmt_panda_command wire;
  GiveJoints(value, &wire);
  wire.joint_torque.assign(wire.joint_position.size(), 0.0);
  wire.position_control_expected = value.position_control ? 1 : 0;
  wire.velocity_control_expected = value.position_control ? 0 : 1;
  wire.torque_control_expected = 0;
  EncodeWire(wire, out);
}

}  // namespace vantage
