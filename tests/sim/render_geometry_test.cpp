#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "sim/render/arm_scene.h"
#include "sim/render/marker_geometry.h"
#include "sim/render/renderer.h"
#include "toy_scene.h"
#include "vantage/math/error.h"
#include "vantage/vision/disc_image.h"

namespace vantage::sim {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

Isometry3d FromAbove(double height) {
  return test::LookAt({0.0, 0.0, height}, Vector3d::Zero());
}

// One body on a plain background, seen from 2 m above.
Scene OneBody(const TriangleMesh& mesh) {
  Scene scene;
  scene.floor.visible = false;
  scene.bodies.push_back({kWorldFrame, mesh, {1.0F, 1.0F, 1.0F}, 0.2F});
  return scene;
}

int CountDifferent(const GreyImage& a, const GreyImage& b) {
  int different = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) different += a.pixels[i] != b.pixels[i] ? 1 : 0;
  return different;
}

// A box whose top face is projected by hand: one pixel inside of each edge is its, one outside is not.
TEST(RenderGeometry, EdgesOfABoxAreWhereTheCameraModelPutsThem) {
  CameraModel camera = test::Camera();
  camera.fx = 610.0;
  camera.fy = 580.0;
  camera.u0 = 301.3;
  camera.v0 = 250.8;
  Renderer renderer = test::MakeRenderer(camera, OneBody(BoxMesh({0.4, 0.3, 0.2})));
  GreyImage image;
  IdImage ids;
  DepthImage depth;
  renderer.RenderGrey(FromAbove(2.0), {}, &image);
  renderer.RenderIds(FromAbove(2.0), {}, &ids, &depth);
  // LookAt from above: Cx = Wx, Cy = -Wy; the top face lies at depth 1.9.
  const double left = camera.u0 - camera.fx * 0.2 / 1.9;
  const double right = camera.u0 + camera.fx * 0.2 / 1.9;
  const double top = camera.v0 - camera.fy * 0.15 / 1.9;
  const double bottom = camera.v0 + camera.fy * 0.15 / 1.9;
  const int u = static_cast<int>(camera.u0);
  const int v = static_cast<int>(camera.v0);
  const int background = *image.at(2, 2);
  const auto body = [&](double column, double row) {
    const int x = static_cast<int>(std::lround(column));
    const int y = static_cast<int>(std::lround(row));
    EXPECT_EQ(*image.at(x, y) != background, *ids.at(x, y) == kIdBody);
    return *ids.at(x, y) == kIdBody;
  };
  EXPECT_TRUE(body(left + 0.5, v));
  EXPECT_FALSE(body(left - 0.5, v));
  EXPECT_TRUE(body(right - 0.5, v));
  EXPECT_FALSE(body(right + 0.5, v));
  EXPECT_TRUE(body(u, top + 0.5));
  EXPECT_FALSE(body(u, top - 0.5));
  EXPECT_TRUE(body(u, bottom - 0.5));
  EXPECT_FALSE(body(u, bottom + 0.5));
  EXPECT_NEAR(*depth.at(u, v), 1.9, 1e-4);
  EXPECT_TRUE(std::isinf(*depth.at(2, 2)));
  EXPECT_EQ(*ids.at(2, 2), kIdBackground);
}

TEST(RenderGeometry, SkewShearsTheImage) {
  CameraModel camera = test::Camera();
  camera.skew = 60.0;
  Renderer renderer = test::MakeRenderer(camera, OneBody(BoxMesh({0.02, 1.0, 0.02})));
  IdImage ids;
  renderer.RenderIds(FromAbove(2.0), {}, &ids);
  for (const int row : {120, 360}) {
    double sum = 0.0;
    int count = 0;
    for (int u = 0; u < ids.width; ++u) {
      if (*ids.at(u, row) != kIdBody) continue;
      sum += u;
      ++count;
    }
    ASSERT_GT(count, 0);
    const double y = (row - camera.v0) / camera.fy;
    EXPECT_NEAR(sum / count, camera.u0 + camera.skew * y, 0.6);
  }
}

TEST(RenderGeometry, NearBodiesHideFarOnes) {
  Scene scene = OneBody(BoxMesh({0.4, 0.4, 0.1}));
  TriangleMesh near;
  Isometry3d X = Isometry3d::Identity();
  X.translation() << 0.1, 0.0, 0.5;
  Append(&near, BoxMesh({0.1, 0.1, 0.1}), X);
  scene.bodies.insert(scene.bodies.begin(), {kWorldFrame, near, {0.2F, 0.2F, 0.2F}, 0.0F});
  Renderer renderer = test::MakeRenderer(test::Camera(), scene);
  IdImage ids;
  DepthImage depth;
  renderer.RenderIds(FromAbove(2.0), {}, &ids, &depth);
  const int u = static_cast<int>(319.5 + 600.0 * 0.1 / 1.45);
  EXPECT_EQ(*ids.at(u, 240), kIdBody);
  EXPECT_NEAR(*depth.at(u, 240), 1.45, 1e-3);
  EXPECT_EQ(*ids.at(640 - u, 240), kIdBody + 1);
}

TEST(RenderGeometry, FloorIsSeenFromAboveOnly) {
  Scene scene;
  scene.floor.height = 0.3;
  Renderer renderer = test::MakeRenderer(test::Camera(), scene);
  IdImage ids;
  DepthImage depth;
  renderer.RenderIds(FromAbove(2.0), {}, &ids, &depth);
  EXPECT_EQ(*ids.at(100, 50), kIdFloor);
  EXPECT_NEAR(*depth.at(100, 50), 1.7, 1e-5);
  Isometry3d X_WC = Isometry3d::Identity();  // Looks up from below.
  renderer.RenderIds(X_WC, {}, &ids, &depth);
  EXPECT_EQ(*ids.at(100, 50), kIdBackground);
}

// The chequer may not be mistaken for anything.
TEST(RenderGeometry, FloorIsFaint) {
  Scene scene;
  Renderer renderer = test::MakeRenderer(test::Camera(), scene);
  GreyImage image;
  renderer.RenderGrey(test::LookAt({1.0, 0.5, 1.0}, {0.0, 0.0, 0.0}), {}, &image);
  const auto [low, high] = std::minmax_element(image.pixels.begin(), image.pixels.end());
  EXPECT_GT(*high - *low, 2);
  EXPECT_LE(*high - *low, 8);
}

Scene OneMarker(const Marker& marker) {
  Scene scene;
  scene.floor.visible = false;
  scene.markers.push_back({kWorldFrame, marker});
  return scene;
}

// In grey images the face of a plate is painted by its marker. It looks as its mesh would, but for its edge.
TEST(RenderGeometry, PlateLooksTheSameFromItsMarkerAsFromItsMesh) {
  Marker marker;
  marker.p = {0.02, -0.03, 0.5};
  marker.normal = Vector3d(0.3, -0.2, 0.9).normalized();
  marker.radius = 0.03;
  const Eigen::Vector3f colour(0.36F, 0.38F, 0.41F);
  Scene painted = OneMarker(marker);
  painted.markers[0].plate = colour;
  Scene meshed = OneMarker(marker);
  meshed.bodies.push_back({kWorldFrame, PlainMarkerPlate(marker), colour, 0.0F});
  for (const double k1 : {0.0, -0.2}) {
    CameraModel camera = test::Camera();
    camera.distortion.k1 = k1;
    Renderer by_marker = test::MakeRenderer(camera, painted);
    Renderer by_mesh = test::MakeRenderer(camera, meshed);
    GreyImage a;
    GreyImage b;
    int on_face = 0;
    for (const Vector3d& from :
         {Vector3d(0.1, 0.1, 1.3), Vector3d(0.9, -0.3, 0.9), Vector3d(-0.5, 0.2, 1.1)}) {
      const Isometry3d X_WC = test::LookAt(from, marker.p);
      by_marker.RenderGrey(X_WC, {}, &a);
      by_mesh.RenderGrey(X_WC, {}, &b);
      const double pixel = 1.5 * (from - marker.p).norm() / camera.fx;  // A pixel and a half [m].
      for (int v = 0; v < a.height; ++v) {
        for (int u = 0; u < a.width; ++u) {
          // Where the pixel's ray meets the marker's plane, from the marker's centre.
          const Vector3d ray =
              X_WC.linear() * ToNormalised(camera, Eigen::Vector2d(u, v)).homogeneous();
          const double way = marker.normal.dot(marker.p - from) / marker.normal.dot(ray);
          const double radius = (from + way * ray - marker.p).norm();
          const double slant = 1.0 / std::abs(marker.normal.dot(ray.normalized()));
          const double edge = kPlateRadii * marker.radius;
          if (std::abs(radius - edge) < pixel * slant) continue;
          ASSERT_NEAR(*a.at(u, v), *b.at(u, v), 1) << u << " " << v;
          if (radius > kRingRadii * marker.radius + pixel && radius < edge) ++on_face;
        }
      }
    }
    EXPECT_GT(on_face, 200);
  }
}

TEST(RenderGeometry, MarkerHasItsLevelsAndSizes) {
  for (const bool dark : {true, false}) {
    Marker marker;
    marker.radius = 0.03;
    marker.dark = dark;
    Renderer renderer = test::MakeRenderer(test::Camera(), OneMarker(marker));
    GreyImage image;
    renderer.RenderGrey(FromAbove(1.0), {}, &image);
    const int disc = dark ? 26 : 230;  // 0.1 and 0.9 of 255.
    const int ring = dark ? 230 : 26;
    const int background = 120;
    // Disc of 18 px, ring of 36 px about (319.5, 239.5).
    EXPECT_NEAR(*image.at(320, 240), disc, 1);
    EXPECT_NEAR(*image.at(320 + 16, 240), disc, 1);
    EXPECT_NEAR(*image.at(320 + 19, 240), ring, 1);
    EXPECT_NEAR(*image.at(320 + 34, 240), ring, 1);
    EXPECT_NEAR(*image.at(320 + 37, 240), background, 1);
    EXPECT_NEAR(*image.at(320, 240 - 38), background, 1);
  }
}

// Sum of grey over the disc's contrast is its area: coverage is exact to a few thousandths.
TEST(RenderGeometry, MarkerCoverageAddsUpToTheArea) {
  for (int i = 0; i < 25; ++i) {
    Marker marker;
    marker.p = Vector3d(0.013 * i - 0.15, 0.007 * i - 0.08, 0.0);
    marker.normal = Vector3d(0.02 * i, 0.3 - 0.03 * i, 1.0).normalized();
    marker.radius = 0.012;
    Renderer renderer = test::MakeRenderer(test::Camera(), OneMarker(marker));
    GreyImage image;
    const Isometry3d X_WC = FromAbove(1.0);
    renderer.RenderGrey(X_WC, {}, &image);
    const auto disc = ProjectDisc(renderer.camera(), X_WC.inverse(), marker);
    ASSERT_TRUE(disc.has_value());
    double area = 0.0;
    Vector2d moment = Vector2d::Zero();
    for (int v = 0; v < image.height; ++v) {
      for (int u = 0; u < image.width; ++u) {
        const Vector2d d = Vector2d(u, v) - disc->centroid;
        if (d.dot(disc->shape.inverse() * d) > 2.2) continue;
        const double weight = (230.0 - *image.at(u, v)) / (230.0 - 26.0);
        area += weight;
        moment += weight * d;
      }
    }
    EXPECT_NEAR(area / disc->area, 1.0, 0.003);
    EXPECT_LT((moment / area).norm(), 0.006);
  }
}

TEST(RenderGeometry, MarkerIsSeenFromItsFrontOnly) {
  Marker marker;
  marker.normal = -Vector3d::UnitZ();
  Renderer renderer = test::MakeRenderer(test::Camera(), OneMarker(marker));
  GreyImage image;
  renderer.RenderGrey(FromAbove(1.0), {}, &image);
  EXPECT_EQ(*std::max_element(image.pixels.begin(), image.pixels.end()),
            *std::min_element(image.pixels.begin(), image.pixels.end()));
}

TEST(RenderGeometry, MarkerInsideACapsuleIsOnItsOutside) {
  Marker marker;
  marker.radius = 0.01;
  Scene scene = OneMarker(marker);
  scene.bodies.push_back(
      {0, CapsuleMesh({-0.2, 0, 0}, {0.2, 0, 0}, 0.05), {0.5F, 0.5F, 0.5F}, 0.0F});
  IdImage ids;
  Renderer hidden = test::MakeRenderer(test::Camera(), scene);
  hidden.RenderIds(FromAbove(1.0), {}, &ids);
  EXPECT_EQ(*ids.at(320, 240), kIdBody);
  scene.capsules.push_back({0, {-0.2, 0, 0}, {0.2, 0, 0}, 0.05});
  Renderer lifted = test::MakeRenderer(test::Camera(), scene);
  lifted.RenderIds(FromAbove(1.0), {}, &ids);
  EXPECT_EQ(*ids.at(320, 240), kIdDisc);
  // Another body before it hides it all the same.
  SceneState state;
  TriangleMesh lid;
  Isometry3d X = Isometry3d::Identity();
  X.translation().z() = 0.3;
  Append(&lid, BoxMesh({0.1, 0.1, 0.02}), X);
  scene.bodies.push_back({1, lid, {0.2F, 0.2F, 0.2F}, 0.0F});
  Renderer covered = test::MakeRenderer(test::Camera(), scene);
  covered.RenderIds(FromAbove(1.0), state, &ids);
  EXPECT_EQ(*ids.at(320, 240), kIdBody + 1);
}

TEST(MarkerLift, IsTheWayOutOfTheCapsule) {
  const std::vector<Capsule> capsules{{0, {-0.2, 0, 0}, {0.2, 0, 0}, 0.05}};
  EXPECT_NEAR(MarkerLift(capsules, {}, {0, 0, 0}, {0, 0, 1}), 0.05, 1e-4);
  EXPECT_NEAR(MarkerLift(capsules, {}, {0, 0, 0.05}, {0, 0, 1}), 0.0, 1e-4);
  EXPECT_EQ(MarkerLift(capsules, {}, {0, 0, 0.06}, {0, 0, 1}), 0.0);
}

// Bodies follow the frame they are fixed to.
TEST(RenderGeometry, BodiesAndMarkersFollowTheirFrames) {
  Scene scene;
  scene.floor.visible = false;
  scene.bodies.push_back({3, BoxMesh({0.05, 0.05, 0.05}), {1.0F, 1.0F, 1.0F}, 0.0F});
  Marker marker;
  marker.radius = 0.02;
  scene.markers.push_back({kToolFrame, marker});
  Renderer renderer = test::MakeRenderer(test::Camera(), scene);
  SceneState state;
  state.X_WL[3].translation() << 0.3, 0.0, 0.0;
  state.X_WE.translation() << -0.3, 0.2, 0.0;
  IdImage ids;
  renderer.RenderIds(FromAbove(2.0), state, &ids);
  EXPECT_EQ(*ids.at(320 + 90, 240), kIdBody);
  EXPECT_EQ(*ids.at(320 - 90, 240 - 60), kIdDisc);
}

class RenderSame : public ::testing::Test {
 protected:
  const std::vector<Marker> tool_ = test::ToolMarkers(0.012, 0.035, Vector3d::UnitX(), true);
  const Isometry3d X_WC_ = test::LookAt({1.6, 0.9, 1.0}, {0.35, 0.1, 0.35});
  const SceneState state_ = test::ToyState(0.3, -0.9, 1.3);
};

TEST_F(RenderSame, ImageEachTimeAndFromEachRenderer) {
  Renderer a = test::MakeRenderer(test::Camera(), test::ToyScene(tool_, {}));
  Renderer b = test::MakeRenderer(test::Camera(), test::ToyScene(tool_, {}));
  GreyImage first;
  GreyImage other;
  GreyImage again;
  a.RenderGrey(X_WC_, state_, &first);
  b.RenderGrey(X_WC_, state_, &other);
  ColourImage colour;
  b.RenderColour(X_WC_, state_, &colour);
  IdImage ids;
  a.RenderIds(X_WC_, state_, &ids);
  a.RenderGrey(test::LookAt({0.2, -1.5, 0.8}, {0.0, 0.0, 0.3}), state_, &again);
  EXPECT_GT(CountDifferent(first, again), 1000);
  a.RenderGrey(X_WC_, state_, &again);
  EXPECT_EQ(CountDifferent(first, other), 0);
  EXPECT_EQ(CountDifferent(first, again), 0);
}

TEST_F(RenderSame, PixelsInsideWindows) {
  Renderer renderer = test::MakeRenderer(test::Camera(), test::ToyScene(tool_, {}));
  GreyImage whole;
  renderer.RenderGrey(X_WC_, state_, &whole);
  const std::vector<PixelWindow> windows{
      {233, 208, 41, 37}, {271, 219, 33, 33}, {-10, 400, 100, 200}, {610, 5, 80, 31}};
  GreyImage parts;
  renderer.RenderGrey(test::LookAt({0.2, -1.5, 0.8}, {0.0, 0.0, 0.3}), state_, &parts);
  renderer.RenderGrey(X_WC_, state_, windows, &parts);
  int compared = 0;
  for (const PixelWindow& window : windows) {
    const PixelWindow clipped = Clip(window, whole.width, whole.height);
    for (int v = clipped.v; v < clipped.v + clipped.height; ++v) {
      for (int u = clipped.u; u < clipped.u + clipped.width; ++u, ++compared) {
        ASSERT_EQ(*parts.at(u, v), *whole.at(u, v)) << u << " " << v;
      }
    }
  }
  EXPECT_GT(compared, 5000);
}

TEST_F(RenderSame, ImageFromBothBackends) {
  Renderer osmesa = test::MakeRenderer(test::Camera(), test::ToyScene(tool_, {}));
  Renderer egl = test::MakeRenderer(test::Camera(), test::ToyScene(tool_, {}), GlBackend::kEgl);
  GreyImage a;
  GreyImage b;
  ColourImage colour_a;
  ColourImage colour_b;
  for (int i = 0; i < 3; ++i) {  // In turns: each has to take the thread over from the other.
    const SceneState state = test::ToyState(0.3 * i, -0.9, 1.3);
    osmesa.RenderGrey(X_WC_, state, &a);
    egl.RenderGrey(X_WC_, state, &b);
    ASSERT_EQ(CountDifferent(a, b), 0);
  }
  osmesa.RenderColour(X_WC_, state_, &colour_a);
  egl.RenderColour(X_WC_, state_, &colour_b);
  EXPECT_EQ(colour_a.pixels, colour_b.pixels);
}

// Colour and grey images show the same thing at the same place: the arm is where the arm is.
TEST_F(RenderSame, PlacesInColourAndGrey) {
  Renderer renderer = test::MakeRenderer(test::Camera(), test::ToyScene(tool_, {}));
  ColourImage colour;
  IdImage ids;
  renderer.RenderColour(X_WC_, state_, &colour);
  renderer.RenderIds(X_WC_, state_, &ids);
  int orange = 0;
  int agree = 0;
  for (int v = 0; v < ids.height; ++v) {
    for (int u = 0; u < ids.width; ++u) {
      const std::uint8_t* const c = colour.at(u, v);
      if (c[0] < c[2] + 60) continue;
      ++orange;
      agree += *ids.at(u, v) >= kIdBody && *ids.at(u, v) < kIdDisc ? 1 : 0;
    }
  }
  EXPECT_GT(orange, 3000);
  EXPECT_GT(agree, 0.97 * orange);
}

TEST(RenderSetUp, RefusesWhatDoesNotFit) {
  const auto refuses = [](const CameraModel& camera, const Scene& scene) {
    try {
      test::MakeRenderer(camera, scene);
    } catch (const ConfigError&) {
      return true;
    }
    return false;
  };
  CameraModel camera = test::Camera();
  EXPECT_FALSE(refuses(camera, {}));
  camera.width = 0;
  EXPECT_TRUE(refuses(camera, {}));
  camera = test::Camera();
  camera.fx = -1.0;
  EXPECT_TRUE(refuses(camera, {}));
  Scene scene;
  scene.markers.resize(kMaxMarkers + 1);
  EXPECT_TRUE(refuses(test::Camera(), scene));
  scene.markers.resize(1);
  EXPECT_FALSE(refuses(test::Camera(), scene));
  scene.markers[0].frame = kMaxJoints;
  EXPECT_TRUE(refuses(test::Camera(), scene));
  scene = {};
  scene.bodies.push_back({kWorldFrame, BoxMesh({1, 1, 1}), {1, 1, 1}, 0.0F});
  scene.bodies[0].mesh.indices[0] = 1000;
  EXPECT_TRUE(refuses(test::Camera(), scene));
}

TEST(RenderSetUp, NamesTheBackends) {
  EXPECT_EQ(MakeGlContext(GlBackend::kOsmesa)->name(), "osmesa");
  EXPECT_EQ(MakeGlContext(GlBackend::kAuto)->name(), "osmesa");
  EXPECT_EQ(MakeGlContext(GlBackend::kEgl)->name(), "egl");
}

TEST(RenderSetUp, KeepsTheUsersRasteriserThreads) {
  ASSERT_EQ(setenv("LP_NUM_THREADS", "1", 1), 0);
  static_cast<void>(MakeGlContext());
  EXPECT_STREQ(getenv("LP_NUM_THREADS"), "1");
  ASSERT_EQ(unsetenv("LP_NUM_THREADS"), 0);
  static_cast<void>(MakeGlContext());
  EXPECT_STREQ(getenv("LP_NUM_THREADS"), "0");
}

}  // namespace
}  // namespace vantage::sim
