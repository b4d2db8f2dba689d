// What the simulator's camera saw, recorded and played back through CameraSource.

#include <filesystem>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>

#include "sim/effects.h"
#include "temporary_folder.h"
#include "toy_scene.h"
#include "vantage/math/error.h"
#include "vantage/vision/camera_source.h"
#include "vantage/vision/marker_tracker.h"

namespace vantage::sim {
namespace {

using Eigen::Vector3d;

constexpr int kFrames = 12;

Time At(int frame) {
  return Time(FromSeconds(frame / 60.0));
}

// A moving arm with noise: images, predictions and the features found in them.
struct Recording {
  std::vector<cv::Mat> images;
  std::vector<std::vector<MarkerPrediction>> predictions;
  std::vector<ImageFeatures> features;
};

const Recording& Record() {
  static const Recording recording = [] {
    Recording result;
    const auto markers = test::ToolMarkers(0.012, 0.035, Vector3d::UnitX(), true);
    Renderer renderer = test::MakeRenderer(test::Camera(), test::ToyScene(markers, {}));
    const Eigen::Isometry3d X_WC = test::LookAt({1.6, 0.4, 0.9}, {0.6, 0.1, 0.4});
    EffectChain chain({2.0, 0.6, 0.1, 0.1}, 5);
    MarkerTracker tracker(renderer.camera(), {});
    for (int i = 0; i < kFrames; ++i) {
      const SceneState state = test::ToyState(0.2 + 0.01 * i, -0.6, 0.6);
      GreyImage image;
      renderer.RenderGrey(X_WC, state, &image);
      chain.Begin(At(i));
      chain.Apply(&image);
      result.images.push_back(
          cv::Mat(image.height, image.width, CV_8U, image.pixels.data()).clone());
      result.predictions.emplace_back();
      PredictMarkers(renderer.camera(), X_WC.inverse(), X_WC.inverse() * state.X_WE, markers, {},
                     &result.predictions.back());
      tracker.Track(View(image), result.predictions.back(), At(i));
      result.features.emplace_back();
      tracker.Publish(&result.features.back());
    }
    return result;
  }();
  return recording;
}

// Plays a source to its end; the largest difference of a marker's place [px].
double Play(CameraSource* source) {
  const Recording& recording = Record();
  MarkerTracker tracker(test::Camera(), {});
  GreyImage image;
  Time exposure;
  Time last{};
  double worst = 0.0;
  int frame = 0;
  GrabStatus status;
  while ((status = source->Grab(&image, &exposure)) == GrabStatus::kImage) {
    EXPECT_GT(exposure, last);
    last = exposure;
    if (frame >= kFrames) return 1e9;
    tracker.Track(View(image), recording.predictions[frame], At(frame));
    ImageFeatures features;
    tracker.Publish(&features);
    const ImageFeatures& wanted = recording.features[frame];
    EXPECT_EQ(features.count, wanted.count);
    for (int k = 0; k < wanted.count; ++k) {
      EXPECT_TRUE(wanted.markers[k].valid) << "image " << frame;
      EXPECT_EQ(features.markers[k].valid, wanted.markers[k].valid) << "image " << frame;
      worst = std::max(worst, (features.markers[k].pixel - wanted.markers[k].pixel).norm());
    }
    ++frame;
  }
  EXPECT_EQ(status, GrabStatus::kEndOfFile);
  EXPECT_EQ(frame, kFrames);
  return worst;
}

TEST(Playback, OfAnImageSequenceGivesTheSameFeatures) {
  const vantage::test::TemporaryFolder folder;
  for (int i = 0; i < kFrames; ++i) {
    char name[32];
    std::snprintf(name, sizeof name, "%05d.png", i);
    cv::imwrite((folder.path() / name).string(), Record().images[static_cast<std::size_t>(i)]);
  }
  const auto source = OpenVideo((folder.path() / "%05d.png").string());
  EXPECT_TRUE(source->is_file());
  EXPECT_EQ(Play(source.get()), 0.0);
}

TEST(Playback, OfAVideoGivesTheSameFeatures) {
  const vantage::test::TemporaryFolder folder;
  const std::string path = (folder.path() / "cell.avi").string();
  {
    cv::VideoWriter writer(path, cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), 60.0,
                           cv::Size(640, 480), false);
    ASSERT_TRUE(writer.isOpened());
    writer.set(cv::VIDEOWRITER_PROP_QUALITY, 100.0);
    for (const cv::Mat& image : Record().images) writer.write(image);
  }
  const auto source = OpenVideo(path);
  EXPECT_NEAR(source->nominal_rate(), 60.0, 0.01);
  // JPEG costs something.
  EXPECT_LT(Play(source.get()), 0.05);
}

TEST(Playback, OfWhatIsNotThereNamesIt) {
  for (const char* source :
       {"/no/such/file.avi", "/dev/video97", "97", "nonsense ! appsink", "/no/such/%05d.png"}) {
    try {
      (void)OpenVideo(source);
      ADD_FAILURE() << source;
    } catch (const ConfigError& error) {
      EXPECT_NE(std::string(error.what()).find(source), std::string::npos) << error.what();
    }
  }
}

}  // namespace
}  // namespace vantage::sim
