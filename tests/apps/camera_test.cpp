// vantage-camera as a process: a recorded still cell on the built-in hub, and a named pipe as the camera that
// is slow, hangs or is unplugged.

#include <csignal>
#include <filesystem>
#include <mutex>
#include <thread>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>
#include <sys/stat.h>
#include <unistd.h>

#include "any_port.h"
#include "becomes_true.h"
#include "contains.h"
#include "read_file.h"
#include "sim/world.h"
#include "temporary_folder.h"
#include "vantage/messaging/lcm_link.h"
#include "vantage/messaging/tcp_hub.h"
#include "vantage/robot/kinematics.h"
#include "vantage/runtime/child_process.h"

namespace vantage {
namespace {

constexpr int kImages = 20;

/// A hub, the program, and what came of it.
class Camera {
 public:
  Camera() : hub_(test::AnyPort()), link_({hub_.url(), ""}) {
    link_.Subscribe<ImageFeatures>(kImageFeaturesChannel,
                                   [this](const ImageFeatures& v) {
                                     const std::lock_guard lock(mutex_);
                                     features_.push_back(v);
                                   },
                                   {Delivery::kEvery, {}});
    link_.Start();
  }

  [[nodiscard]] ChildProcess Start(const std::vector<std::string>& arguments) {
    ChildOptions options;
    options.arguments = {std::string(VANTAGE_BIN) + "/vantage-camera"};
    options.arguments.insert(options.arguments.end(), arguments.begin(), arguments.end());
    options.environment["LCM_DEFAULT_URL"] = hub_.url();
    options.output = log();
    return ChildProcess(options);
  }

  /// Exit code and what was printed.
  std::pair<int, std::string> Run(const std::vector<std::string>& arguments) {
    ChildProcess child = Start(arguments);
    return End(&child);
  }
  std::pair<int, std::string> End(ChildProcess* child) {
    const auto status = child->WaitFor(std::chrono::seconds(60));
    return {status ? status->code : -1, text()};
  }

  /// What was printed so far.
  [[nodiscard]] std::string text() const { return test::ReadFile(log()); }
  [[nodiscard]] bool Says(const std::string& part) const {
    return test::BecomesTrue([&] { return test::Contains(text(), part); });
  }

  [[nodiscard]] std::vector<ImageFeatures> features() const {
    const std::lock_guard lock(mutex_);
    return features_;
  }
  [[nodiscard]] const std::filesystem::path& folder() const { return folder_.path(); }

 private:
  [[nodiscard]] std::string log() const { return (folder_.path() / "log.txt").string(); }

  test::TemporaryFolder folder_;
  TcpHub hub_;
  mutable std::mutex mutex_;
  std::vector<ImageFeatures> features_;
  LcmLink link_;
};

// The scenario's start, as its camera sees it.
GreyImage StillOf(const Scenario& scenario) {
  sim::Renderer renderer = sim::MakeRenderer(scenario);
  const sim::WorldView view = sim::World(scenario, Time{}).view();
  GreyImage image;
  renderer.RenderGrey(view.X_WC, view.scene, &image);
  return image;
}

constexpr double kDeviceRate = 30.0;  // As the device says itself [1/s].

/// A camera that anything can be done to: a video written to a named pipe.
class CameraDevice : public ::testing::Test {
 protected:
  CameraDevice() : path_((camera_.folder() / "device").string()) {
    std::signal(SIGPIPE, SIG_IGN);
    EXPECT_EQ(::mkfifo(path_.c_str(), 0600), 0);
  }
  ~CameraDevice() override { Unplug(); }

  [[nodiscard]] ChildProcess Start(const std::string& give_up) {
    return camera_.Start(
        {"planar-good-view", "--source", path_, "--image-rate", "0", "--give-up", give_up});
  }

  // Once the program listens.
  void PlugIn() {
    device_ = ::open(path_.c_str(), O_WRONLY);
    ASSERT_GE(device_, 0);
    Write("YUV4MPEG2 W" + std::to_string(still_.width) + " H" + std::to_string(still_.height) +
          " F" + std::to_string(static_cast<int>(kDeviceRate)) + ":1 Ip Cmono\n");
  }
  void Play(int images, double rate = kDeviceRate) {
    for (int i = 0; i < images; ++i) {
      Write("FRAME\n" + std::string(still_.pixels.begin(), still_.pixels.end()));
      std::this_thread::sleep_for(std::chrono::duration<double>(1.0 / rate));
    }
  }
  void Unplug() {
    if (device_ >= 0) ::close(device_);
    device_ = -1;
  }

  // The program ends well when it is told to, even while it waits for an image.
  std::string StopProgram(ChildProcess* program) {
    program->Signal(SIGTERM);
    auto [code, text] = camera_.End(program);
    EXPECT_EQ(code, 0) << text;
    EXPECT_TRUE(test::Contains(text, "stopped after ")) << text;
    return text;
  }
  // The program ends by itself, as a failure, after so many images.
  std::string ExpectToGiveUpAfter(int images, ChildProcess* program) {
    auto [code, text] = camera_.End(program);
    EXPECT_EQ(code, 3) << text;
    EXPECT_TRUE(test::Contains(
        text, "device is gone: giving up after " + std::to_string(images) + " images"))
        << text;
    return text;
  }

  Camera camera_;

 private:
  void Write(const std::string& bytes) const {
    for (std::size_t done = 0; done < bytes.size();) {
      const ssize_t n = ::write(device_, bytes.data() + done, bytes.size() - done);
      ASSERT_GT(n, 0) << camera_.text();
      done += static_cast<std::size_t>(n);
    }
  }

  std::string path_;
  GreyImage still_ = StillOf(LoadScenario("planar-good-view"));
  int device_{-1};
};

TEST_F(CameraDevice, ThatIsSlowIsNamedAndGoesOn) {
  ChildProcess program = Start("10");
  PlugIn();
  Play(32, 12.0);
  EXPECT_TRUE(camera_.Says("device is slow: ")) << camera_.text();
  EXPECT_TRUE(camera_.Says(" images/s of 30.0")) << camera_.text();
  const std::string text = StopProgram(&program);
  EXPECT_FALSE(test::Contains(text, "no image from")) << text;
}

TEST_F(CameraDevice, ThatStallsIsNamedAndGoesOn) {
  ChildProcess program = Start("30");
  PlugIn();
  Play(5);
  EXPECT_TRUE(
      camera_.Says("after 5 images, 5 of them with every marker that could be seen: stalled? "
                   "Waiting for 30.0 s"))
      << camera_.text();
  Play(5);
  EXPECT_TRUE(camera_.Says("device is back after ")) << camera_.text();
  // It hangs again, and the program ends all the same when told to.
  StopProgram(&program);
}

TEST_F(CameraDevice, ThatHangsForGoodEndsTheProgram) {
  ChildProcess program = Start("1.5");
  PlugIn();
  Play(5);
  const std::string text = ExpectToGiveUpAfter(5, &program);
  EXPECT_TRUE(test::Contains(text, "stalled?")) << text;
}

TEST_F(CameraDevice, ThatIsUnpluggedIsTakenUpAgain) {
  ChildProcess program = Start("30");
  PlugIn();
  Play(5);
  Unplug();
  EXPECT_TRUE(
      camera_.Says("after 5 images, 5 of them with every marker that could be seen: "
                   "unplugged? Waiting for 30.0 s"))
      << camera_.text();
  PlugIn();
  Play(5);
  EXPECT_TRUE(camera_.Says("device is back after ")) << camera_.text();
  StopProgram(&program);
}

TEST_F(CameraDevice, ThatIsUnpluggedForGoodEndsTheProgram) {
  ChildProcess program = Start("1");
  PlugIn();
  Play(5);
  Unplug();
  const std::string text = ExpectToGiveUpAfter(5, &program);
  EXPECT_TRUE(test::Contains(text, "unplugged?")) << text;
}

TEST_F(CameraDevice, ThatNeverAnswersEndsTheProgram) {
  ChildProcess program = Start("1");
  ExpectToGiveUpAfter(0, &program);
}

TEST(CameraProgram, PlaysASequenceToItsEndAndSaysSo) {
  Camera camera;
  Scenario scenario = LoadScenario("planar-good-view");
  scenario.sim.camera.focal_error = 0.0;
  GreyImage image = StillOf(scenario);
  for (int i = 0; i < kImages; ++i) {
    char name[32];
    std::snprintf(name, sizeof name, "%03d.png", i);
    cv::imwrite((camera.folder() / name).string(),
                cv::Mat(image.height, image.width, CV_8U, image.pixels.data()));
  }
  const auto [code, text] =
      camera.Run({"planar-good-view", "--source", (camera.folder() / "%03d.png").string(), "--rate",
                  "50", "--image-rate", "0"});
  EXPECT_EQ(code, 0) << text;
  EXPECT_NE(text.find("end of image sequence"), std::string::npos) << text;
  EXPECT_NE(text.find("after 20 images, 20 of them with every marker"), std::string::npos) << text;
  const std::vector<ImageFeatures> features = camera.features();
  // The first may be sent before the hub knows that anybody listens.
  ASSERT_GT(features.size(), 10U);
  const ViewModel& view = scenario.task.view;
  const Eigen::Isometry3d X_CW = RigPose(scenario.rig, scenario.q_c_start).inverse();
  const Eigen::Vector3d p_C =
      X_CW * (EndEffectorPose(view.arm, scenario.sim.q_start) * view.markers[0].p);
  const Eigen::Vector2d wanted = ToPixel(view.camera, p_C.head<2>() / p_C.z());
  for (const ImageFeatures& f : features) {
    ASSERT_EQ(f.count, 1);
    ASSERT_TRUE(f.markers[0].valid);
    EXPECT_LT((f.markers[0].pixel - wanted).norm(), 0.05);
    EXPECT_LE(f.exposure, f.stamp);
  }
}

TEST(CameraProgram, RefusesImagesOfAnotherSize) {
  Camera camera;
  // Two: newer OpenCV takes a pattern with one image for the name of a file.
  for (const char* name : {"000.png", "001.png"}) {
    cv::imwrite((camera.folder() / name).string(), cv::Mat::zeros(240, 320, CV_8U));
  }
  const auto [code, text] = camera.Run(
      {"planar-good-view", "--source", (camera.folder() / "%03d.png").string(), "--fast"});
  EXPECT_EQ(code, 2) << text;
  EXPECT_NE(text.find("320x240"), std::string::npos) << text;
}

TEST(CameraProgram, NamesWhatCannotBeOpened) {
  Camera camera;
  const auto [code, text] = camera.Run({"planar-good-view", "--source", "/dev/video97"});
  EXPECT_EQ(code, 2) << text;
  EXPECT_NE(text.find("cannot open device /dev/video97"), std::string::npos) << text;
}

}  // namespace
}  // namespace vantage
