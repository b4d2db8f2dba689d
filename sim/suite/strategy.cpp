#include "sim/suite/strategy.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/suite/draft.h"
#include "vantage/math/angles.h"
#include "vantage/math/error.h"
#include "vantage/observability/measures.h"

namespace vantage::sim {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr int kMotionSamples = 17;
constexpr int kPlacements = 3000;
constexpr int kRefinements = 600;

// What is known of the task before it starts.
struct Known {
  std::vector<ArmSample> motion;
  std::vector<PlacedMarker> goal_markers;
};

Known NominalMotion(const Scenario& scenario) {
  const ViewModel& view = scenario.task.view;
  const ServoGoal& goal = scenario.task.goal;
  std::vector<Vector3d> p_EM, p_WG;
  for (const Marker& marker : view.markers) p_EM.push_back(marker.p);
  for (const Vector3d& p : goal.p_WG) p_WG.push_back(p + goal.offset_W);
  const PointGoalSolution end = SolveForPoints(view.arm, p_EM, p_WG, scenario.sim.q_start);
  Known known;
  known.motion = SampleMotion(view, scenario.sim.q_start, end.q, kMotionSamples);
  for (std::size_t i = 0; i < goal.marker_ids.size(); ++i) {
    known.goal_markers.push_back({goal.p_WG[i], goal.normals[i], goal.marker_radius});
  }
  return known;
}

// How much of the motion is seen, and the criterion over it.
struct Placement {
  int seen{-1};
  double value{0.0};
  [[nodiscard]] bool operator<(const Placement& other) const {
    return seen != other.seen ? seen < other.seen : value < other.value;
  }
};

Placement Evaluate(const Scenario& scenario, const Known& known, const RigVector& q_c,
                   bool minimax) {
  const Isometry3d X_WC = RigPose(scenario.rig, q_c);
  const auto sees = [&](const std::vector<PlacedMarker>& markers, const ArmSample& at) {
    return AllSeen(scenario, markers, at, known.goal_markers, X_WC);
  };
  Placement placement{0, 0.0};
  double sum = 0.0;
  double least = std::numeric_limits<double>::infinity();
  for (const ArmSample& sample : known.motion) {
    if (!sees(sample.markers, sample)) continue;
    if (!sees(known.goal_markers, sample)) continue;
    ++placement.seen;
    const double w = MeasureOf(CompositeJacobian(scenario.task.view, sample, X_WC)).w;
    sum += w;
    least = std::min(least, w);
  }
  placement.value = minimax ? least : sum;
  return placement;
}

// Random search over the whole rig, then round the best with ever smaller steps.
RigVector PlaceCamera(const Scenario& scenario, bool minimax) {
  const Known known = NominalMotion(scenario);
  const CameraRig& rig = scenario.rig;
  Random random(7);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const Vector3d a = known.motion.front().markers.front().p_W;
  const Vector3d b = known.motion.back().markers.front().p_W;
  RigVector best_q_c = scenario.q_c_start;
  Placement best = Evaluate(scenario, known, best_q_c, minimax);
  const auto attempt = [&](const RigVector& q_c) {
    const Placement placement = Evaluate(scenario, known, q_c, minimax);
    if (!(best < placement)) return;
    best = placement;
    best_q_c = q_c;
  };
  for (int i = 0; i < kPlacements; ++i) {
    RigVector q_c = best_q_c;
    for (int axis = 0; axis < rig.size(); ++axis) {
      const RigAxis& bounds = rig.axes[static_cast<std::size_t>(axis)];
      const double half = std::min(0.5 * (bounds.upper - bounds.lower), kPi);
      q_c(axis) = 0.5 * (bounds.upper + bounds.lower) + half * unit(random);
    }
    attempt(AimAt(rig, q_c, 0.5 * (a + b)));
  }
  for (int i = 0; i < kRefinements; ++i) {
    const double scale = 0.3 * std::pow(0.01, static_cast<double>(i) / kRefinements);
    RigVector q_c = best_q_c;
    for (int axis = 0; axis < rig.size(); ++axis) q_c(axis) += scale * unit(random);
    attempt(ClampToLimits(rig, q_c));
  }
  return best_q_c;
}

}  // namespace

const std::vector<Strategy>& AllStrategies() {
  static const std::vector<Strategy> all{
      Strategy::kFixed,  Strategy::kClassic,  Strategy::kPlanned,  Strategy::kMinimax,
      Strategy::kActive, Strategy::kGradient, Strategy::kStopAndGo};
  return all;
}

const char* Name(Strategy strategy) noexcept {
  switch (strategy) {
    case Strategy::kFixed:
      return "fixed";
    case Strategy::kClassic:
      return "classic";
    case Strategy::kPlanned:
      return "planned";
    case Strategy::kMinimax:
      return "minimax";
    case Strategy::kActive:
      return "active";
    case Strategy::kGradient:
      return "gradient";
    case Strategy::kStopAndGo:
      return "stop-and-go";
  }
  return "?";
}

Strategy StrategyOf(const std::string& name) {
  std::string names;
  for (const Strategy strategy : AllStrategies()) {
    if (name == Name(strategy)) return strategy;
    names += std::string(names.empty() ? "" : ", ") + Name(strategy);
  }
  throw ConfigError("", "strategy", "must be one of " + names + "; is " + name);
}

Scenario WithStrategy(Scenario scenario, Strategy strategy) {
  switch (strategy) {
    case Strategy::kActive:
      return scenario;
    case Strategy::kGradient:
      scenario.active.mode = ActiveMode::kGradient;
      return scenario;
    case Strategy::kStopAndGo:
      scenario.servo.hold_while_camera_moves = true;
      return scenario;
    case Strategy::kClassic:
      scenario.servo.law.textbook = true;
      scenario.servo.calibration.estimate = false;
      break;
    case Strategy::kPlanned:
    case Strategy::kMinimax:
      scenario.q_c_start = PlaceCamera(scenario, strategy == Strategy::kMinimax);
      break;
    case Strategy::kFixed:
      break;
  }
  scenario.active.enabled = false;
  return scenario;
}

const std::vector<Ablation>& AllAblations() {
  static const std::vector<Ablation> all{
      {"damping", "no damping of the inverse", [](Scenario* s) { s->servo.law.damping = 0.0; }},
      {"path", "straight for the goal in the image, without the reference path",
       [](Scenario* s) { s->servo.path.enabled = false; }},
      {"bounds", "the textbook law in place of bounded least squares",
       [](Scenario* s) { s->servo.law.textbook = true; }},
      {"certificate", "any view may end the task",
       [](Scenario* s) {
         s->servo.convergence.max_mm_per_px = 1e6;
         s->active.planner.max_mm_per_px = 1e6;
       }},
      {"look-ahead", "markers about to be lost do not fire",
       [](Scenario* s) { s->active.look_ahead = 0.0; }},
      {"path-samples", "views are scored at the present configuration alone",
       [](Scenario* s) { s->active.planner.path_samples = 1; }},
      {"calibration", "the calibration is taken as it is",
       [](Scenario* s) { s->servo.calibration.estimate = false; }},
      {"cap", "the best view, however far, not one that is good enough",
       [](Scenario* s) { s->active.planner.cap = 1e6; }},
  };
  return all;
}

const Ablation& AblationOf(const std::string& name) {
  std::string names;
  for (const Ablation& ablation : AllAblations()) {
    if (name == ablation.name) return ablation;
    names += std::string(names.empty() ? "" : ", ") + ablation.name;
  }
  throw ConfigError("", "without", "must be one of " + names + "; is " + name);
}

}  // namespace vantage::sim
