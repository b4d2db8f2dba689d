// soak_processes [--minutes M] [--seed S]: the programs on the wall clock, over the built-in hub, while they are
// stopped, killed and started again, the hub goes away and comes back, and garbage is sent on every channel. After
// each the servo must work again; the arm's limits hold throughout; no process that lives on grows.

#include <csignal>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <random>
#include <thread>

#include "becomes_true.h"
#include "memory.h"
#include "soak_main.h"
#include "temporary_folder.h"
#include "vantage/config/config_text.h"
#include "vantage/messaging/lcm_link.h"
#include "vantage/messaging/tcp_hub.h"
#include "vantage/runtime/child_process.h"

namespace vantage::soak {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr Duration kRecovery = seconds(60);
constexpr double kMostGrowth = 8.0;  // [MiB]

// The built-in scenario with a goal that goes round for ever, so that there is always something to do.
std::string MovingScenario() {
  std::string text = FindConfigText(ConfigKind::kScenario, "puma560-bad-view").text;
  const auto insert = [&](const std::string& before, const std::string& what) {
    text.insert(text.find(before), what);
  };
  insert("    offset: [0, 0, 0.28]", "    max_speed: 0.1\n");
  insert("  start_joints_deg",
         "  goal_motion: {a: [0.06, 0.05, 0], b: [0, 0, 0.04], period: 20}\n");
  return text;
}

/// The hub, the two programs, and what they say.
class Cell {
 public:
  Cell()
      : hub_(std::make_unique<TcpHub>(Options(0))), port_(hub_->port()), link_({hub_->url(), ""}) {
    folder_.Write("moving.yaml", MovingScenario());
    link_.Subscribe<ServoStatus>(kServoStatusChannel, [this](const ServoStatus& v) {
      const std::lock_guard lock(mutex_);
      status_ = v;
    });
    link_.Subscribe<GroundTruth>(kSimTruthChannel, [this](const GroundTruth& v) {
      const std::lock_guard lock(mutex_);
      truth_ = v;
    });
    link_.Start();
    StartSim();
    StartServo();
  }

  void StartSim() { sim_ = Start("vantage-sim", {Scenario(), "--image-rate", "5"}); }
  void StartServo() { servo_ = Start("vantage-servo", {Scenario(), "--priority", "0"}); }
  void RestartHub() {
    const std::uint16_t port = port_;
    hub_.reset();
    std::this_thread::sleep_for(milliseconds(300));
    hub_ = std::make_unique<TcpHub>(Options(port));
  }

  [[nodiscard]] ChildProcess& sim() { return *sim_; }
  [[nodiscard]] ChildProcess& servo() { return *servo_; }
  [[nodiscard]] LcmLink& link() { return link_; }
  [[nodiscard]] std::optional<ServoStatus> status() const {
    const std::lock_guard lock(mutex_);
    return status_;
  }
  [[nodiscard]] std::int64_t violations() const {
    const std::lock_guard lock(mutex_);
    return truth_ ? truth_->limit_violations : 0;
  }
  /// Heard from lately, and not standing.
  [[nodiscard]] bool Works() const {
    const auto now = status();
    return now && Clock::now() - now->stamp < milliseconds(500) &&
           (now->state == ServoState::kServoing || now->state == ServoState::kConverged ||
            now->state == ServoState::kRepositioning);
  }

 private:
  static TcpHubOptions Options(std::uint16_t port) {
    TcpHubOptions options;
    options.port = port;
    options.ports_tried = 1;
    return options;
  }
  [[nodiscard]] std::string Scenario() const { return (folder_.path() / "moving.yaml").string(); }
  [[nodiscard]] std::unique_ptr<ChildProcess> Start(const std::string& program,
                                                    std::vector<std::string> arguments) const {
    ChildOptions options;
    options.arguments = {
        (std::filesystem::canonical("/proc/self/exe").parent_path() / program).string()};
    options.arguments.insert(options.arguments.end(), arguments.begin(), arguments.end());
    options.environment["LCM_DEFAULT_URL"] = "tcpq://127.0.0.1:" + std::to_string(port_);
    options.output = "/dev/null";
    return std::make_unique<ChildProcess>(options);
  }

  test::TemporaryFolder folder_;
  std::unique_ptr<TcpHub> hub_;
  std::uint16_t port_;
  mutable std::mutex mutex_;
  std::optional<ServoStatus> status_;
  std::optional<GroundTruth> truth_;
  LcmLink link_;
  std::unique_ptr<ChildProcess> sim_, servo_;
};

void SendGarbage(Cell* cell, std::mt19937_64* random) {
  const char* const channels[] = {kJointStateChannel, kCameraPoseChannel, kImageFeaturesChannel,
                                  kCameraPoseCommandChannel, kJointCommandChannel};
  JointState joints;
  joints.q = joints.qdot = JointVector::Constant(6, std::numeric_limits<double>::quiet_NaN());
  for (int i = 0; i < 1000; ++i) {
    Bytes bytes((*random)() % 400);
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>((*random)());
    cell->link().PublishBytes(channels[(*random)() % 5], bytes);
    joints.stamp = Clock::now();
    cell->link().Publish(kJointStateChannel, joints);
    if (i % 5 == 0) std::this_thread::sleep_for(milliseconds(1));
  }
}

struct Fault {
  const char* name;
  std::function<void()> happen;
};

int Run(double minutes, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto between = [&](int low, int high) {
    return milliseconds(std::uniform_int_distribution<int>(low, high)(random));
  };
  Cell cell;
  const auto pause = [&](ChildProcess* process) {
    process->Signal(SIGSTOP);
    std::this_thread::sleep_for(between(50, 1500));
    process->Signal(SIGCONT);
  };
  const std::vector<Fault> faults{
      {"simulator stopped for a while", [&] { pause(&cell.sim()); }},
      {"servo stopped for a while", [&] { pause(&cell.servo()); }},
      {"two thousand messages of garbage", [&] { SendGarbage(&cell, &random); }},
      {"hub gone and back", [&] { cell.RestartHub(); }},
      {"simulator killed and started again",
       [&] {
         cell.sim().Signal(SIGKILL);
         std::this_thread::sleep_for(between(10, 800));
         cell.StartSim();
       }},
      {"servo killed and started again", [&] {
         cell.servo().Signal(SIGKILL);
         std::this_thread::sleep_for(between(10, 800));
         cell.StartServo();
       }}};
  std::vector<int> counts(faults.size());
  if (!test::BecomesTrue([&] { return cell.Works(); }, kRecovery)) {
    std::printf("FAILED: the servo does not begin\n");
    return 1;
  }
  const Time begin = Clock::now();
  const double total = 60.0 * minutes;
  const auto elapsed = [&] { return ToSeconds(Clock::now() - begin); };
  double longest = 0.0, next_line = 0.0, settled_sim = 0.0, settled_servo = 0.0;
  bool good = true;
  while (good && elapsed() < total) {
    std::this_thread::sleep_for(between(1000, 6000));
    // In the second half nobody is killed: whoever leaks is seen to grow.
    const bool late = elapsed() > 0.5 * total;
    const std::size_t kinds = late ? 4 : faults.size();
    const std::size_t kind = std::uniform_int_distribution<std::size_t>(0, kinds - 1)(random);
    faults[kind].happen();
    ++counts[kind];
    const Time fault_over = Clock::now();
    const bool works = test::BecomesTrue(
        [&] { return cell.Works() && cell.status()->stamp > fault_over + milliseconds(300); },
        kRecovery);
    longest = std::max(longest, ToSeconds(Clock::now() - fault_over));
    if (!works) {
      const auto status = cell.status();
      std::printf("FAILED: after \"%s\" the servo does not work again: %s %s\n", faults[kind].name,
                  status ? Name(status->state) : "silent", status ? Name(status->reason) : "");
      good = false;
    }
    if (cell.violations() != 0) {
      std::printf("FAILED: %lld limit violations\n", static_cast<long long>(cell.violations()));
      good = false;
    }
    const double sim = ResidentMebibytes(std::to_string(cell.sim().pid()));
    const double servo = ResidentMebibytes(std::to_string(cell.servo().pid()));
    if (elapsed() < 0.6 * total) {
      settled_sim = sim;
      settled_servo = servo;
    }
    if (elapsed() >= next_line || elapsed() >= total) {
      next_line += 0.1 * total;
      const auto status = cell.status();
      std::printf("%6.1f min: %s, %lld refused, %lld stops, sim %.1f MiB, servo %.1f MiB\n",
                  elapsed() / 60.0, Name(status->state),
                  static_cast<long long>(status->refused_messages),
                  static_cast<long long>(status->stops), sim, servo);
      std::fflush(stdout);
    }
    if (elapsed() >= total &&
        (sim > settled_sim + kMostGrowth || servo > settled_servo + kMostGrowth)) {
      std::printf("FAILED: memory grew from %.1f and %.1f MiB\n", settled_sim, settled_servo);
      good = false;
    }
  }
  for (std::size_t i = 0; i < faults.size(); ++i)
    std::printf("  %5d  %s\n", counts[i], faults[i].name);
  std::printf(
      "longest time until the servo worked again: %.1f s; memory at 60 %%: sim %.1f MiB, servo "
      "%.1f MiB\n",
      longest, settled_sim, settled_servo);
  return good ? 0 : 1;
}

}  // namespace
}  // namespace vantage::soak

int main(int argc, char** argv) {
  return vantage::soak::SoakMain(
      argc, argv, "soak_processes",
      "The programs on the wall clock, stopped, killed and lied to at random", 10.0, "Wall time",
      vantage::soak::Run);
}
