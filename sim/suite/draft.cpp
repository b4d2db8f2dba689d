#include "sim/suite/draft.h"

#include <algorithm>
#include <cmath>

#include "sim/goal_motion.h"
#include "vantage/config/loaders.h"
#include "vantage/math/angles.h"
#include "vantage/observability/measures.h"
#include "vantage/servo/branch_choice.h"

namespace vantage::sim {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr int kMotionSamples = 9;
// Views tried before a task counts as infeasible.
constexpr int kFeasibilityDraws = 300;

struct ArmKit {
  const char* robot;
  std::vector<Marker> markers;
  std::vector<Feature> features;
  Vector3d
      goal_marker_E;  // from a goal point to its marker, in the end effector's axes at the goal
  Vector3d target_W;  // the dome's centre
  double nearest, farthest;
};

std::vector<Feature> Points(int count) {
  std::vector<Feature> features;
  for (int i = 0; i < count; ++i) {
    features.push_back({FeatureKind::kPointX, {i}});
    features.push_back({FeatureKind::kPointY, {i}});
  }
  return features;
}

ArmKit KitOf(ArmSet arms, bool housed) {
  const Vector3d z = Vector3d::UnitZ();
  switch (arms) {
    case ArmSet::kPlanar2:
      return {housed ? "planar2_housed" : "planar2",
              {{0, {0.0, 0.0, 0.025}, z, 0.014}},
              Points(1),
              {0.065, 0.0, 0.0},
              {0.0, 0.0, 0.0},
              0.8,
              1.7};
    case ArmSet::kPuma3Xyx:
    case ArmSet::kPuma3Points: {
      std::vector<Feature> features = Points(2);
      if (arms == ArmSet::kPuma3Xyx) features.pop_back();
      return {housed ? "puma3_housed" : "puma3",
              {{0, {0.0, 0.0, 0.05}, z, 0.013}, {1, {-0.12, 0.05, 0.05}, z, 0.013}},
              features,
              {0.075, 0.0, 0.0},
              {0.0, 0.0, 0.6},
              1.2,
              2.2};
    }
    case ArmSet::kPuma560:
      return {
          housed ? "puma560_housed" : "puma560",
          // Ahead of the wrist, so that the goal's dots stand clear of it when the hand is there.
          {{0, {0.05, 0.05, 0.08}, z, 0.009},
           {1, {-0.05, 0.05, 0.08}, z, 0.009},
           {2, {-0.05, -0.05, 0.08}, z, 0.009},
           {3, {0.05, -0.05, 0.08}, z, 0.009}},
          Points(4),
          {0.05, 0.0, 0.0},
          {0.0, 0.0, 0.6},
          1.2,
          2.0};
  }
  return {};
}

RigAxis Turn(const char* name, double lower_deg, double upper_deg, double speed_deg) {
  return {name, lower_deg * kDegree, upper_deg * kDegree, speed_deg * kDegree,
          3.0 * speed_deg * kDegree};
}

bool BodyClear(const ArmModel& arm, const ArmSample& sample) {
  const Vector3d p_WE = sample.kinematics.X_WE.translation();
  const Vector3d base = arm.X_WBase().translation();
  // Above the floor, and not inside the arm's own trunk.
  const bool planar = arm.size() == 2;
  const double across = (p_WE - base).head<2>().norm();
  return across > 0.22 && (planar || p_WE.z() > 0.2);
}

// No camera of the dome looks at markers that face the floor.
bool FacesTheFloor(const ArmSample& sample) {
  return sample.markers.front().normal_W.z() < -0.3;
}

bool AwayFromLimits(const ArmModel& arm, const JointVector& q) {
  for (int i = 0; i < q.size(); ++i) {
    const JointLimits& limit = arm.limits()[static_cast<std::size_t>(i)];
    if (q(i) < limit.lower + 5.0 * kDegree || q(i) > limit.upper - 5.0 * kDegree) return false;
  }
  return true;
}

// Joints of an ordinary configuration: away from limits and from the arm's singularities.
bool Ordinary(ArmSet arms, const ArmModel& arm, const JointVector& q) {
  if (!AwayFromLimits(arm, q)) return false;
  if (arms == ArmSet::kPlanar2) return std::abs(std::sin(q(1))) > 0.3;
  const ArmJacobian J = ComputeKinematics(arm, q).J_WE_W;
  const Measure measure =
      arms == ArmSet::kPuma560 ? MeasureOf(J) : MeasureOf(TaskJacobian(J.topRows(3)), 3);
  return measure.inverse_condition() > 0.06;
}

// Singular by the joint that makes it so: the elbow stretched, or the wrist straight.
void NearSingularity(ArmSet arms, Random* random, JointVector* q) {
  const double sign = Uniform(random, -1.0, 1.0) < 0.0 ? -1.0 : 1.0;
  const double off = sign * Uniform(random, 3.0, 8.0) * kDegree;
  switch (arms) {
    case ArmSet::kPlanar2:
      (*q)(1) = off;
      break;
    case ArmSet::kPuma3Xyx:
    case ArmSet::kPuma3Points:
      (*q)(2) = off;
      break;
    case ArmSet::kPuma560:
      (*q)(4) = off;
      break;
  }
}

void PlaceGoal(const ArmKit& kit, Draft* draft) {
  const ViewModel& view = draft->scenario.task.view;
  const Isometry3d X_WE = EndEffectorPose(view.arm, draft->q_goal);
  ServoGoal& goal = draft->scenario.task.goal;
  const Vector3d aside_W = X_WE.linear() * kit.goal_marker_E;
  goal = ServoGoal();
  goal.offset_W = -aside_W;
  goal.marker_radius = view.markers.front().radius;
  draft->scenario.p_WG_true.clear();
  draft->scenario.sim.goal_markers.clear();
  draft->goal_markers.clear();
  for (std::size_t i = 0; i < view.markers.size(); ++i) {
    Marker marker = view.markers[i];
    const Vector3d p_WG = X_WE * marker.p;
    marker.id = 10 + static_cast<int>(i);
    marker.p = p_WG + aside_W;
    marker.normal = X_WE.linear() * marker.normal;
    marker.dark = false;
    draft->scenario.p_WG_true.push_back(p_WG);
    draft->scenario.sim.goal_markers.push_back(marker);
    draft->goal_markers.push_back({marker.p, marker.normal, marker.radius});
    goal.p_WG.push_back(marker.p);
    goal.marker_ids.push_back(marker.id);
    goal.normals.push_back(marker.normal);
  }
}

// A marker of the arm would run into one of the goal's on the way.
bool RunsIntoGoal(const Draft& draft) {
  constexpr int kSteps = 64;
  const ViewModel& view = draft.scenario.task.view;
  std::vector<PlacedMarker> markers;
  for (int i = 0; i <= kSteps; ++i) {
    const double share = static_cast<double>(i) / kSteps;
    const JointVector q = draft.q_start + share * (draft.q_goal - draft.q_start);
    const Isometry3d X_WE = EndEffectorPose(view.arm, q);
    markers.clear();
    for (const Marker& marker : view.markers) {
      markers.push_back({X_WE * marker.p, X_WE.linear() * marker.normal, marker.radius});
    }
    if (PlatesTouch(markers, draft.goal_markers)) return true;
  }
  return false;
}

double WorstMillimetresAt(const Draft& draft, const ArmSample& sample, const Isometry3d& X_WC) {
  return WorstMillimetresPerPixel(
      Decompose(CompositeJacobian(draft.scenario.task.view, sample, X_WC)), sample.J_marker_W);
}

}  // namespace

double Uniform(Random* random, double lower, double upper) {
  return std::uniform_real_distribution<double>(lower, upper)(*random);
}

Scenario MakeCell(ArmSet arms, bool housed) {
  const ArmKit kit = KitOf(arms, housed);
  const int count = static_cast<int>(kit.markers.size());
  const ViewModel view{FindRobot(kit.robot), CameraModel(), FeatureSet(kit.features, count),
                       kit.markers};
  CameraRig rig;
  rig.kind = RigKind::kSpherical;
  rig.target_W = kit.target_W;
  rig.axes = {{"R", kit.nearest, kit.farthest, 0.4, 1.2},
              Turn("theta", 5.0, 85.0, 60.0),
              Turn("phi", -360.0, 360.0, 60.0),
              Turn("roll", -360.0, 360.0, 60.0),
              Turn("pan", -45.0, 45.0, 60.0),
              Turn("tilt", -45.0, 45.0, 60.0)};
  rig.max_linear_speed = 0.4;

  Scenario scenario{"", "", {view, {}}, rig, RigVector(), {}, {}, 60.0, {}, {}, {}, {}, {}};
  scenario.servo.period = 0.005;
  scenario.sim.step = 0.005;
  // The task is done within 2 mm: the view must be able to tell, and the image must say so.
  scenario.servo.convergence.max_mm_per_px = 8.0;
  scenario.servo.convergence.tolerance_mm = 0.8;
  scenario.active.planner.max_mm_per_px = scenario.servo.convergence.max_mm_per_px;
  scenario.sim.arm.encoder_bias = 0.3 * kDegree;
  scenario.sim.arm.encoder_noise = 0.005 * kDegree;
  scenario.sim.camera.latency_frames = 2;
  scenario.sim.camera.noise_grey = 2.0;
  scenario.sim.camera.noise_px = 0.3;
  // Each axis so that the whole error is about 3 mm and 0.3 degrees.
  scenario.sim.camera.position_error = 0.003 / std::sqrt(3.0);
  scenario.sim.camera.rotation_error = 0.3 / std::sqrt(3.0) * kDegree;
  scenario.sim.camera.focal_error = 0.005;
  return scenario;
}

bool DrawMotion(ArmSet arms, const MotionDemand& demand, Random* random, Draft* draft) {
  const ArmModel& arm = draft->scenario.task.view.arm;
  const int n = arm.size();
  draft->q_start.resize(n);
  for (int i = 0; i < n; ++i) {
    const JointLimits& limit = arm.limits()[static_cast<std::size_t>(i)];
    draft->q_start(i) = Uniform(random, limit.lower, limit.upper);
  }
  if (demand.q_start.size() == n) draft->q_start = demand.q_start;
  if (!Ordinary(arms, arm, draft->q_start)) return false;
  JointVector step(n);
  for (int i = 0; i < n; ++i) step(i) = Uniform(random, -1.0, 1.0);
  step *= Uniform(random, demand.least, demand.most) / step.lpNorm<Eigen::Infinity>();
  if (demand.half_turn) {
    step *= 0.15 / step.lpNorm<Eigen::Infinity>();
    step(n - 1) =
        (draft->q_start(n - 1) > 0.0 ? -1.0 : 1.0) * Uniform(random, 165.0, 180.0) * kDegree;
  }
  draft->q_goal = draft->q_start + step;
  if (demand.goal_near_singularity) {
    NearSingularity(arms, random, &draft->q_goal);
    if (!WithinLimits(arm, draft->q_goal)) return false;
  } else if (!Ordinary(arms, arm, draft->q_goal)) {
    return false;
  }
  draft->motion =
      SampleMotion(draft->scenario.task.view, draft->q_start, draft->q_goal, kMotionSamples);
  for (const ArmSample& sample : draft->motion) {
    if (!BodyClear(arm, sample) || FacesTheFloor(sample)) return false;
  }
  ArmKit kit = KitOf(arms, false);
  // Dots that turn on the spot sweep a circle: the goal's stand behind it.
  if (demand.half_turn) kit.goal_marker_E = Vector3d(0.05, 0.0, -0.045);
  PlaceGoal(kit, draft);
  return !RunsIntoGoal(*draft);
}

bool DrawGoalMotion(Random* random, Draft* draft) {
  constexpr int kPhases = 24;
  constexpr double kWay = 0.16, kWiggle = 0.06;  // [m]
  Scenario& scenario = draft->scenario;
  const ArmModel& arm = scenario.task.view.arm;
  std::normal_distribution<double> normal(0.0, 1.0);
  const auto along = [&](double length) {
    Vector3d direction(normal(*random), normal(*random), normal(*random));
    if (arm.size() == 2) direction.z() = 0.0;
    return Vector3d(length * direction.normalized());
  };
  GoalMotion& motion = scenario.sim.goal_motion;
  motion.a = along(kWay);
  motion.b = along(kWiggle);
  scenario.task.goal.max_speed = GreatestSpeed(motion);
  std::vector<Vector3d> p_EM;
  for (const Marker& marker : scenario.task.view.markers) p_EM.push_back(marker.p);
  JointVector q = draft->q_goal;
  for (int phase = 1; phase < kPhases; ++phase) {
    const Vector3d shift = GoalShift(motion, motion.period * phase / kPhases);
    std::vector<Vector3d> p_WG;
    for (const Vector3d& p : scenario.p_WG_true) p_WG.push_back(p + shift);
    const auto solution = SolveForPoints(arm, p_EM, p_WG, q, 1e-5);
    if (!solution.converged || (solution.q - q).lpNorm<Eigen::Infinity>() > 0.5) return false;
    q = solution.q;
    const ArmSample sample = SampleArm(scenario.task.view, q);
    if (!BodyClear(arm, sample) || FacesTheFloor(sample) || !AwayFromLimits(arm, q)) return false;
  }
  return true;
}

bool AllSeen(const Scenario& scenario, const std::vector<PlacedMarker>& markers,
             const ArmSample& arm, const std::vector<PlacedMarker>& goal_markers,
             const Isometry3d& X_WC) {
  return std::all_of(markers.begin(), markers.end(), [&](const PlacedMarker& marker) {
    return CheckMarkerAmong(scenario.task.view.camera, scenario.active.planner.limits, X_WC, marker,
                            arm, goal_markers) == ViewFault::kNone;
  });
}

bool SeesArm(const Draft& draft, int sample, const Isometry3d& X_WC) {
  const ArmSample& arm = draft.motion[static_cast<std::size_t>(sample)];
  return AllSeen(draft.scenario, arm.markers, arm, draft.goal_markers, X_WC);
}

bool SeesGoal(const Draft& draft, int sample, const Isometry3d& X_WC) {
  const ArmSample& arm = draft.motion[static_cast<std::size_t>(sample)];
  return AllSeen(draft.scenario, draft.goal_markers, arm, draft.goal_markers, X_WC);
}

double Observability(const Draft& draft, int sample, const Isometry3d& X_WC) {
  const ArmSample& at = draft.motion[static_cast<std::size_t>(sample)];
  return MeasureOf(CompositeJacobian(draft.scenario.task.view, at, X_WC)).geometric_mean();
}

RigVector DrawCamera(const Draft& draft, Random* random) {
  const CameraRig& rig = draft.scenario.rig;
  RigVector q_c(rig.size());
  for (int i = 0; i < rig.size(); ++i) {
    const RigAxis& axis = rig.axes[static_cast<std::size_t>(i)];
    // One turn is enough of what can turn twice.
    const double half = std::min(0.5 * (axis.upper - axis.lower), kPi);
    const double middle = 0.5 * (axis.upper + axis.lower);
    q_c(i) = Uniform(random, middle - half, middle + half);
  }
  const auto& a = draft.motion.front().markers.front().p_W;
  const auto& b = draft.goal_markers.front().p_W;
  return AimAt(rig, q_c, a + Uniform(random, 0.2, 0.8) * (b - a));
}

bool Feasible(const Draft& draft, Random* random) {
  const int last = static_cast<int>(draft.motion.size()) - 1;
  for (int i = 0; i < kFeasibilityDraws; ++i) {
    const Isometry3d X_WC = RigPose(draft.scenario.rig, DrawCamera(draft, random));
    if (!SeesGoal(draft, 0, X_WC) || !SeesGoal(draft, last, X_WC)) continue;
    bool all = true;
    for (int sample = last; sample >= 0 && all; --sample) all = SeesArm(draft, sample, X_WC);
    if (all && WorstMillimetresAt(draft, draft.motion.back(), X_WC) <=
                   draft.scenario.servo.convergence.max_mm_per_px) {
      return true;
    }
  }
  return false;
}

}  // namespace vantage::sim
