// vantage-panda-bridge: lets vantage-servo move a Franka Panda through the driver that Drake uses.
//
// PANDA_STATUS becomes JOINT_STATE, JOINT_COMMAND becomes PANDA_COMMAND. Both are passed on at once, in the
// link's thread.

#include <atomic>
#include <iostream>
#include <mutex>

#include "app.h"
#include "vantage/messaging/clock_offset.h"
#include "vantage/messaging/lcm_link.h"
#include "vantage/messaging/panda.h"
#include "vantage/messaging/transport.h"
#include "vantage/runtime/periodic_loop.h"
#include "vantage/runtime/signal_stop.h"

namespace vantage {
namespace {

// A servo that says nothing for this long is gone: the arm is told to stand, for a while.
constexpr Duration kSilence = std::chrono::milliseconds(100);
constexpr Duration kStanding = std::chrono::seconds(1);
constexpr Duration kWatchPeriod = std::chrono::milliseconds(10);

struct Arguments {
  std::string prefix;
  std::string panda_prefix;
  std::string mode = "velocity";
};

class Bridge {
 public:
  explicit Bridge(const Arguments& arguments)
      : position_(arguments.mode == "position"),
        transport_(JoinTransport()),
        vantage_({transport_.url, arguments.prefix}),
        panda_({transport_.url, arguments.panda_prefix}) {
    if (!transport_.explanation.empty()) std::cerr << transport_.explanation << '\n';
    // The driver's stamps are of a clock of its own.
    SubscribeOptions foreign;
    foreign.stamps.not_from_future = false;
    panda_.Subscribe<PandaStatus>(
        kPandaStatusChannel, [this](const PandaStatus& status) { OnStatus(status); }, foreign);
    vantage_.Subscribe<JointCommand>(kJointCommandChannel,
                                     [this](const JointCommand& command) { OnCommand(command); });
    panda_.Start();
    vantage_.Start();
    std::cerr << "vantage-panda-bridge: " << arguments.mode << " control, on " << transport_.url
              << '\n';
  }

  int Run() {
    const SignalStop stop;
    RunPeriodic(kWatchPeriod, stop.flag(), [this] { Watch(Clock::now()); });
    Stand();
    return kExitOk;
  }

 private:
  void OnStatus(const PandaStatus& status) {
    const Time now = Clock::now();
    {
      const std::lock_guard lock(mutex_);
      if (status.mode != mode_) {
        std::cerr << "vantage-panda-bridge: the arm is in mode " << Name(status.mode) << '\n';
        mode_ = status.mode;
      }
      const bool fits = position_ ? status.position_control : status.velocity_control;
      if (!fits && !warned_) {
        std::cerr << "vantage-panda-bridge: the driver is not in "
                  << (position_ ? "position" : "velocity") << " control: it will not obey\n";
      }
      warned_ = !fits;
      q_ = status.q;
    }
    vantage_.Publish(kJointStateChannel,
                     JointState{clock_.Translate(status.stamp, now), status.q, status.qdot});
  }

  void OnCommand(const JointCommand& command) {
    {
      const std::lock_guard lock(mutex_);
      last_command_ = Clock::now();
    }
    panda_.Publish(kPandaCommandChannel,
                   PandaCommand{command.stamp, command.q, command.qdot, position_});
  }

  void Watch(Time now) {
    Time last;
    {
      const std::lock_guard lock(mutex_);
      last = last_command_;
    }
    const bool silent = last != Time{} && now - last > kSilence;
    if (silent && now - last < kSilence + kStanding) Stand();
  }

  // Where it is, at no speed.
  void Stand() {
    JointVector q;
    {
      const std::lock_guard lock(mutex_);
      if (last_command_ == Time{} || q_.size() == 0) return;
      q = q_;
    }
    panda_.Publish(kPandaCommandChannel,
                   PandaCommand{Clock::now(), q, JointVector::Zero(q.size()), position_});
  }

  const bool position_;
  ClockOffset clock_;  // In the thread of panda_ alone.
  std::mutex mutex_;
  PandaMode mode_{PandaMode::kOther};
  bool warned_{false};
  JointVector q_;
  Time last_command_{};
  Transport transport_;
  LcmLink vantage_;
  LcmLink panda_;
};

}  // namespace
}  // namespace vantage

int main(int argc, char** argv) {
  vantage::Arguments arguments;
  CLI::App app(
      "Bridge between vantage-servo and a Franka Panda whose driver speaks Drake's "
      "lcmt_panda_status and lcmt_panda_command",
      "vantage-panda-bridge");
  app.add_option("--prefix", arguments.prefix, "Before the names of Vantage's channels");
  app.add_option("--panda-prefix", arguments.panda_prefix, "Before PANDA_STATUS and PANDA_COMMAND");
  app.add_option("--mode", arguments.mode, "Control mode of the driver")
      ->check(CLI::IsMember({"velocity", "position"}))
      ->capture_default_str();
  return vantage::RunApp(&app, argc, argv, "", [&] { return vantage::Bridge(arguments).Run(); });
}
