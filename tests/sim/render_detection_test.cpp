// The detector on rendered pixels, with the renderer's own geometry as truth.

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "sim/render/renderer.h"
#include "toy_scene.h"
#include "vantage/vision/marker_detector.h"

namespace vantage::sim {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// A camera pose, and the scene that it sees.
struct Shot {
  Isometry3d X_WC;
  SceneState state;
};

// The tool's markers from somewhere on a half sphere about the tool.
Shot RandomView(std::mt19937* random) {
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  Shot view;
  view.state = test::ToyState(1.5 * uniform(*random), -0.9 + 0.5 * uniform(*random),
                              1.3 + 0.5 * uniform(*random));
  const Vector3d target = view.state.X_WE * Vector3d(0.09, 0.0, 0.0);
  const Vector3d out = view.state.X_WE.linear() *
                       Vector3d(1.0, 0.8 * uniform(*random), 0.8 * uniform(*random)).normalized();
  const double distance = 1.0 + 0.5 * uniform(*random);
  view.X_WC =
      test::LookAt(target + distance * out,
                   target + 0.15 * Vector3d(uniform(*random), uniform(*random), uniform(*random)),
                   3.0 * uniform(*random));
  return view;
}

std::vector<MarkerPrediction> Predict(const CameraModel& camera, const Shot& view,
                                      const std::vector<Marker>& markers) {
  std::vector<MarkerPrediction> predictions;
  for (const Marker& marker : markers) {
    predictions.push_back(PredictMarker(camera, view.X_WC.inverse() * view.state.X_WE, marker, 0));
  }
  return predictions;
}

struct Statistics {
  std::vector<double> errors;
  int expected{0};
  void Add(const std::vector<MarkerPrediction>& predictions, const MarkerDetections& detections) {
    for (std::size_t i = 0; i < predictions.size(); ++i) {
      if (!predictions[i].expected) continue;
      ++expected;
      if (!detections[i].valid()) continue;
      errors.push_back((detections[i].pixel - predictions[i].image.centre).norm());
    }
  }
  [[nodiscard]] double mean() const {
    double sum = 0.0;
    for (const double error : errors) sum += error;
    return sum / static_cast<double>(errors.size());
  }
  [[nodiscard]] double max() const { return *std::max_element(errors.begin(), errors.end()); }
};

// Nothing but the markers: every one that is wholly in the image is found, and where it is.
// Measured: mean 0.005 px, max 0.02 px.
TEST(RenderedMarkers, AreDetectedWhereTheModelPutsThem) {
  const auto markers = test::ToolMarkers(0.012, 0.035, Vector3d::UnitX(), true);
  Scene scene;
  for (const Marker& marker : markers) scene.markers.push_back({kToolFrame, marker});
  Renderer renderer = test::MakeRenderer(test::Camera(), scene);
  std::mt19937 random(11);
  Statistics statistics;
  GreyImage image;
  MarkerDetections detections;
  for (int i = 0; i < 200; ++i) {
    const Shot view = RandomView(&random);
    renderer.RenderGrey(view.X_WC, view.state, &image);
    const auto predictions = Predict(renderer.camera(), view, markers);
    DetectMarkers(View(image), renderer.camera(), predictions, {}, &detections);
    statistics.Add(predictions, detections);
  }
  EXPECT_GT(statistics.expected, 500);
  EXPECT_GE(static_cast<double>(statistics.errors.size()), 0.985 * statistics.expected);
  EXPECT_LT(statistics.mean(), 0.01);
  EXPECT_LT(statistics.max(), 0.04);
}

TEST(RenderedMarkers, AreDetectedThroughABentLens) {
  const auto markers = test::ToolMarkers(0.012, 0.035, Vector3d::UnitX(), true);
  Scene scene;
  for (const Marker& marker : markers) scene.markers.push_back({kToolFrame, marker});
  CameraModel camera = test::Camera();
  camera.distortion = {-0.28, 0.09, 8e-4, -5e-4, -0.011};
  Renderer renderer = test::MakeRenderer(camera, scene);
  std::mt19937 random(12);
  Statistics statistics;
  GreyImage image;
  MarkerDetections detections;
  for (int i = 0; i < 100; ++i) {
    const Shot view = RandomView(&random);
    renderer.RenderGrey(view.X_WC, view.state, &image);
    const auto predictions = Predict(camera, view, markers);
    DetectMarkers(View(image), camera, predictions, {}, &detections);
    statistics.Add(predictions, detections);
  }
  EXPECT_GT(statistics.expected, 250);
  EXPECT_GE(static_cast<double>(statistics.errors.size()), 0.985 * statistics.expected);
  EXPECT_LT(statistics.mean(), 0.01);
  EXPECT_LT(statistics.max(), 0.05);
}

// A bar stands at random before the markers. The ID image, with and without it, says how much of each
// disc it hides: none that lost more than two hundredths of its area is accepted, and whatever is accepted
// is in its place.
TEST(RenderedMarkers, AreRefusedWhenHidden) {
  const auto markers = test::ToolMarkers(0.014, 0.04, Vector3d::UnitX(), true);
  Scene bare;
  for (const Marker& marker : markers) bare.markers.push_back({kToolFrame, marker});
  std::mt19937 random(13);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  Renderer without = test::MakeRenderer(test::Camera(), bare);
  int hidden_discs = 0;
  int accepted_beside = 0;
  for (const float level : {0.08F, 0.45F, 1.0F}) {
    Scene scene = bare;
    scene.light.ambient = 1.0F;
    scene.bodies.push_back(
        {0, CapsuleMesh({0, 0, -0.6}, {0, 0, 0.6}, 0.012), {level, level, level}, 0.0F});
    Renderer with = test::MakeRenderer(test::Camera(), scene);
    GreyImage image;
    IdImage ids_with;
    IdImage ids_without;
    MarkerDetections detections;
    for (int i = 0; i < 60; ++i) {
      Shot view = RandomView(&random);
      const Vector3d target = view.state.X_WE * Vector3d(0.09, 0.0, 0.0);
      Isometry3d& X_WL = view.state.X_WL[0];
      X_WL = Isometry3d(Eigen::AngleAxisd(3.0 * uniform(random), Vector3d::UnitX()));
      X_WL.translation() = target + 0.15 * (view.X_WC.translation() - target) +
                           0.05 * Vector3d(uniform(random), uniform(random), uniform(random));
      with.RenderGrey(view.X_WC, view.state, &image);
      with.RenderIds(view.X_WC, view.state, &ids_with);
      without.RenderIds(view.X_WC, view.state, &ids_without);
      const auto predictions = Predict(with.camera(), view, markers);
      DetectMarkers(View(image), with.camera(), predictions, {}, &detections);
      for (std::size_t k = 0; k < markers.size(); ++k) {
        if (!predictions[k].expected) continue;
        const auto id = static_cast<std::uint16_t>(kIdDisc + k);
        const auto all = std::count(ids_without.pixels.begin(), ids_without.pixels.end(), id);
        const auto seen = std::count(ids_with.pixels.begin(), ids_with.pixels.end(), id);
        const bool hidden =
            static_cast<double>(all - seen) > std::max(2.0, 0.02 * static_cast<double>(all));
        hidden_discs += hidden ? 1 : 0;
        if (hidden) {
          EXPECT_FALSE(detections[k].valid()) << seen << " of " << all << " px";
        }
        if (!detections[k].valid()) continue;
        accepted_beside += hidden ? 0 : 1;
        EXPECT_LT((detections[k].pixel - predictions[k].image.centre).norm(), 0.1)
            << seen << " of " << all << " px";
      }
    }
  }
  EXPECT_GT(hidden_discs, 100);
  EXPECT_GT(accepted_beside, 100);
}

// Markers slide out of the image: accepted ones are always in their place.
TEST(RenderedMarkers, AreRefusedWhenClipped) {
  Marker marker;
  marker.radius = 0.02;
  Scene scene;
  scene.markers.push_back({kToolFrame, marker});
  Renderer renderer = test::MakeRenderer(test::Camera(), scene);
  const Isometry3d X_WC = test::LookAt({0.0, 0.0, 1.5}, Vector3d::Zero());
  GreyImage image;
  MarkerDetections detections;
  int refused = 0;
  for (int i = 0; i < 120; ++i) {
    Shot view{X_WC, {}};
    view.state.X_WE.translation().x() = 0.74 + 0.001 * i;
    renderer.RenderGrey(view.X_WC, view.state, &image);
    const auto predictions = Predict(renderer.camera(), view, {marker});
    DetectMarkers(View(image), renderer.camera(), predictions, {}, &detections);
    const Vector2d& centroid = predictions[0].image.centroid;
    const double room = 639.5 - centroid.x() - std::sqrt(predictions[0].image.shape(0, 0));
    if (room < 0.0) {
      EXPECT_FALSE(detections[0].valid()) << room;
      ++refused;
    } else if (room > 3.0) {
      EXPECT_TRUE(detections[0].valid()) << room << Name(detections[0].fault);
    }
    if (detections[0].valid()) {
      EXPECT_LT((detections[0].pixel - predictions[0].image.centre).norm(), 0.04) << room;
    }
  }
  EXPECT_GT(refused, 20);
}

}  // namespace
}  // namespace vantage::sim
