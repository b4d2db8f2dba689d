#include "sim/world.h"

#include <cmath>

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
  CameraModel camera = scenario.camera;
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
    step(i) = normal(random) * (i < 3 ? options.camera.position_error : options.camera.rotation_error);
  }
  return Advance(Isometry3d::Identity(), step);
}

Scene MakeScene(const Scenario& scenario) {
  Scene scene = ArmScene(scenario.robot);
  for (const Marker& marker : scenario.markers) scene.markers.push_back({kToolFrame, marker});
  for (const Marker& marker : scenario.sim.goal_markers) scene.markers.push_back({kWorldFrame, marker});
  return scene;
}

CameraDriver MakeCamera(const Scenario& scenario) {
  return {Renderer(MakeGlContext(), TrueCamera(scenario), MakeScene(scenario)),
          {scenario.robot, scenario.camera, scenario.markers, scenario.GoalMarkerPriors()},
          scenario.sim.camera, SeedOf(scenario.sim, Stream::kCamera)};
}

}  // namespace

World::World(const Scenario& scenario)
    : scenario_(scenario),
      arm_(scenario.robot, scenario.sim.q_start, scenario.sim.arm, SeedOf(scenario.sim, Stream::kArm)),
      rig_(scenario.rig, scenario.q_c_start),
      X_error_(PoseError(scenario.sim)),
      camera_(MakeCamera(scenario)) {}

SceneState World::Scene() const {
  return {ComputeLinkPoses(arm_.arm(), arm_.q()), EndEffectorPose(arm_.arm(), arm_.q())};
}

Isometry3d World::MeasuredPose() const { return rig_.X_WC() * X_error_; }

CameraPose World::ReadCameraPose() const { return {now_, MeasuredPose()}; }

void World::Advance(Time now) {
  const Duration step = FromSeconds(scenario_.sim.step);
  while (now_ + step <= now) {
    now_ += step;
    arm_.Step(now_, scenario_.sim.step);
    rig_.Step(scenario_.sim.step);
    if (camera_.Due(now_)) {
      camera_.Expose(now_, rig_.X_WC(), Scene(), MeasuredPose(), arm_.Read(now_).q);
    }
  }
}

Truth World::truth() const {
  Truth truth;
  truth.stamp = now_;
  truth.q = arm_.q();
  truth.X_WC = rig_.X_WC();
  truth.violations = arm_.violations();
  const std::vector<Vector3d> goal = scenario_.TrueGoalPoints();
  const Isometry3d X_WE = EndEffectorPose(arm_.arm(), arm_.q());
  double sum = 0.0;
  for (std::size_t i = 0; i < goal.size(); ++i) {
    const double distance = (X_WE * scenario_.markers[i].p - goal[i]).norm();
    truth.worst_error = std::max(truth.worst_error, distance);
    sum += distance * distance;
  }
  truth.rms_error = std::sqrt(sum / static_cast<double>(goal.size()));
  return truth;
}

void World::RenderColour(ColourImage* image) { camera_.RenderColour(rig_.X_WC(), Scene(), image); }

}  // namespace vantage::sim
