#include "vision_study.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <random>

#include "sim/effects.h"
#include "sim/render/renderer.h"
#include "vantage/math/angles.h"

namespace vantage::bench {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using namespace sim;  // NOLINT: the study is all about its images

constexpr int kImages = 120;
constexpr double kPredictionError = 6.0;  // [px].
constexpr int kSubExposures = 8;          // Of a moving image.

double ProcessorTime() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

CameraModel Camera() {
  return {};
}

// Two dark and two bright dots in a square.
std::vector<Marker> Markers() {
  std::vector<Marker> markers;
  for (int i = 0; i < 4; ++i) {
    Marker marker;
    marker.id = i;
    marker.p << ((i & 1) != 0 ? 0.045 : -0.045), ((i & 2) != 0 ? 0.045 : -0.045), 0.0;
    marker.radius = 0.013;
    marker.dark = i % 3 == 0;
    markers.push_back(marker);
  }
  return markers;
}

Scene MakeScene(bool bar, float level) {
  Scene scene;
  for (const Marker& marker : Markers()) {
    scene.markers.push_back({kToolFrame, marker, Eigen::Vector3f(0.36F, 0.38F, 0.41F)});
  }
  if (bar) {
    scene.light.ambient = 1.0F;
    scene.bodies.push_back(
        {0, CapsuleMesh({0, 0, -0.6}, {0, 0, 0.6}, 0.012), {level, level, level}, 0.0F});
  }
  return scene;
}

struct Shot {
  Isometry3d X_WC;
  SceneState state;
  Vector2d drift_C{Vector2d::Zero()};  // Of the markers during the exposure [m].
};

Isometry3d LookAt(const Vector3d& from, const Vector3d& to, double roll) {
  const Vector3d forward = (to - from).normalized();
  const Vector3d right = forward.unitOrthogonal();
  Isometry3d X_WC = Isometry3d::Identity();
  X_WC.linear() << right, forward.cross(right), forward;
  X_WC.linear() = X_WC.linear() * Eigen::AngleAxisd(roll, Vector3d::UnitZ());
  X_WC.translation() = from;
  return X_WC;
}

Shot MakeShot(const Condition& condition, std::mt19937* random) {
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const auto next = [&] { return uniform(*random); };
  Shot shot;
  shot.state.X_WE.translation() << 0.0, 0.0, 0.8;
  const Vector3d target = shot.state.X_WE.translation();
  const double incidence = 0.55 + 0.5 * next();
  const double azimuth = kPi * next();
  const Vector3d out(std::sin(incidence) * std::cos(azimuth),
                     std::sin(incidence) * std::sin(azimuth), std::cos(incidence));
  const double distance = 1.1 + 0.5 * next();
  shot.X_WC = LookAt(target + distance * out, target, kPi * next());
  // Where the markers' middle lies in the image.
  Vector2d pixel(320.0 + 180.0 * next(), 240.0 + 120.0 * next());
  if (condition.border) {
    const double reach = 30.0 * next();
    switch ((*random)() % 4) {
      case 0:
        pixel.x() = reach;
        break;
      case 1:
        pixel.x() = 639.0 - reach;
        break;
      case 2:
        pixel.y() = reach;
        break;
      default:
        pixel.y() = 479.0 - reach;
    }
  }
  const Vector2d n = ToNormalised(Camera(), pixel);
  shot.X_WC.translation() -= shot.X_WC.linear() * Vector3d(n.x(), n.y(), 0.0) * distance;
  const double heading = kPi * next();
  shot.drift_C =
      condition.motion * distance / Camera().fx * Vector2d(std::cos(heading), std::sin(heading));
  if (condition.bar) {
    Isometry3d& X_WL = shot.state.X_WL[0];
    X_WL = Isometry3d(Eigen::AngleAxisd(kPi * next(), Vector3d::UnitX()) *
                      Eigen::AngleAxisd(kPi * next(), Vector3d::UnitY()));
    X_WL.translation() = target + 0.12 * distance * out + 0.06 * Vector3d(next(), next(), next());
  }
  return shot;
}

// The mean of images over the exposure, whose middle the shot is.
void Expose(Renderer* renderer, const Shot& shot, GreyImage* image) {
  if (shot.drift_C.isZero()) {
    renderer->RenderGrey(shot.X_WC, shot.state, image);
    return;
  }
  std::vector<int> sum(static_cast<std::size_t>(Camera().width) * Camera().height, 0);
  for (int i = 0; i < kSubExposures; ++i) {
    const double t = (i + 0.5) / kSubExposures - 0.5;
    Shot part = shot;
    part.X_WC.translation() -=
        shot.X_WC.linear() * Vector3d(t * shot.drift_C.x(), t * shot.drift_C.y(), 0.0);
    renderer->RenderGrey(part.X_WC, part.state, image);
    for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += image->pixels[k];
  }
  for (std::size_t k = 0; k < sum.size(); ++k) {
    image->pixels[k] = static_cast<std::uint8_t>((sum[k] + kSubExposures / 2) / kSubExposures);
  }
}

enum class Disc { kWhole, kDamaged, kNeither };

// What is left of each disc, by the ID image with the bar and the exact area without.
Disc Judge(const MarkerPrediction& truth, long seen, long unhidden, const CameraModel& camera) {
  if (!truth.expected && truth.image.area <= 0.0) return Disc::kNeither;
  const Vector2d half = truth.image.shape.diagonal().cwiseSqrt();
  const Vector2d& c = truth.image.centroid;
  const double room = std::min(std::min(c.x() - half.x(), camera.width - 1.0 - c.x() - half.x()),
                               std::min(c.y() - half.y(), camera.height - 1.0 - c.y() - half.y()));
  const auto lost = static_cast<double>(unhidden - seen);
  if (lost > std::max(2.0, 0.02 * truth.image.area)) return Disc::kDamaged;
  // Cut by the border; between that and a whole ring in the image either answer will do.
  if (room < -0.5) return Disc::kDamaged;
  return lost == 0.0 && room > 4.0 + half.maxCoeff() ? Disc::kWhole : Disc::kNeither;
}

}  // namespace

std::vector<Condition> Conditions() {
  std::vector<Condition> conditions;
  const auto add = [&](const std::string& name) -> Condition& {
    conditions.push_back({});
    conditions.back().name = name;
    return conditions.back();
  };
  for (int noise = 0; noise <= 6; ++noise) add("noise_" + std::to_string(noise)).noise = noise;
  add("blur_0.7").blur = 0.7;
  add("blur_1.5").blur = 1.5;
  add("motion_2").motion = 2.0;
  add("motion_4").motion = 4.0;
  add("hidden").bar = true;
  add("border").border = true;
  Condition& all = add("all");
  all.noise = 3.0;
  all.blur = 0.7;
  all.motion = 2.0;
  all.bar = true;
  all.border = true;
  return conditions;
}

std::vector<StudyResult> RunStudy(const Condition& condition) {
  const CameraModel camera = Camera();
  const std::vector<Marker> markers = Markers();
  std::mt19937 random(20);
  std::vector<Renderer> renderers;
  for (const float level : {0.08F, 0.45F, 1.0F}) {
    renderers.emplace_back(MakeGlContext(), camera, MakeScene(condition.bar, level));
  }
  Renderer bare(MakeGlContext(), camera, MakeScene(false, 0.0F));
  ImageEffects effects;
  effects.noise = condition.noise;
  effects.blur = condition.blur;
  EffectChain chain(effects, 3);

  std::vector<StudyResult> results(std::size(kDetectors));
  GreyImage image;
  IdImage seen;
  IdImage unhidden;
  MarkerDetections detections;
  for (int i = 0; i < kImages; ++i) {
    const Shot shot = MakeShot(condition, &random);
    Renderer& renderer = renderers[i % renderers.size()];
    Expose(&renderer, shot, &image);
    chain.Begin(Time(FromSeconds(0.01 * i)));
    chain.Apply(&image);
    renderer.RenderIds(shot.X_WC, shot.state, &seen);
    bare.RenderIds(shot.X_WC, shot.state, &unhidden);

    std::vector<MarkerPrediction> truth;
    std::vector<MarkerPrediction> given;
    std::uniform_real_distribution<double> off(-kPredictionError, kPredictionError);
    const Vector2d offset(off(random), off(random));
    for (const Marker& marker : markers) {
      truth.push_back(PredictMarker(camera, shot.X_WC.inverse() * shot.state.X_WE, marker, 0));
      given.push_back(truth.back());
      given.back().image.centroid += offset;
      given.back().image.centre += offset;
      given.back().expected =
          truth.back().image.area > 0.0 && InImage(camera, given.back().image.centroid);
    }
    for (std::size_t d = 0; d < std::size(kDetectors); ++d) {
      StudyResult& result = results[d];
      const double start = ProcessorTime();
      // What needs to start inside a dot is told where the dot is.
      kDetectors[d].detect(View(image), camera, kDetectors[d].needs_start ? truth : given,
                           &detections);
      result.microseconds += 1e6 * (ProcessorTime() - start) / kImages;
      for (std::size_t k = 0; k < markers.size(); ++k) {
        const auto count = [&](const IdImage& ids) {
          return static_cast<long>(std::count(ids.pixels.begin(), ids.pixels.end(),
                                              static_cast<std::uint16_t>(kIdDisc + k)));
        };
        const Disc disc = Judge(truth[k], count(seen), count(unhidden), camera);
        const bool accepted = detections[k].valid();
        const double error = (detections[k].pixel - truth[k].image.centre).norm();
        if (disc == Disc::kDamaged) {
          ++result.damaged;
          result.bad_accepted += accepted ? 1 : 0;
        } else if (disc == Disc::kWhole) {
          ++result.whole;
          if (accepted && error > 0.5) {
            ++result.bad_accepted;
          } else if (accepted) {
            ++result.found;
            result.mean_error += error;
            result.max_error = std::max(result.max_error, error);
          }
        }
      }
    }
  }
  for (StudyResult& result : results) result.mean_error /= std::max(1, result.found);
  return results;
}

}  // namespace vantage::bench
