// AprilTags as they are drawn, through ViSP's detector.

#include <algorithm>
#include <random>

#include <gtest/gtest.h>

#include "eigen_matchers.h"
#include "sim/effects.h"
#include "sim/render/renderer.h"
#include "sim/render/tag_bodies.h"
#include "toy_scene.h"
#include "vantage/math/error.h"
#include "vantage/vision/marker_tracker.h"

namespace vantage::sim {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

Tag MakeTag(int id) {
  Tag tag;
  tag.id = id;
  tag.size = 0.1;
  return tag;
}

Renderer RendererOf(const Tag& tag) {
  Scene scene;
  scene.floor.visible = false;
  AddTags({tag}, &scene);
  return test::MakeRenderer(test::Camera(), scene);
}

// Each corner by its name, with no bias: ViSP's own pixels are half a pixel off.
TEST(RenderedTags, CornersAreWhereTheModelPutsThem) {
  const Tag tag = MakeTag(7);
  Renderer renderer = RendererOf(tag);
  const std::vector<Marker> markers = TagMarkers(tag);
  TagDetector detector;
  EffectChain chain({0.0, 0.8, 0.0, 1.0}, 1);  // A lens is never as sharp as drawn edges.
  std::mt19937 random(4);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  Vector2d bias = Vector2d::Zero();
  double worst = 0.0;
  int found = 0;
  GreyImage image;
  MarkerDetections detections;
  for (int i = 0; i < 25; ++i) {
    const Vector3d eye(0.25 * uniform(random), 0.25 * uniform(random), 0.5 + 0.1 * uniform(random));
    const Isometry3d X_WC = test::LookAt(eye, 0.02 * Vector3d(uniform(random), uniform(random), 0),
                                         3 * uniform(random));
    renderer.RenderGrey(X_WC, {}, &image);
    chain.Begin(Time{});
    chain.Apply(&image);
    std::vector<MarkerPrediction> predictions;
    PredictMarkers(renderer.camera(), X_WC.inverse(), X_WC.inverse(), markers, {}, &predictions);
    detector.Detect(View(image), renderer.camera(), predictions, {}, 20.0, &detections);
    for (std::size_t k = 0; k < markers.size(); ++k) {
      if (!detections[k].valid()) continue;
      const Vector2d error = detections[k].pixel - predictions[k].image.centre;
      bias += error;
      worst = std::max(worst, error.norm());
      ++found;
    }
  }
  EXPECT_EQ(found, 100);
  bias /= found;
  EXPECT_TRUE(vantage::test::Near(bias, Vector2d(0.0, 0.0), 0.03));
  EXPECT_LT(worst, 0.4);
}

TEST(RenderedTags, AreFollowedByTheTrackerAndRefusedFarFromTheirPlace) {
  const Tag tag = MakeTag(3);
  Renderer renderer = RendererOf(tag);
  TrackerOptions options;
  options.kind = DetectorKind::kAprilTag;
  options.acquisition.max_shift = 40.0;
  const Isometry3d X_WC = test::LookAt({0.1, 0.05, 0.6}, Vector3d::Zero());
  GreyImage image;
  renderer.RenderGrey(X_WC, {}, &image);
  std::vector<MarkerPrediction> predictions;
  PredictMarkers(renderer.camera(), X_WC.inverse(), X_WC.inverse(), TagMarkers(tag), {},
                 &predictions);
  MarkerTracker tracker(renderer.camera(), options);
  EXPECT_TRUE(tracker.Plan(predictions, Time{}).whole_image);
  for (const MarkerDetection& d : tracker.Track(View(image), predictions, Time{})) {
    EXPECT_TRUE(d.valid()) << Name(d.fault);
  }
  // Another tag's names are not found, and a tag far from where it should be is not taken.
  for (MarkerPrediction& prediction : predictions) prediction.id += 4;
  MarkerTracker of_another(renderer.camera(), options);
  for (const MarkerDetection& d : of_another.Track(View(image), predictions, Time{})) {
    EXPECT_EQ(d.fault, MarkerFault::kNotFound);
  }
  for (MarkerPrediction& prediction : predictions) {
    prediction.id -= 4;
    prediction.image.centre.x() += 60.0;
  }
  MarkerTracker far_off(renderer.camera(), options);
  for (const MarkerDetection& d : far_off.Track(View(image), predictions, Time{})) {
    EXPECT_FALSE(d.valid());
  }
}

// The strut that holds the plate does not come out of its face.
TEST(RenderedTags, ShowNothingButPaperAndInkFromTheirFront) {
  Tag tag = MakeTag(7);
  tag.X_FT.translation().z() = 0.03;
  Scene scene;
  scene.floor.visible = false;
  AddTags({tag}, &scene);
  ASSERT_EQ(scene.bodies.size(), 3U);  // Plate, ink, strut.
  Renderer renderer = test::MakeRenderer(test::Camera(), scene);
  IdImage ids;
  renderer.RenderIds(test::LookAt({0.1, 0.05, 0.6}, Vector3d::Zero()), {}, &ids);
  EXPECT_GT(std::count(ids.pixels.begin(), ids.pixels.end(), kIdBody + 1), 1000);
  EXPECT_EQ(std::count(ids.pixels.begin(), ids.pixels.end(), kIdBody + 2), 0);
}

TEST(RenderedTags, OfNoFamilyAreRefused) {
  Scene scene;
  EXPECT_THROW(AddTags({MakeTag(kMaxTagId + 1)}, &scene), ConfigError);
}

}  // namespace
}  // namespace vantage::sim
