#include "sim/arm_plant.h"

#include <algorithm>
#include <cmath>

#include "vantage/control/servo_law.h"
#include "vantage/math/error.h"

namespace vantage::sim {
namespace {

// Rounding, and the travel of one plant step, are no violations.
constexpr double kSlack = 1e-9;
// Messages carry whole microseconds [s].
constexpr double kStampStep = 2e-6;

JointVector Noise(int n, double sigma, std::mt19937_64* random) {
  std::normal_distribution<double> normal(0.0, 1.0);
  JointVector noise(n);
  for (int i = 0; i < n; ++i) noise(i) = sigma * normal(*random);
  return noise;
}

}  // namespace

ArmPlant::ArmPlant(ArmModel arm, const JointVector& q_start, const ArmEffects& effects,
                   std::uint64_t seed)
    : arm_(std::move(arm)), effects_(effects), random_(seed), q_(q_start) {
  if (q_start.size() != arm_.size() || !WithinLimits(arm_, q_start)) {
    throw ConfigError("", "sim.start_joints",
                      "needs " + std::to_string(arm_.size()) + " joints within their limits");
  }
  bias_ = Noise(arm_.size(), effects_.encoder_bias, &random_);
  qdot_ = JointVector::Zero(arm_.size());
  target_ = qdot_;
  last_qdot_ = qdot_;
}

void ArmPlant::Accept(const JointCommand& command, Time now) {
  const int n = arm_.size();
  if (command.qdot.size() != n || !command.qdot.allFinite()) {
    ++violations_.not_finite;
    return;
  }
  // By the commands' own stamps: what happens on their way is not the controller's. A first command, or
  // one after a rest, may come from a standstill.
  const double dt = commanded_ ? ToSeconds(command.stamp - last_stamp_) + kStampStep : 0.0;
  for (int i = 0; i < n; ++i) {
    const JointLimits& limit = arm_.limits()[static_cast<std::size_t>(i)];
    if (std::abs(command.qdot(i)) > limit.velocity + kSlack) ++violations_.velocity;
    const double change = std::abs(command.qdot(i) - last_qdot_(i));
    if (commanded_ && change > limit.acceleration * dt + kSlack) ++violations_.acceleration;
  }
  last_qdot_ = command.qdot;
  last_stamp_ = command.stamp;
  target_ = command.qdot;
  last_command_ = now;
  commanded_ = true;
}

void ArmPlant::Follow(const JointState& state) {
  if (state.q.size() != arm_.size() || state.qdot.size() != arm_.size()) return;
  follows_ = true;
  q_ = state.q;
  qdot_ = state.qdot;
}

void ArmPlant::Step(Time now, double dt) {
  if (follows_) {
    q_ += dt * qdot_;
    return;
  }
  if (commanded_ && ToSeconds(now - last_command_) > effects_.watchdog) {
    target_ = RampToRest(arm_.limits(), target_, dt);
  }
  const double blend = effects_.lag > 0.0 ? 1.0 - std::exp(-dt / effects_.lag) : 1.0;
  qdot_ += blend * (target_ - qdot_);
  q_ += dt * qdot_;
  for (int i = 0; i < arm_.size(); ++i) {
    // Limits are limits of what the encoders say: nobody has another measure of a joint.
    const JointLimits& limit = arm_.limits()[i];
    const double read = q_(i) + bias_(i);
    if (read >= limit.lower - kSlack && read <= limit.upper + kSlack) continue;
    ++violations_.position;
    // The mechanical stop.
    q_(i) = std::clamp(read, limit.lower, limit.upper) - bias_(i);
    qdot_(i) = 0.0;
  }
}

JointState ArmPlant::Read(Time now) {
  return {now, q_ + bias_ + Noise(arm_.size(), effects_.encoder_noise, &random_), qdot_};
}

}  // namespace vantage::sim
