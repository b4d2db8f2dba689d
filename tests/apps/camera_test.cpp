// vantage-camera as a process: a recorded still cell on the built-in hub.

#include <filesystem>
#include <fstream>
#include <mutex>
#include <sstream>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include "any_port.h"
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

  /// Exit code and what was printed.
  std::pair<int, std::string> Run(std::vector<std::string> arguments) {
    const std::string log = (folder_.path() / "log.txt").string();
    ChildOptions options;
    options.arguments = {std::string(VANTAGE_BIN) + "/vantage-camera"};
    options.arguments.insert(options.arguments.end(), arguments.begin(), arguments.end());
    options.environment["LCM_DEFAULT_URL"] = hub_.url();
    options.output = log;
    ChildProcess child(options);
    const auto status = child.WaitFor(std::chrono::seconds(60));
    std::ostringstream text;
    text << std::ifstream(log).rdbuf();
    return {status ? status->code : -1, text.str()};
  }

  [[nodiscard]] std::vector<ImageFeatures> features() const {
    const std::lock_guard lock(mutex_);
    return features_;
  }
  [[nodiscard]] const std::filesystem::path& folder() const { return folder_.path(); }

 private:
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
