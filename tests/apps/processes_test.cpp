// The programs as real processes on the built-in TCP hub: who dies, who notices, who says what.

#include <csignal>
#include <filesystem>
#include <fstream>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <sstream>
#include <thread>

#include <gtest/gtest.h>

#include "any_port.h"
#include "becomes_true.h"
#include "program.h"
#include "temporary_folder.h"
#include "vantage/messaging/lcm_link.h"
#include "vantage/messaging/tcp_hub.h"
#include "vantage/runtime/child_process.h"

namespace vantage {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using test::BecomesTrue;

std::string Program(const std::string& name) {
  return std::string(VANTAGE_BIN) + "/" + name;
}

/// A hub, and what the servo says on it.
class Cell {
 public:
  Cell() : hub_(test::AnyPort()), link_({hub_.url(), ""}) {
    link_.Subscribe<ServoStatus>(kServoStatusChannel, [this](const ServoStatus& v) {
      const std::lock_guard lock(mutex_);
      status_ = v;
    });
    link_.Subscribe<JointCommand>(kJointCommandChannel, [this](const JointCommand& v) {
      const std::lock_guard lock(mutex_);
      command_ = v;
    });
    link_.Subscribe<GroundTruth>(kSimTruthChannel, [this](const GroundTruth& v) {
      const std::lock_guard lock(mutex_);
      truth_ = v;
    });
    link_.Start();
  }

  [[nodiscard]] ChildProcess Start(const std::string& program,
                                   std::vector<std::string> arguments) const {
    ChildOptions options;
    options.arguments = {Program(program)};
    options.arguments.insert(options.arguments.end(), arguments.begin(), arguments.end());
    options.environment["LCM_DEFAULT_URL"] = hub_.url();
    options.output = "/dev/null";
    return ChildProcess(options);
  }
  [[nodiscard]] std::string url() const { return hub_.url(); }
  [[nodiscard]] ChildProcess StartSim() const {
    return Start("vantage-sim", {"planar-good-view", "--image-rate", "0"});
  }
  [[nodiscard]] ChildProcess StartServo() const {
    return Start("vantage-servo", {"planar-good-view", "--camera", "fixed", "--priority", "0"});
  }

  [[nodiscard]] std::optional<ServoStatus> status() const {
    const std::lock_guard lock(mutex_);
    return status_;
  }
  [[nodiscard]] bool State(ServoState state) const {
    const auto now = status();
    return now && now->state == state;
  }
  [[nodiscard]] bool Working() const {
    return State(ServoState::kServoing) || State(ServoState::kConverged);
  }
  [[nodiscard]] JointCommand command() const {
    const std::lock_guard lock(mutex_);
    return command_;
  }
  [[nodiscard]] std::optional<GroundTruth> truth() const {
    const std::lock_guard lock(mutex_);
    return truth_;
  }

 private:
  TcpHub hub_;
  mutable std::mutex mutex_;
  std::optional<ServoStatus> status_;
  JointCommand command_;
  std::optional<GroundTruth> truth_;
  LcmLink link_;
};

TEST(Processes, ServoStopsWhenTheSimulatorDiesAndResumesWhenItIsBack) {
  Cell cell;
  auto sim = std::make_unique<ChildProcess>(cell.StartSim());
  ChildProcess servo = cell.StartServo();
  ASSERT_TRUE(BecomesTrue([&] { return cell.State(ServoState::kServoing); }));

  sim->Signal(SIGKILL);
  ASSERT_TRUE(BecomesTrue([&] { return cell.State(ServoState::kHolding); }));
  EXPECT_EQ(cell.status()->reason, HoldReason::kStaleJointState) << Name(cell.status()->reason);
  // 1.5 rad/s at 6 rad/s^2 and more: at rest well within a second.
  EXPECT_TRUE(BecomesTrue([&] { return cell.command().qdot.isZero(0.0); }));
  EXPECT_EQ(cell.status()->stops, 1);
  // It stays at rest, alive, and goes on saying why.
  const std::int64_t seq = cell.status()->seq;
  ASSERT_TRUE(BecomesTrue([&] { return cell.status()->seq > seq + 100; }));
  EXPECT_TRUE(cell.command().qdot.isZero(0.0));
  EXPECT_TRUE(cell.State(ServoState::kHolding));

  sim = std::make_unique<ChildProcess>(cell.StartSim());
  EXPECT_TRUE(BecomesTrue([&] { return cell.State(ServoState::kConverged); }));
  EXPECT_EQ(cell.truth()->limit_violations, 0);
}

TEST(Processes, ARestartedServoGoesOn) {
  Cell cell;
  ChildProcess sim = cell.StartSim();
  auto servo = std::make_unique<ChildProcess>(cell.StartServo());
  ASSERT_TRUE(BecomesTrue([&] { return cell.State(ServoState::kServoing); }));
  servo->Signal(SIGKILL);
  ASSERT_TRUE(BecomesTrue([&] { return servo->Poll().has_value(); }));
  servo = std::make_unique<ChildProcess>(cell.StartServo());
  EXPECT_TRUE(BecomesTrue([&] { return cell.State(ServoState::kConverged); }));
  EXPECT_EQ(cell.truth()->limit_violations, 0);
}

// Ten times the traffic, half of it garbage, on every channel that the servo reads, while it works: it goes on,
// counts what it refuses, and no command leaves the limits.
TEST(Processes, AFloodOfGoodAndBadMessagesDoesNotDisturbTheServo) {
  Cell cell;
  ChildProcess sim = cell.StartSim();
  ChildProcess servo = cell.StartServo();
  ASSERT_TRUE(BecomesTrue([&] { return cell.State(ServoState::kServoing); }));
  LcmLink flood({cell.url(), ""});
  flood.Start();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  JointState joints;
  joints.q = joints.qdot = JointVector::Constant(2, nan);
  CameraPose pose;
  ImageFeatures features;
  const Time end = Clock::now() + seconds(2);
  int sent = 0;
  while (Clock::now() < end) {
    joints.stamp = pose.stamp = features.stamp = features.exposure = Clock::now();
    switch (++sent % 4) {
      case 0:
        flood.Publish(kJointStateChannel, joints);
        break;
      case 1:
        pose.X_WC.translation().x() = nan;
        flood.Publish(kCameraPoseChannel, pose);
        break;
      case 2:
        features.exposure += seconds(1000);
        features.stamp = features.exposure;
        flood.Publish(kImageFeaturesChannel, features);
        break;
      default:
        flood.PublishBytes(kJointStateChannel, Bytes(100, 0xff));
    }
    if (sent % 5 == 0) std::this_thread::sleep_for(milliseconds(1));  // 5000 a second
  }
  EXPECT_TRUE(BecomesTrue([&] { return cell.State(ServoState::kConverged); }));
  EXPECT_GT(cell.status()->refused_messages, sent / 2);
  EXPECT_EQ(cell.status()->stops, 0);
  EXPECT_EQ(cell.truth()->limit_violations, 0);
}

// A logger that is stopped (a full disk, a debugger): the hub and the servo do not wait for it.
TEST(Processes, ASubscriberThatDoesNotReadStopsNobody) {
  Cell cell;
  ChildOptions options;
  options.arguments = {"lcm-logger", "--lcm-url=" + cell.url(), "--force", "/dev/null"};
  options.output = "/dev/null";
  ChildProcess logger(options);
  ChildProcess sim = cell.Start("vantage-sim", {"planar-good-view", "--image-rate", "30"});
  ChildProcess servo = cell.StartServo();
  ASSERT_TRUE(BecomesTrue([&] { return cell.State(ServoState::kServoing); }));
  ASSERT_TRUE(logger.Signal(SIGSTOP));
  EXPECT_TRUE(BecomesTrue([&] { return cell.State(ServoState::kConverged); }));
  EXPECT_EQ(cell.status()->stops, 0);
  EXPECT_EQ(cell.truth()->limit_violations, 0);
  ASSERT_TRUE(logger.Signal(SIGKILL));
}

// The worked example in the place of the simulated arm: converges, and its death is noticed.
TEST(Processes, AnArmOfItsOwnProgramIsServoedAndMissedWhenItDies) {
  Cell cell;
  const auto arm = [&] { return cell.Start("velocity_arm", {"--joints", "1.2217", "0.5236"}); };
  auto velocity_arm = std::make_unique<ChildProcess>(arm());
  ChildProcess sim =
      cell.Start("vantage-sim", {"planar-good-view", "--image-rate", "0", "--arm", "external"});
  ChildProcess servo = cell.StartServo();
  ASSERT_TRUE(BecomesTrue([&] { return cell.State(ServoState::kServoing); }));
  velocity_arm->Signal(SIGKILL);
  ASSERT_TRUE(BecomesTrue([&] { return cell.State(ServoState::kHolding); }));
  EXPECT_EQ(cell.status()->reason, HoldReason::kStaleJointState) << Name(cell.status()->reason);
  ASSERT_TRUE(BecomesTrue([&] { return velocity_arm->Poll().has_value(); }));
  velocity_arm = std::make_unique<ChildProcess>(arm());
  EXPECT_TRUE(BecomesTrue([&] { return cell.State(ServoState::kConverged); }));
  ASSERT_TRUE(cell.truth().has_value());
  EXPECT_LT(cell.truth()->worst_error, 0.005);
  EXPECT_EQ(cell.truth()->limit_violations, 0);
}

// SIGTERM: the arm is brought to rest before the servo leaves, and its exit code is 0.
TEST(Processes, ToldToStopTheServoBringsTheArmToRest) {
  Cell cell;
  ChildProcess sim = cell.StartSim();
  ChildProcess servo = cell.StartServo();
  ASSERT_TRUE(BecomesTrue([&] { return cell.State(ServoState::kServoing); }));
  servo.Signal(SIGTERM);
  const auto end = servo.WaitFor(seconds(10));
  ASSERT_TRUE(end.has_value());
  EXPECT_TRUE(end->success()) << end->ToString();
  EXPECT_TRUE(BecomesTrue([&] { return cell.command().qdot.isZero(0.0); }, seconds(2)));
  EXPECT_EQ(cell.status()->reason, HoldReason::kOperator);
}

// An arm that was never heard: its command would be made up, all joints at 0, and an arm that takes positions would
// go there.
TEST(Processes, ToldToStopBeforeItHeardAnArmTheServoCommandsNothing) {
  Cell cell;
  ChildProcess servo = cell.StartServo();
  ASSERT_TRUE(BecomesTrue([&] {
    const auto status = cell.status();
    return status && status->reason == HoldReason::kNoJointState;
  }));
  servo.Signal(SIGTERM);
  const auto end = servo.WaitFor(seconds(10));
  ASSERT_TRUE(end.has_value());
  EXPECT_TRUE(end->success()) << end->ToString();
  // Its last words, after any command.
  ASSERT_TRUE(BecomesTrue([&] { return cell.status()->reason == HoldReason::kOperator; }));
  EXPECT_EQ(cell.command().q.size(), 0);
}

test::ProgramRun VantageRun(const std::string& arguments) {
  return test::RunProgram(Program("vantage-run") + " " + arguments);
}

class RunTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / ("vantage_runs_" + std::to_string(getpid()));
    std::filesystem::remove_all(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  [[nodiscard]] std::filesystem::path RunFolder() const {
    return std::filesystem::directory_iterator(folder_)->path();
  }
  std::filesystem::path folder_;
};

// The main job, all processes: converges, exit code 0, and the run folder holds what it promises.
TEST_F(RunTest, WholeRunConvergesAndLeavesItsFolder) {
  // A machine that is busy with other things takes longer, in stops and starts: the time is not what is tested.
  const auto [text, code] =
      VantageRun("puma560-bad-view --priority 0 --time-limit 300 --out " + folder_.string());
  EXPECT_EQ(code, 0) << text;
  EXPECT_NE(text.find("converged after"), std::string::npos) << text;
  EXPECT_NE(text.find("tools/spy"), std::string::npos);
  for (const char* name : {"run.png", "first.png", "last.png", "summary.json", "samples.csv",
                           "events.lcm", "report.html", "camera.mp4", "report/measures.png"}) {
    EXPECT_TRUE(std::filesystem::exists(RunFolder() / name)) << name;
    EXPECT_GT(std::filesystem::file_size(RunFolder() / name), 500u) << name;
  }
  // What real threads did on the wall clock comes out again, to the last bit that counts.
  const auto [replay_text, replay_code] = test::RunProgram(Program("vantage-servo") + " --replay " +
                                                           (RunFolder() / "events.lcm").string());
  EXPECT_EQ(replay_code, 0) << replay_text;
  EXPECT_NE(replay_text.find("\n  reproduced to 1e-09"), std::string::npos) << replay_text;
}

// A user's own arm: no scenario, no code.
TEST_F(RunTest, RunsAUrdfArmWithDotsOfItsChoice) {
  const auto [text, code] =
      VantageRun("--robot " VANTAGE_CONFIG_FOLDER "/robots/ur5.urdf --markers 4 --lockstep --out " +
                 folder_.string());
  EXPECT_EQ(code, 0) << text;
  EXPECT_NE(text.find("converged after"), std::string::npos) << text;
  EXPECT_TRUE(std::filesystem::exists(RunFolder() / "scenario.yaml"));
}

TEST_F(RunTest, AMissingMeshIsAWarningAndACapsule) {
  std::filesystem::create_directories(folder_ / "runs");
  std::ifstream in(std::string(VANTAGE_CONFIG_FOLDER) + "/robots/ur5.urdf");
  std::ostringstream urdf;
  urdf << in.rdbuf();
  const std::string path = (folder_ / "my.urdf").string();
  std::ofstream(path) << urdf.str();  // Its meshes stay behind.
  const auto [text, code] = VantageRun("--lockstep --time-limit 1 --robot " + path + " --out " +
                                       (folder_ / "runs").string());
  EXPECT_EQ(code, 1) << text;
  EXPECT_NE(text.find("warning: "), std::string::npos) << text;
  EXPECT_NE(text.find("forearm.dae"), std::string::npos) << text;
}

TEST_F(RunTest, FixedCameraInABadViewEndsWithExitCodeOne) {
  const auto [text, code] = VantageRun(
      "puma560-bad-view --camera fixed --time-limit 4 --lockstep --out " + folder_.string());
  EXPECT_EQ(code, 1) << text;
  EXPECT_NE(text.find("NOT converged"), std::string::npos) << text;
}

TEST_F(RunTest, BadInputIsOneLineExitCodeTwoAndNothingWritten) {
  for (const std::string arguments : {"no-such-scenario", "--camera sideways", "--time-limit -3"}) {
    const auto [text, code] = VantageRun(arguments + " --out " + folder_.string());
    EXPECT_EQ(code, 2) << arguments << ": " << text;
    EXPECT_FALSE(std::filesystem::exists(folder_)) << arguments;
  }
  const test::TemporaryFolder elsewhere;
  const std::string broken = elsewhere.Write(
      "broken.yaml", "robot: puma560\nmarkers:\n  - {id: 0, position: [0, 0, 0.02], radius: -1}\n");
  const auto [text, code] = VantageRun(broken + " --out " + folder_.string());
  EXPECT_EQ(code, 2);
  EXPECT_NE(text.find(broken + ":3: "), std::string::npos) << text;
  EXPECT_NE(text.find("radius"), std::string::npos) << text;
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1) << text;
  EXPECT_FALSE(std::filesystem::exists(folder_));
}

}  // namespace
}  // namespace vantage
