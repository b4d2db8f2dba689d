// A velocity-controlled arm on Vantage's channels, with nothing of Vantage but its message types: the program to
// start from when you connect an arm of your own. Put your robot's API in the place of class Robot.
//
//   vantage-servo planar-good-view &
//   vantage-sim planar-good-view --arm external &        (the camera; yours in its stead later)
//   velocity_arm --joints 1.2217 0.5236
//
// What an arm's driver owes the servo:
//   - JOINT_STATE at the control rate or faster: positions [rad, m], velocities, and the time the encoders were
//     read on CLOCK_MONOTONIC of this machine [us];
//   - it obeys JOINT_COMMAND.velocity until the next one comes, for one control period;
//   - a watchdog of its own: when no command came for 100 ms it brakes, whatever the servo may say;
//   - it never trusts a message: size, numbers and age are checked here again.
// In return the servo keeps every command within the velocity, acceleration and position limits of its robot
// file, and ramps to zero whenever an input is stale (SERVO_STATUS says which).

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <iostream>
#include <string>
#include <thread>
#include <vector>

#include <lcm/lcm-cpp.hpp>

#include "vantage_msgs/joint_command_t.hpp"
#include "vantage_msgs/joint_state_t.hpp"

namespace {

constexpr double kPeriod = 0.002;         // [s]
constexpr double kWatchdog = 0.1;         // without a command the arm brakes [s]
constexpr double kAcceleration = 4.0;     // of that braking [rad/s²]
constexpr double kLag = 0.02;             // of this arm's velocity loop [s]
constexpr std::int64_t kOldest = 50'000;  // a command older than this is not obeyed [us]

volatile std::sig_atomic_t stop = 0;

std::int64_t NowMicroseconds() {
  using namespace std::chrono;  // NOLINT: steady_clock is CLOCK_MONOTONIC
  return duration_cast<microseconds>(steady_clock::now().time_since_epoch()).count();
}

/// The robot. Here it is a first-order lag; yours calls its maker's API in these three functions.
class Robot {
 public:
  explicit Robot(std::vector<double> q) : q_(std::move(q)), qdot_(q_.size(), 0.0) {}

  [[nodiscard]] const std::vector<double>& positions() const { return q_; }
  [[nodiscard]] const std::vector<double>& velocities() const { return qdot_; }
  void SetVelocities(const std::vector<double>& wanted) {
    const double blend = 1.0 - std::exp(-kPeriod / kLag);
    for (std::size_t i = 0; i < q_.size(); ++i) {
      qdot_[i] += blend * (wanted[i] - qdot_[i]);
      q_[i] += kPeriod * qdot_[i];
    }
  }

 private:
  std::vector<double> q_, qdot_;
};

/// The newest good command, and what is left of it when it grows old.
class Commands {
 public:
  explicit Commands(std::size_t joints) : velocity_(joints, 0.0) {}

  void Receive(const lcm::ReceiveBuffer*, const std::string&,
               const vantage_msgs::joint_command_t* message) {
    const std::int64_t age = NowMicroseconds() - message->utime;
    bool good = message->velocity.size() == velocity_.size() && age < kOldest && age > -kOldest;
    for (const double v : message->velocity) good = good && std::isfinite(v);
    if (!good) {
      ++refused_;
      return;
    }
    velocity_ = message->velocity;
    received_ = NowMicroseconds();
  }

  /// To be called once a period: brakes when nobody commands.
  const std::vector<double>& Velocity() {
    if (NowMicroseconds() - received_ > static_cast<std::int64_t>(1e6 * kWatchdog)) {
      const double step = kAcceleration * kPeriod;
      for (double& v : velocity_) v -= std::clamp(v, -step, step);
    }
    return velocity_;
  }
  [[nodiscard]] int refused() const { return refused_; }

 private:
  std::vector<double> velocity_;
  std::int64_t received_{0};
  int refused_{0};
};

int Fail(const std::string& reason) {
  std::cerr << "velocity_arm: " << reason
            << "\nusage: velocity_arm [--prefix NAME] --joints Q1 [Q2...]   (start, rad)\n"
               "The transport is LCM_DEFAULT_URL's, as vantage-run prints it.\n";
  return 2;
}

}  // namespace

int main(int argc, char** argv) {
  std::string prefix;
  std::vector<double> q;
  for (int i = 1; i < argc; ++i) {
    if (std::strcmp(argv[i], "--prefix") == 0 && i + 1 < argc) {
      prefix = argv[++i];
    } else if (std::strcmp(argv[i], "--joints") != 0) {
      char* end = nullptr;
      q.push_back(std::strtod(argv[i], &end));
      if (*end != '\0' || !std::isfinite(q.back()))
        return Fail(std::string("not a number: ") + argv[i]);
    }
  }
  if (q.empty()) return Fail("needs the joints' start");
  for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, [](int) { stop = 1; });

  lcm::LCM lcm;
  if (!lcm.good()) return Fail("no LCM transport");
  Robot robot(q);
  Commands commands(q.size());
  lcm.subscribe(prefix + "JOINT_COMMAND", &Commands::Receive, &commands)->setQueueCapacity(1);

  vantage_msgs::joint_state_t state;
  state.num_joints = static_cast<std::int32_t>(q.size());
  auto next = std::chrono::steady_clock::now();
  while (stop == 0) {
    // All that waits, and no waiting. A lost hub makes it fail: then there is nobody to obey.
    while (lcm.getFileno() >= 0 && lcm.handleTimeout(0) > 0) {
    }
    robot.SetVelocities(commands.Velocity());
    state.utime = NowMicroseconds();
    state.position = robot.positions();
    state.velocity = robot.velocities();
    lcm.publish(prefix + "JOINT_STATE", &state);
    next += std::chrono::microseconds(static_cast<int>(1e6 * kPeriod));
    std::this_thread::sleep_until(next);
  }
  std::cerr << "velocity_arm: " << commands.refused() << " commands refused\n";
  return 0;
}
