// All threads of vantage-servo at work at once, with an arm and a camera that this test plays. tools/check tsan runs
// it in a build whose every data race ends the servo with an exit code of its own.

#include <atomic>
#include <csignal>
#include <fstream>
#include <mutex>
#include <string>
#include <thread>

#include <gtest/gtest.h>

#include "any_port.h"
#include "becomes_true.h"
#include "read_file.h"
#include "temporary_folder.h"
#include "vantage/camera/camera_rig.h"
#include "vantage/camera/pinhole.h"
#include "vantage/config/scenario.h"
#include "vantage/messaging/lcm_link.h"
#include "vantage/messaging/tcp_hub.h"
#include "vantage/runtime/child_process.h"

namespace vantage {
namespace {

constexpr double kStep = 0.004;  // of the arm and its messages [s]
constexpr int kStepsBetweenImages = 5;

// The cell of a scenario: takes the joint positions and camera poses that it is told at once, sees every marker. One that
// integrated velocities would run ahead of a servo that a sanitiser on a busy machine makes late, or fall behind.
class PlayedCell {
 public:
  explicit PlayedCell(const Scenario& scenario)
      : scenario_(scenario),
        hub_(test::AnyPort()),
        link_({hub_.url(), ""}),
        q_(scenario.sim.q_start),
        qdot_(JointVector::Zero(q_.size())),
        X_WC_(RigPose(scenario.rig, scenario.q_c_start)) {
    link_.Subscribe<JointCommand>(kJointCommandChannel, [this](const JointCommand& command) {
      const std::lock_guard lock(mutex_);
      if (command.q.size() != q_.size()) return;
      q_ = command.q;
      qdot_ = command.qdot;
    });
    link_.Subscribe<CameraPose>(kCameraPoseCommandChannel, [this](const CameraPose& pose) {
      const std::lock_guard lock(mutex_);
      X_WC_ = pose.X_WC;
    });
    link_.Subscribe<ServoStatus>(kServoStatusChannel, [this](const ServoStatus& status) {
      const std::lock_guard lock(mutex_);
      status_ = status;
    });
    link_.Subscribe<ObservabilityReport>(kObservabilityChannel,
                                         [this](const ObservabilityReport& report) {
                                           const std::lock_guard lock(mutex_);
                                           camera_moves_ = report.camera_moves;
                                         });
    link_.Start();
    thread_ = std::thread([this] { Play(); });
  }
  ~PlayedCell() {
    done_ = true;
    thread_.join();
  }
  PlayedCell(const PlayedCell&) = delete;
  PlayedCell& operator=(const PlayedCell&) = delete;

  [[nodiscard]] std::string url() const { return hub_.url(); }
  [[nodiscard]] ServoStatus status() const {
    const std::lock_guard lock(mutex_);
    return status_;
  }
  [[nodiscard]] std::int64_t camera_moves() const {
    const std::lock_guard lock(mutex_);
    return camera_moves_;
  }

 private:
  void Play() {
    for (int step = 0; !done_; ++step) {
      std::this_thread::sleep_for(FromSeconds(kStep));
      JointState joints;
      CameraPose pose;
      {
        const std::lock_guard lock(mutex_);
        joints = {Clock::now(), q_, qdot_};
        pose = {joints.stamp, X_WC_};
      }
      link_.Publish(kJointStateChannel, joints);
      link_.Publish(kCameraPoseChannel, pose);
      if (step % kStepsBetweenImages == 0) link_.Publish(kImageFeaturesChannel, See(joints, pose));
    }
  }

  [[nodiscard]] ImageFeatures See(const JointState& joints, const CameraPose& pose) const {
    const ViewModel& view = scenario_.task.view;
    ImageFeatures image;
    image.stamp = image.exposure = joints.stamp;
    image.X_WC = pose.X_WC;
    const Eigen::Isometry3d X_CE = pose.X_WC.inverse() * EndEffectorPose(view.arm, joints.q);
    for (const Marker& marker : view.markers) {
      const auto point = Project(X_CE * marker.p);
      MarkerMeasurement& seen = image.markers[static_cast<std::size_t>(image.count++)];
      seen.id = marker.id;
      seen.valid = point.has_value();
      if (point) seen.pixel = ToPixel(view.camera, point->n);
    }
    return image;
  }

  Scenario scenario_;
  TcpHub hub_;
  mutable std::mutex mutex_;
  LcmLink link_;
  JointVector q_, qdot_;
  Eigen::Isometry3d X_WC_;
  ServoStatus status_;
  std::int64_t camera_moves_{0};
  std::atomic<bool> done_{false};
  std::thread thread_;
};

// With rehearsals ahead of each period, which are what a servo of real-time priority does, and without.
class ServoThreads : public testing::TestWithParam<const char*> {};

TEST_P(ServoThreads, ServoWithAMovingCameraAndEndInOrder) {
  const test::TemporaryFolder folder;
  const std::string said = (folder.path() / "servo.txt").string();
  // At a third of the usual rate: under a sanitiser on a busy machine messages would pile up, and the arm would rightly
  // be found not to follow.
  std::string text = test::ReadFile(VANTAGE_CONFIG_FOLDER "/scenarios/planar-grazing-view.yaml");
  const std::string section = "\nservo:\n";
  ASSERT_NE(text.find(section), std::string::npos);
  text.insert(text.find(section) + section.size(), "  period: 0.006\n");
  const std::string scenario = (folder.path() / "slow.yaml").string();
  std::ofstream(scenario) << text;
  PlayedCell cell(LoadScenario(scenario));
  ChildOptions options;
  options.arguments = {VANTAGE_SERVO, scenario, "--priority", "0", GetParam()};
  options.environment["LCM_DEFAULT_URL"] = cell.url();
  options.environment["TSAN_OPTIONS"] = "exitcode=66:suppressions=" VANTAGE_TSAN_SUPPRESSIONS;
  options.output = said;
  ChildProcess servo(options);
  EXPECT_TRUE(test::BecomesTrue([&] { return cell.camera_moves() > 0; })) << "no camera move";
  EXPECT_TRUE(test::BecomesTrue([&] { return cell.status().state == ServoState::kConverged; }))
      << Name(cell.status().state) << " " << Name(cell.status().reason);
  EXPECT_GT(cell.status().seq, 500);
  servo.Signal(SIGINT);
  const auto end = servo.WaitFor(std::chrono::seconds(20));
  text = test::ReadFile(said);
  ASSERT_TRUE(end.has_value()) << text;
  EXPECT_TRUE(end->success()) << end->ToString() << "\n" << text;
  EXPECT_EQ(text.find("ThreadSanitizer"), std::string::npos) << text;
  EXPECT_NE(text.find("last state"), std::string::npos) << text;
}
INSTANTIATE_TEST_SUITE_P(Rehearsals, ServoThreads, testing::Values("--rehearse", "--no-rehearse"),
                         [](const auto& value) {
                           return value.param == std::string("--rehearse") ? "With" : "Without";
                         });

}  // namespace
}  // namespace vantage
