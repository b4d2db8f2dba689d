#include "sim/world.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "sim/goal_motion.h"
#include "sim/kinematic_eye.h"
#include "sim/pixel_eye.h"
#include "sim/render/arm_scene.h"
#include "sim/render/tag_bodies.h"

namespace vantage::sim {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

// Streams of random numbers that do not share a seed.
enum class Stream : std::uint64_t { kArm = 1, kCamera = 2, kCalibration = 3 };

std::uint64_t SeedOf(const SimOptions& options, Stream stream) {
  return options.seed * 1000003u + static_cast<std::uint64_t>(stream);
}

// The camera as it truly is: its calibration is a little off.
CameraModel TrueCamera(const Scenario& scenario) {
  std::mt19937_64 random(SeedOf(scenario.sim, Stream::kCalibration) + 7u);
  std::normal_distribution<double> normal(0.0, 1.0);
  CameraModel camera = scenario.task.view.camera;
  const double factor = 1.0 + scenario.sim.camera.focal_error * normal(random);
  camera.fx *= factor;
  camera.fy *= factor;
  return camera;
}

Isometry3d PoseError(const SimOptions& options) {
  std::mt19937_64 random(SeedOf(options, Stream::kCalibration));
  std::normal_distribution<double> normal(0.0, 1.0);
  Twist step;
  for (int i = 0; i < 6; ++i) {
    step(i) =
        normal(random) * (i < 3 ? options.camera.position_error : options.camera.rotation_error);
  }
  return Advance(Isometry3d::Identity(), step);
}

GlBackend BackendOf(RendererBackend renderer) {
  switch (renderer) {
    case RendererBackend::kOsmesa:
      return GlBackend::kOsmesa;
    case RendererBackend::kEgl:
      return GlBackend::kEgl;
    case RendererBackend::kAuto:
      break;
  }
  return GlBackend::kAuto;
}

std::unique_ptr<Eye> MakeEye(const Scenario& scenario, std::uint64_t seed) {
  const ViewModel& view = scenario.task.view;
  const CameraEffects& effects = scenario.sim.camera;
  if (effects.kinematic) {
    return std::make_unique<KinematicEye>(view.arm, TrueCamera(scenario), view.markers,
                                          scenario.sim.goal_markers, effects.noise_px, seed);
  }
  return std::make_unique<PixelEye>(
      MakeRenderer(scenario), view.arm, view.camera, scenario.vision,
      ImageEffects{effects.noise_grey, effects.blur, effects.gain_step, effects.gain_period}, seed);
}

CameraDriver MakeCamera(const Scenario& scenario) {
  const ViewModel& view = scenario.task.view;
  const std::uint64_t seed = SeedOf(scenario.sim, Stream::kCamera);
  return {MakeEye(scenario, seed),
          {view.arm, view.camera, view.markers, BelievedGoalMarkers(scenario)},
          scenario.sim.camera,
          seed};
}

}  // namespace

Renderer MakeRenderer(const Scenario& scenario, std::vector<std::string>* warnings) {
  const ViewModel& view = scenario.task.view;
  // Corners of tags are no dots.
  const std::vector<Marker> dots = scenario.tags.empty() ? view.markers : std::vector<Marker>();
  Scene scene = MakeArmScene(view.arm, dots, scenario.sim.goal_markers, {}, warnings);
  AddTags(scenario.tags, &scene);
  return {MakeGlContext(BackendOf(scenario.sim.renderer)), TrueCamera(scenario), std::move(scene)};
}

World::World(const Scenario& scenario, Time start)
    : scenario_(scenario),
      arm_(scenario.task.view.arm, scenario.sim.q_start, scenario.sim.arm,
           SeedOf(scenario.sim, Stream::kArm)),
      rig_(scenario.rig, scenario.q_c_start),
      X_error_(PoseError(scenario.sim)),
      camera_(MakeCamera(scenario)),
      start_(start),
      now_(start) {
  camera_.Start(start);
}

SceneState World::Scene() const {
  return {ComputeLinkPoses(arm_.arm(), arm_.q()), EndEffectorPose(arm_.arm(), arm_.q()), X_WG()};
}

Isometry3d World::X_WG() const {
  return Isometry3d(
      Eigen::Translation3d(GoalShift(scenario_.sim.goal_motion, ToSeconds(now_ - start_))));
}

Isometry3d World::MeasuredPose() const {
  return rig_.X_WC() * X_error_;
}

CameraPose World::ReadCameraPose() const {
  return {now_, MeasuredPose()};
}

void World::Advance(Time now) {
  const Duration step = FromSeconds(scenario_.sim.step);
  while (now_ + step <= now) {
    now_ += step;
    arm_.Step(now_, scenario_.sim.step);
    rig_.Step(scenario_.sim.step);
    if (camera_.Due(now_)) {
      camera_.Expose(now_, rig_.X_WC(), arm_.q(), X_WG(), MeasuredPose(), arm_.Read(now_).q);
    }
  }
}

void World::SkipTo(Time now) {
  if (now <= now_) return;
  now_ = now;
  camera_.Start(now);
}

GroundTruth World::truth() const {
  GroundTruth truth;
  truth.stamp = now_;
  truth.q = arm_.q();
  truth.limit_violations = arm_.violations().total();
  const std::vector<Vector3d>& goal = scenario_.p_WG_true;
  const Isometry3d X_WE = EndEffectorPose(arm_.arm(), arm_.q());
  double sum = 0.0;
  for (std::size_t i = 0; i < goal.size(); ++i) {
    const double distance = (X_WE * scenario_.task.view.markers[i].p - X_WG() * goal[i]).norm();
    truth.worst_error = std::max(truth.worst_error, distance);
    sum += distance * distance;
  }
  truth.rms_error = std::sqrt(sum / static_cast<double>(goal.size()));
  return truth;
}

WorldView World::view() const {
  return {now_, rig_.X_WC(), Scene()};
}

}  // namespace vantage::sim
