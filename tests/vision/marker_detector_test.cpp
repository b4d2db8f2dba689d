#include "vantage/vision/marker_detector.h"

#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "allocation_guard.h"
#include "eigen_matchers.h"
#include "synthetic.h"
#include "vantage/math/angles.h"

namespace vantage {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using test::Blank;
using test::DrawDot;
using test::Shape;

CameraModel Camera() {
  CameraModel camera;
  camera.width = 320;
  camera.height = 240;
  camera.u0 = 159.5;
  camera.v0 = 119.5;
  return camera;
}

GreyImage Field() {
  return Blank(320, 240);
}

MarkerPrediction At(int id, const Vector2d& pixel, double radius = 7.0, bool dark = true,
                    int group = 0) {
  MarkerPrediction prediction;
  prediction.id = id;
  prediction.group = group;
  prediction.dark = dark;
  prediction.expected = true;
  prediction.image.centre = prediction.image.centroid = pixel;
  prediction.image.shape = Shape(radius, radius, 0.0);
  prediction.image.area = kPi * radius * radius;
  prediction.image.depth = 1.0;
  prediction.image.cos_incidence = 1.0;
  return prediction;
}

std::vector<MarkerPrediction> Square(const Vector2d& centre, double spread, int first_id = 1,
                                     int group = 0) {
  std::vector<MarkerPrediction> predictions;
  for (int i = 0; i < 4; ++i) {
    const Vector2d corner((i & 1) != 0 ? spread : -spread, (i & 2) != 0 ? spread : -spread);
    predictions.push_back(At(first_id + i, centre + corner, 7.0, true, group));
  }
  return predictions;
}

MarkerDetections Detect(const GreyImage& image, const std::vector<MarkerPrediction>& predictions) {
  MarkerDetections detections;
  DetectMarkers(View(image), Camera(), predictions, {}, &detections);
  return detections;
}

TEST(DetectMarkers, FindsMarkersAwayFromTheirPredictions) {
  for (const Vector2d& shift : {Vector2d(0.0, 0.0), Vector2d(7.0, -5.0), Vector2d(-11.0, 9.0)}) {
    GreyImage image = Field();
    std::vector<MarkerPrediction> predictions{At(3, {100.0, 90.0}),
                                              At(8, {200.0, 150.0}, 7.0, false)};
    for (const MarkerPrediction& p : predictions) {
      DrawDot(&image, p.image.centroid + shift, p.image.shape, p.dark);
    }
    const MarkerDetections detections = Detect(image, predictions);
    ASSERT_EQ(detections.size(), 2U);
    for (std::size_t i = 0; i < 2; ++i) {
      EXPECT_EQ(detections[i].id, predictions[i].id);
      ASSERT_TRUE(detections[i].valid()) << Name(detections[i].fault);
      EXPECT_TRUE(test::Near(detections[i].centroid, predictions[i].image.centroid + shift, 0.02));
    }
  }
}

TEST(DetectMarkers, LeavesOutWhatIsNotExpected) {
  GreyImage image = Field();
  std::vector<MarkerPrediction> predictions{At(1, {100.0, 90.0})};
  DrawDot(&image, predictions[0].image.centroid, predictions[0].image.shape, true);
  predictions[0].expected = false;
  EXPECT_EQ(Detect(image, predictions)[0].fault, MarkerFault::kNotExpected);
}

TEST(DetectMarkers, RefusesAnotherSize) {
  GreyImage image = Field();
  DrawDot(&image, {100.0, 90.0}, Shape(7.0, 7.0, 0.0), true);
  EXPECT_EQ(Detect(image, {At(1, {100.0, 90.0}, 7.6)})[0].fault, MarkerFault::kWrongArea);
  EXPECT_EQ(Detect(image, {At(1, {100.0, 90.0}, 6.4)})[0].fault, MarkerFault::kWrongArea);
  EXPECT_TRUE(Detect(image, {At(1, {100.0, 90.0}, 7.1)})[0].valid());
}

TEST(DetectMarkers, OneDotHasNotTwoNames) {
  GreyImage image = Field();
  DrawDot(&image, {100.0, 90.0}, Shape(7.0, 7.0, 0.0), true);
  for (const MarkerDetection& detection :
       Detect(image, {At(1, {100.0, 90.0}), At(2, {104.0, 90.0})})) {
    EXPECT_EQ(detection.fault, MarkerFault::kAmbiguous);
  }
}

TEST(DetectMarkers, DoesNotAllocate) {
  GreyImage image = Field();
  const std::vector<MarkerPrediction> predictions = Square({160.0, 120.0}, 40.0);
  for (const MarkerPrediction& p : predictions) {
    DrawDot(&image, p.image.centroid, p.image.shape, p.dark);
  }
  DrawDot(&image, {100.0, 90.0}, Shape(7.0, 7.0, 0.0), true);
  MarkerDetections detections;
  detections.reserve(predictions.size());
  if (!test::AllocationGuard::kSupported) GTEST_SKIP() << "sanitizers own the allocator";
  const test::AllocationGuard guard;
  DetectMarkers(View(image), Camera(), predictions, {}, &detections);
  EXPECT_EQ(guard.count(), 0U);
}

TEST(PublishedPixel, IsTheProjectedCentreWithoutDistortion) {
  CameraModel camera = Camera();
  camera.distortion = {-0.2, 0.05, 3e-4, -2e-4, 0.0};
  const auto predicted =
      ProjectDisc(camera, {0.08, -0.06, 0.5}, Vector3d(0.7, 0.2, -0.7).normalized(), 0.02);
  ASSERT_TRUE(predicted.has_value());
  EXPECT_GT((predicted->centre - predicted->centroid).norm(), 0.3);
  EXPECT_TRUE(
      test::Near(PublishedPixel(camera, *predicted, predicted->centroid), predicted->centre, 1e-9));
}

TEST(PredictMarker, KnowsWhatTheCameraCannotSee) {
  const CameraModel camera = Camera();
  Marker marker;
  marker.normal = -Vector3d::UnitZ();
  const auto at = [&](const Vector3d& p) { return Eigen::Isometry3d(Eigen::Translation3d(p)); };
  EXPECT_TRUE(PredictMarker(camera, at({0.0, 0.0, 1.0}), marker, 0).expected);
  EXPECT_FALSE(PredictMarker(camera, at({0.0, 0.0, -1.0}), marker, 0).expected);
  EXPECT_FALSE(PredictMarker(camera, at({2.0, 0.0, 1.0}), marker, 0).expected);
  marker.normal = Vector3d::UnitZ();
  EXPECT_FALSE(PredictMarker(camera, at({0.0, 0.0, 1.0}), marker, 0).expected);
}

TEST(FindDiscs, FindsEachDotOnceAndNothingElse) {
  GreyImage image = Field();
  const std::vector<Vector2d> dark{{40.0, 40.0}, {90.5, 60.2}, {200.3, 180.9}};
  for (const Vector2d& p : dark) DrawDot(&image, p, Shape(7.0, 5.0, 0.7), true);
  DrawDot(&image, {250.0, 60.0}, Shape(7.0, 5.0, 0.7), false);
  test::DrawBox(&image, {120, 100, 20, 20}, 25);
  DiscOptions options;
  options.max_semi_axis = 20.0;
  const std::vector<DiscBlob> found = FindDiscs(View(image), true, 5.0, options);
  ASSERT_EQ(found.size(), dark.size());
  for (std::size_t i = 0; i < dark.size(); ++i) {
    EXPECT_TRUE(test::Near(found[i].centroid, dark[i], 0.02));
  }
  EXPECT_EQ(FindDiscs(View(image), false, 5.0, options).size(), 1U);
}

MarkerDetections Acquire(const GreyImage& image, const std::vector<MarkerPrediction>& predictions) {
  return AcquireMarkers(View(image), Camera(), predictions, {}, {});
}

// The model is wrong for all markers alike: shifted, turned and scaled.
TEST(AcquireMarkers, NamesAShiftedAndTurnedGroup) {
  const std::vector<MarkerPrediction> predictions = Square({140.0, 110.0}, 25.0);
  Eigen::Matrix2d turn;
  turn << std::cos(0.3), -std::sin(0.3), std::sin(0.3), std::cos(0.3);
  std::vector<Vector2d> truth;
  GreyImage image = Field();
  for (const MarkerPrediction& p : predictions) {
    truth.push_back(Vector2d(175.0, 130.0) +
                    1.15 * turn * (p.image.centroid - Vector2d(140.0, 110.0)));
    DrawDot(&image, truth.back(), Shape(7.6, 7.6, 0.0), true);
  }
  const MarkerDetections detections = Acquire(image, predictions);
  for (std::size_t i = 0; i < truth.size(); ++i) {
    ASSERT_TRUE(detections[i].valid()) << Name(detections[i].fault);
    EXPECT_TRUE(test::Near(detections[i].centroid, truth[i], 0.02));
  }
}

TEST(AcquireMarkers, NamesThoseSeenWhenOneIsCovered) {
  const std::vector<MarkerPrediction> predictions = Square({140.0, 110.0}, 25.0);
  GreyImage image = Field();
  const Vector2d shift(18.0, -14.0);
  for (std::size_t i = 0; i < 3; ++i) {
    DrawDot(&image, predictions[i].image.centroid + shift, Shape(7.0, 7.0, 0.0), true);
  }
  const MarkerDetections detections = Acquire(image, predictions);
  for (std::size_t i = 0; i < 3; ++i) {
    ASSERT_TRUE(detections[i].valid()) << Name(detections[i].fault);
    EXPECT_TRUE(test::Near(detections[i].centroid, predictions[i].image.centroid + shift, 0.02));
  }
  EXPECT_FALSE(detections[3].valid());
}

// Two dots, predicted far away: either could be the one marker there is.
TEST(AcquireMarkers, DoesNotGuess) {
  GreyImage image = Field();
  DrawDot(&image, {100.0, 120.0}, Shape(7.0, 7.0, 0.0), true);
  DrawDot(&image, {180.0, 122.0}, Shape(7.0, 7.0, 0.0), true);
  EXPECT_EQ(Acquire(image, {At(1, {140.0, 90.0})})[0].fault, MarkerFault::kAmbiguous);
  EXPECT_TRUE(Acquire(image, {At(1, {104.0, 118.0})})[0].valid());
}

// One group is hidden: it must not take the other's dots.
TEST(AcquireMarkers, GroupsDoNotStealFromOneAnother) {
  std::vector<MarkerPrediction> predictions = Square({120.0, 110.0}, 25.0, 1, 0);
  const std::vector<MarkerPrediction> goal = Square({180.0, 130.0}, 25.0, 11, 1);
  predictions.insert(predictions.end(), goal.begin(), goal.end());
  GreyImage image = Field();
  for (const MarkerPrediction& p : goal) {
    DrawDot(&image, p.image.centroid + Vector2d(3.0, 2.0), p.image.shape, true);
  }
  const MarkerDetections detections = Acquire(image, predictions);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_FALSE(detections[i].valid());
    EXPECT_TRUE(detections[4 + i].valid()) << Name(detections[4 + i].fault);
  }
}

TEST(AcquireMarkers, KeepsToPolarityAndSize) {
  GreyImage image = Field();
  DrawDot(&image, {100.0, 120.0}, Shape(7.0, 7.0, 0.0), false);
  DrawDot(&image, {200.0, 120.0}, Shape(14.0, 14.0, 0.0), true);
  EXPECT_FALSE(Acquire(image, {At(1, {150.0, 120.0})})[0].valid());
}

}  // namespace
}  // namespace vantage
