#include "vantage/vision/marker_tracker.h"

#include <vector>

#include <gtest/gtest.h>

#include "eigen_matchers.h"
#include "synthetic.h"
#include "vantage/math/angles.h"

namespace vantage {
namespace {

using Eigen::Vector2d;
using test::DrawDot;
using test::Shape;

constexpr double kRadius = 6.0;

CameraModel Camera() {
  CameraModel camera;
  camera.width = 320;
  camera.height = 240;
  camera.u0 = 159.5;
  camera.v0 = 119.5;
  return camera;
}

std::vector<MarkerPrediction> Predict(const std::vector<Vector2d>& pixels) {
  std::vector<MarkerPrediction> predictions;
  for (const Vector2d& pixel : pixels) {
    MarkerPrediction prediction;
    prediction.id = static_cast<int>(predictions.size()) + 1;
    prediction.expected = InImage(Camera(), pixel);
    prediction.image.centre = prediction.image.centroid = pixel;
    prediction.image.shape = Shape(kRadius, kRadius, 0.0);
    prediction.image.area = kPi * kRadius * kRadius;
    prediction.image.cos_incidence = 1.0;
    predictions.push_back(prediction);
  }
  return predictions;
}

GreyImage Draw(const std::vector<Vector2d>& pixels) {
  GreyImage image = test::Blank(320, 240);
  for (const Vector2d& pixel : pixels) DrawDot(&image, pixel, Shape(kRadius, kRadius, 0.0), true);
  return image;
}

std::vector<Vector2d> Triangle(const Vector2d& centre) {
  return {centre + Vector2d(-30.0, -20.0), centre + Vector2d(35.0, -10.0),
          centre + Vector2d(5.0, 30.0)};
}

Time At(int frame) {
  return Time(FromSeconds(0.01 * frame));
}

int CountValid(const MarkerDetections& detections) {
  int valid = 0;
  for (const MarkerDetection& detection : detections) valid += detection.valid() ? 1 : 0;
  return valid;
}

// The model is 25 px off: found in the whole image once, followed by windows from then on.
TEST(MarkerTracker, LearnsTheModelsBias) {
  MarkerTracker tracker(Camera(), {});
  const Vector2d bias(20.0, -15.0);
  for (int frame = 0; frame < 30; ++frame) {
    const Vector2d centre(120.0 + 2.0 * frame, 110.0);
    const auto predictions = Predict(Triangle(centre));
    const auto& plan = tracker.Plan(predictions, At(frame));
    EXPECT_EQ(plan.whole_image, frame == 0);
    const GreyImage image = Draw(Triangle(centre + bias));
    const MarkerDetections& detections = tracker.Track(View(image), predictions, At(frame));
    ASSERT_EQ(CountValid(detections), 3) << "frame " << frame;
    EXPECT_TRUE(test::Near(detections[0].centroid, Triangle(centre + bias)[0], 0.03));
  }
  EXPECT_EQ(tracker.acquisitions(), 1);
}

// Nothing but a constant prediction: the offset's rate carries a moving marker.
TEST(MarkerTracker, FollowsMotionTheModelDoesNotKnow) {
  MarkerTracker tracker(Camera(), {});
  const auto predictions = Predict(Triangle({100.0, 110.0}));
  for (int frame = 0; frame < 25; ++frame) {
    const auto truth = Triangle({100.0 + 0.15 * frame * frame, 110.0});
    const GreyImage image = Draw(truth);
    const MarkerDetections& detections = tracker.Track(View(image), predictions, At(frame));
    ASSERT_EQ(CountValid(detections), 3) << "frame " << frame;
    EXPECT_TRUE(test::Near(detections[2].centroid, truth[2], 0.03));
  }
  EXPECT_EQ(tracker.acquisitions(), 0);
}

TEST(MarkerTracker, WindowsHoldTheMarkers) {
  MarkerTracker tracker(Camera(), {});
  const auto predictions = Predict(Triangle({150.0, 110.0}));
  const GreyImage image = Draw(Triangle({153.0, 112.0}));
  tracker.Track(View(image), predictions, At(0));
  const auto& plan = tracker.Plan(predictions, At(1));
  ASSERT_FALSE(plan.whole_image);
  ASSERT_EQ(plan.windows.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    const Vector2d p = Triangle({153.0, 112.0})[i];
    EXPECT_TRUE(plan.windows[i].contains(static_cast<int>(p.x() - 2 * kRadius),
                                         static_cast<int>(p.y() - 2 * kRadius)));
    EXPECT_TRUE(plan.windows[i].contains(static_cast<int>(p.x() + 2 * kRadius),
                                         static_cast<int>(p.y() + 2 * kRadius)));
  }
}

// One marker is covered for a while, then comes back: the others carry its place.
TEST(MarkerTracker, FindsACoveredMarkerAgain) {
  MarkerTracker tracker(Camera(), {});
  const Vector2d bias(14.0, 9.0);
  for (int frame = 0; frame < 60; ++frame) {
    const Vector2d centre(120.0 + frame, 100.0);
    auto truth = Triangle(centre + bias);
    const Vector2d hidden = truth[1];
    if (frame >= 10 && frame < 50) truth.erase(truth.begin() + 1);
    const GreyImage image = Draw(truth);
    const MarkerDetections& detections =
        tracker.Track(View(image), Predict(Triangle(centre)), At(frame));
    if (frame >= 10 && frame < 50) {
      EXPECT_FALSE(detections[1].valid());
      EXPECT_EQ(CountValid(detections), 2);
    } else {
      ASSERT_TRUE(detections[1].valid()) << "frame " << frame << " " << Name(detections[1].fault);
      EXPECT_TRUE(test::Near(detections[1].centroid, hidden, 0.03));
    }
  }
  // The whole image is searched at the retry interval (10 frames), not in each one.
  EXPECT_LE(tracker.acquisitions(), 6);
}

TEST(MarkerTracker, StartsAnewWhenTimeStepsBack) {
  MarkerTracker tracker(Camera(), {});
  const auto predictions = Predict(Triangle({150.0, 110.0}));
  const GreyImage image = Draw(Triangle({160.0, 110.0}));
  EXPECT_EQ(CountValid(tracker.Track(View(image), predictions, At(100))), 3);
  EXPECT_EQ(CountValid(tracker.Track(View(image), predictions, At(3))), 3);
  EXPECT_FALSE(tracker.Plan(predictions, At(4)).whole_image);
}

TEST(MarkerTracker, PublishesAllNames) {
  MarkerTracker tracker(Camera(), {});
  const auto predictions = Predict(Triangle({150.0, 110.0}));
  auto truth = Triangle({150.0, 110.0});
  truth.pop_back();
  const GreyImage image = Draw(truth);
  tracker.Track(View(image), predictions, At(0));
  ImageFeatures features;
  tracker.Publish(&features);
  ASSERT_EQ(features.count, 3);
  ASSERT_NE(features.Find(1), nullptr);
  EXPECT_TRUE(features.Find(1)->valid);
  EXPECT_TRUE(test::Near(features.Find(1)->pixel, truth[0], 0.03));
  EXPECT_FALSE(features.Find(3)->valid);
}

}  // namespace
}  // namespace vantage
