// vantage-sim SCENARIO: the simulated cell on the wall clock, speaking what drivers of a real arm, camera
// rig and camera would speak.

#include <atomic>
#include <iostream>
#include <thread>

#include "app.h"
#include "image_message.h"
#include "render_picture.h"
#include "sim/world.h"
#include "vantage/config/scenario.h"
#include "vantage/messaging/lcm_link.h"
#include "vantage/messaging/transport.h"
#include "vantage/runtime/latest_value.h"
#include "vantage/runtime/periodic_loop.h"
#include "vantage/runtime/signal_stop.h"

namespace vantage {
namespace {

constexpr Duration kJointPeriod = std::chrono::milliseconds(2);
constexpr Duration kPosePeriod = std::chrono::milliseconds(5);
constexpr Duration kTruthPeriod = std::chrono::milliseconds(20);
// A world that lags behind the clock by more than this is moved on without being simulated.
constexpr Duration kMaxLag = std::chrono::milliseconds(100);

struct Arguments {
  std::string scenario = kDefaultScenario;
  std::string prefix;
  std::string arm = "simulated";
  double image_rate = 10.0;
  std::optional<std::uint64_t> seed;
};

/// True once every period, on the caller's times.
class Every {
 public:
  explicit Every(Duration period) : period_(period) {}
  bool Due(Time now) {
    if (now < next_) return false;
    next_ = now + period_;
    return true;
  }

 private:
  Duration period_;
  Time next_{};
};

/// Pictures for people, drawn in a thread and a GL context of their own.
class ImagePublisher {
 public:
  ImagePublisher(const Scenario& scenario, double rate, LcmLink* link)
      : renderer_(sim::MakeRenderer(scenario)), rate_(rate), link_(link) {
    if (rate_ > 0.0) thread_ = std::thread([this] { Loop(); });
  }
  ~ImagePublisher() {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
  }
  ImagePublisher(const ImagePublisher&) = delete;
  ImagePublisher& operator=(const ImagePublisher&) = delete;

  void Show(const sim::WorldView& view) { view_.Publish(view); }

 private:
  void Loop() {
    sim::WorldView view;
    RunPeriodic(FromSeconds(1.0 / rate_), stop_, [&] {
      if (!view_.Take(&view)) return;
      link_->Publish(kCameraImageChannel,
                     JpegMessage(RenderPicture(&renderer_, view.X_WC, view.scene), view.stamp));
    });
  }

  sim::Renderer renderer_;
  double rate_;
  LcmLink* link_;
  LatestValue<sim::WorldView> view_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

int Run(const Arguments& arguments) {
  Scenario scenario = LoadScenario(arguments.scenario);
  if (arguments.seed) scenario.sim.seed = *arguments.seed;
  const SignalStop stop;
  const Transport transport = JoinTransport();
  if (!transport.explanation.empty()) std::cerr << transport.explanation << '\n';

  LcmLink link({transport.url, arguments.prefix});
  LatestValue<JointCommand> commands;
  LatestValue<CameraPose> pose_commands;
  LatestValue<JointState> joints;
  link.Subscribe<JointCommand>(kJointCommandChannel, [&](const auto& v) { commands.Publish(v); });
  link.Subscribe<CameraPose>(kCameraPoseCommandChannel,
                             [&](const auto& v) { pose_commands.Publish(v); });

  const bool external = arguments.arm == "external";
  if (external) {
    link.Subscribe<JointState>(kJointStateChannel, [&](const auto& v) { joints.Publish(v); });
  }

  sim::World world(scenario, Clock::now());
  ImagePublisher images(scenario, arguments.image_rate, &link);
  link.Start();
  world.SkipTo(Clock::now());
  std::cerr << "vantage-sim: " << scenario.name << " on " << transport.url << '\n';

  Every joints_due(kJointPeriod);
  Every pose_due(kPosePeriod);
  Every truth_due(kTruthPeriod);
  JointCommand command;
  JointState joint_state;
  CameraPose pose_command;
  std::int64_t skips = 0;
  const LoopReport report = RunPeriodic(FromSeconds(scenario.sim.step), stop.flag(), [&] {
    const Time now = Clock::now();
    if (commands.Take(&command)) world.Accept(command, now);
    if (pose_commands.Take(&pose_command)) world.Accept(pose_command);
    if (joints.Take(&joint_state)) world.Follow(joint_state);
    if (now - world.now() > kMaxLag) {
      world.SkipTo(now);
      ++skips;
    }
    world.Advance(now);
    if (!external && joints_due.Due(now)) link.Publish(kJointStateChannel, world.ReadJoints());
    if (pose_due.Due(now)) link.Publish(kCameraPoseChannel, world.ReadCameraPose());
    if (const auto features = world.ReadFeatures()) link.Publish(kImageFeaturesChannel, *features);
    if (truth_due.Due(now)) {
      link.Publish(kSimTruthChannel, world.truth());
      images.Show(world.view());
    }
  });
  std::cerr << "vantage-sim: " << report.cycles << " steps, longest "
            << report.worst_cycle.count() / 1000 << " us";
  if (skips > 0) std::cerr << ", " << skips << " times too slow for the clock";
  std::cerr << '\n';
  return kExitOk;
}

}  // namespace
}  // namespace vantage

int main(int argc, char** argv) {
  vantage::Arguments arguments;
  CLI::App app("Simulated arm, camera rig and camera, speaking the channels of their drivers",
               "vantage-sim");
  app.add_option("scenario", arguments.scenario, "Built-in scenario or a YAML file")
      ->capture_default_str();
  app.add_option("--prefix", arguments.prefix, "Before every channel name");
  app.add_option("--arm", arguments.arm,
                 "simulated: JOINT_STATE is ours; external: another program's, whose arm is drawn")
      ->check(CLI::IsMember({"simulated", "external"}))
      ->capture_default_str();
  app.add_option("--image-rate", arguments.image_rate, "CAMERA_IMAGE messages [1/s]; 0: none")
      ->check(CLI::Range(0.0, 30.0))
      ->capture_default_str();
  app.add_option("--seed", arguments.seed, "Seed of every random number, instead of the scenario's")
      ->check(vantage::WholeNumber());
  return vantage::RunApp(&app, argc, argv, "", [&] { return vantage::Run(arguments); });
}
