#include "sim/suite/suite.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "sim/goal_motion.h"
#include "sim/suite/draft.h"
#include "vantage/math/angles.h"
#include "vantage/math/error.h"

namespace vantage::sim {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr int kTaskDraws = 2000000;
constexpr int kCameraDraws = 3000;

const char* NameOf(ArmSet arms) {
  switch (arms) {
    case ArmSet::kPlanar2:
      return "planar2";
    case ArmSet::kPuma3Xyx:
      return "puma3-xyx";
    case ArmSet::kPuma3Points:
      return "puma3-points";
    case ArmSet::kPuma560:
      return "puma560";
  }
  return "?";
}

// What a view is worth that will not do.
constexpr double kNever = std::numeric_limits<double>::infinity();

// How a scenario's camera start is chosen among random ones that see all markers at the start: the one
// with the least value of these many, those of kNever left out.
struct CameraChoice {
  int count{1};
  std::function<double(const Draft&, const Isometry3d&)> value;
};

int Last(const Draft& draft) {
  return static_cast<int>(draft.motion.size()) - 1;
}

// Log of the least observability at motion[from] to motion[to].
double LogLeast(const Draft& draft, const Isometry3d& X_WC, int from, int to) {
  double least = std::numeric_limits<double>::infinity();
  for (int i = from; i <= to; ++i) least = std::min(least, Observability(draft, i, X_WC));
  return std::log(std::max(least, 1e-9));
}

double LogMean(const Draft& draft, const Isometry3d& X_WC) {
  double sum = 0.0;
  for (int i = 0; i <= Last(draft); ++i) {
    sum += std::log(std::max(Observability(draft, i, X_WC), 1e-9));
  }
  return sum / (Last(draft) + 1);
}

CameraChoice AnyView() {
  return {1, [](const Draft&, const Isometry3d&) { return 0.0; }};
}

CameraChoice WorstView() {
  return {24, LogMean};
}

// Start and goal are seen well, and between them the view is as good as singular.
CameraChoice SingularOnTheWay() {
  return {60, [](const Draft& draft, const Isometry3d& X_WC) {
            const int last = Last(draft);
            for (int i = 0; i <= last; ++i) {
              if (!SeesArm(draft, i, X_WC)) return kNever;
            }
            const double ends = 0.5 * (std::log(Observability(draft, 0, X_WC)) +
                                       std::log(Observability(draft, last, X_WC)));
            return LogLeast(draft, X_WC, 1, last - 1) - ends;
          }};
}

CameraChoice SingularAtGoal() {
  return {60, [](const Draft& draft, const Isometry3d& X_WC) {
            return LogLeast(draft, X_WC, Last(draft), Last(draft)) -
                   0.5 * LogLeast(draft, X_WC, 0, 0);
          }};
}

CameraChoice HiddenOnTheWay() {
  return {1, [](const Draft& draft, const Isometry3d& X_WC) {
            const int last = Last(draft);
            if (!SeesArm(draft, last, X_WC)) return kNever;
            for (int i = 1; i < last; ++i) {
              const ArmSample& sample = draft.motion[static_cast<std::size_t>(i)];
              for (const PlacedMarker& marker : sample.markers) {
                if (IsHidden(X_WC.translation(), marker, sample.capsules)) return 0.0;
              }
            }
            return kNever;
          }};
}

CameraChoice HiddenAtGoal() {
  return {1, [](const Draft& draft, const Isometry3d& X_WC) {
            const ArmSample& goal = draft.motion.back();
            for (const PlacedMarker& marker : goal.markers) {
              if (IsHidden(X_WC.translation(), marker, goal.capsules)) return 0.0;
            }
            return kNever;
          }};
}

// Along the markers' common normal.
CameraChoice FaceOn() {
  return {1, [](const Draft& draft, const Isometry3d& X_WC) {
            const PlacedMarker& marker = draft.motion.front().markers.front();
            const Vector3d ray = (X_WC.translation() - marker.p_W).normalized();
            return ray.dot(marker.normal_W) > std::cos(15.0 * kDegree) ? 0.0 : kNever;
          }};
}

struct Recipe {
  MotionDemand motion;
  CameraChoice camera;
  std::function<void(Random*, Draft*)> change_cell;  // once start and goal are drawn
  std::function<void(Random*, Scenario*)> add_error;
  bool housed{false};
  bool goal_moves{false};
  int more_goals{0};  // of a sequence
};

// Direction round the cell from which the markers can be seen at the goal, give or take 60 degrees.
double FrontAzimuth(Random* random, const Draft& draft) {
  const Vector3d& normal_W = draft.goal_markers.front().normal_W;
  const bool upwards = normal_W.head<2>().norm() < 0.2;
  const double front =
      upwards ? Uniform(random, -kPi, kPi) : std::atan2(normal_W.y(), normal_W.x());
  return front + Uniform(random, -60.0, 60.0) * kDegree;
}

void OnRail(Random* random, Draft* draft) {
  CameraRig& rig = draft->scenario.rig;
  const CameraRig dome = rig;
  const double azimuth = FrontAzimuth(random, *draft);
  const double distance = dome.axes[0].lower;
  const Vector3d out(std::cos(azimuth), std::sin(azimuth), 0.0);
  rig.kind = RigKind::kRail;
  rig.rail_W = Vector3d(-out.y(), out.x(), 0.0);
  // Looks at the dome's centre from above.
  const Vector3d p_WC = dome.target_W + 0.75 * distance * out + Vector3d(0, 0, 0.65 * distance);
  const Vector3d z = (dome.target_W - p_WC).normalized();
  const Vector3d x = z.cross(Vector3d::UnitZ()).normalized();
  rig.X_WC_fixed.linear() << x, z.cross(x), z;
  rig.X_WC_fixed.translation() = p_WC;
  RigAxis along = dome.axes[0];
  along.name = "s";
  along.lower = -1.2;
  along.upper = 1.2;
  rig.axes = {along, dome.axes[4], dome.axes[5]};
}

void OnSector(Random* random, Draft* draft) {
  RigAxis& phi = draft->scenario.rig.axes[2];
  const double middle = std::remainder(FrontAzimuth(random, *draft), 2.0 * kPi);
  phi.lower = middle - 30.0 * kDegree;
  phi.upper = middle + 30.0 * kDegree;
}

void Slow(Random* /*random*/, Draft* draft) {
  CameraRig& rig = draft->scenario.rig;
  rig.max_linear_speed *= 0.25;
  for (RigAxis& axis : rig.axes) axis.max_speed *= 0.25;
}

void Degrade(Random* /*random*/, Draft* draft) {
  SimOptions& sim = draft->scenario.sim;
  sim.camera.noise_grey = 6.0;
  sim.camera.noise_px = 1.0;
  sim.camera.latency_frames = 5;
  sim.camera.drop_rate = 0.3;
  sim.camera.position_error *= 4.0;
  sim.camera.rotation_error *= 4.0;
  sim.camera.focal_error *= 3.0;
  sim.arm.encoder_bias *= 3.0;
}

void MisplacePrior(double least, double most, double sigma, Random* random, Scenario* scenario) {
  std::normal_distribution<double> normal(0.0, 1.0);
  Vector3d direction(normal(*random), normal(*random), normal(*random));
  if (scenario->task.view.arm.size() == 2) direction.z() = 0.0;  // The plane is known.
  const Vector3d error = Uniform(random, least, most) * direction.normalized();
  for (Vector3d& p_WG : scenario->task.goal.p_WG) p_WG += error;
  scenario->task.goal.prior_sigma = sigma;
}

void OrdinaryPrior(Random* random, Scenario* scenario) {
  MisplacePrior(0.01, 0.03, 0.03, random, scenario);
}

void WrongPrior(Random* random, Scenario* scenario) {
  MisplacePrior(0.12, 0.25, 0.03, random, scenario);
}

Recipe RecipeOf(const std::string& scenario) {
  Recipe recipe{{}, WorstView(), {}, OrdinaryPrior};
  if (scenario == "S2") {
    recipe.camera = SingularOnTheWay();
  } else if (scenario == "S3") {
    recipe.camera = SingularAtGoal();
  } else if (scenario == "S4") {
    recipe.camera = HiddenOnTheWay();
    recipe.housed = true;
    recipe.motion.most = 1.4;
  } else if (scenario == "S5") {
    recipe.camera = HiddenAtGoal();
    recipe.housed = true;
    recipe.motion.most = 1.4;
  } else if (scenario == "S6") {
    recipe.camera = FaceOn();
    recipe.motion.half_turn = true;
  } else if (scenario == "S7") {
    recipe.camera = AnyView();
    recipe.motion.goal_near_singularity = true;
  } else if (scenario == "S8a") {
    recipe.change_cell = OnRail;
  } else if (scenario == "S8b") {
    recipe.change_cell = OnSector;
  } else if (scenario == "S9") {
    recipe.change_cell = Degrade;
  } else if (scenario == "S10") {
    recipe.add_error = WrongPrior;
  } else if (scenario == "S11") {
    recipe.change_cell = Slow;
  } else if (scenario == "S12") {
    recipe.camera = AnyView();
    recipe.motion.least = 1.4;
    recipe.motion.most = 2.2;
  } else if (scenario == "follow") {
    recipe.goal_moves = true;
  } else if (scenario == "sequence") {
    recipe.more_goals = 9;
  }
  return recipe;
}

std::optional<RigVector> ChooseCamera(const CameraChoice& choice, const Draft& draft,
                                      Random* random) {
  std::optional<RigVector> best;
  double least = kNever;
  for (int draw = 0, seen = 0; draw < kCameraDraws && seen < choice.count; ++draw) {
    const RigVector q_c = DrawCamera(draft, random);
    const Isometry3d X_WC = RigPose(draft.scenario.rig, q_c);
    if (!SeesGoal(draft, 0, X_WC) || !SeesArm(draft, 0, X_WC)) continue;
    const double value = choice.value(draft, X_WC);
    if (value == kNever) continue;
    ++seen;
    if (best && value >= least) continue;
    best = q_c;
    least = value;
  }
  return best;
}

// Each goal's motion starts where the one before ends.
bool AddGoals(ArmSet arms, const Recipe& recipe, const Scenario& cell, Random* random,
              SuiteTask* task) {
  constexpr int kDraws = 20000;
  MotionDemand demand = recipe.motion;
  demand.q_start = task->q_goal;
  for (int draw = 0; draw < kDraws; ++draw) {
    if (static_cast<int>(task->next.size()) == recipe.more_goals) return true;
    Draft draft{cell, {}, {}, {}, {}};
    if (!DrawMotion(arms, demand, random, &draft) || !Feasible(draft, random)) continue;
    Scenario& scenario = draft.scenario;
    recipe.add_error(random, &scenario);
    task->next.push_back(
        {scenario.task.goal, scenario.sim.goal_markers, scenario.p_WG_true, draft.q_goal});
    demand.q_start = draft.q_goal;
  }
  return static_cast<int>(task->next.size()) == recipe.more_goals;
}

const std::vector<std::pair<const char*, std::vector<ArmSet>>>& Table() {
  using A = ArmSet;
  static const std::vector<std::pair<const char*, std::vector<ArmSet>>> table{
      {"S1", {A::kPlanar2, A::kPuma3Xyx, A::kPuma3Points, A::kPuma560}},
      {"S2", {A::kPuma3Xyx, A::kPuma3Points, A::kPuma560}},
      {"S3", {A::kPuma3Xyx, A::kPuma3Points, A::kPuma560}},
      {"S4", {A::kPuma3Points, A::kPuma560, A::kPlanar2}},
      {"S5", {A::kPuma3Points, A::kPuma560, A::kPlanar2}},
      {"S6", {A::kPuma560}},
      {"S7", {A::kPlanar2, A::kPuma3Points, A::kPuma560}},
      {"S8a", {A::kPuma3Points, A::kPuma560}},
      {"S8b", {A::kPuma3Points, A::kPuma560}},
      {"S9", {A::kPlanar2, A::kPuma3Points, A::kPuma560}},
      {"S10", {A::kPuma3Points, A::kPuma560}},
      {"S11", {A::kPuma3Points, A::kPuma560}},
      {"S12", {A::kPlanar2, A::kPuma3Points, A::kPuma560}},
  };
  return table;
}

// Played by their own names alone.
const std::vector<std::pair<const char*, std::vector<ArmSet>>>& LongTasks() {
  using A = ArmSet;
  static const std::vector<std::pair<const char*, std::vector<ArmSet>>> table{
      {"follow", {A::kPlanar2, A::kPuma560}},
      {"sequence", {A::kPlanar2, A::kPuma3Points, A::kPuma560}},
  };
  return table;
}

// The suite that the tests run: one row for each kind of trouble, small ones.
const std::vector<std::string>& QuickRows() {
  static const std::vector<std::string> rows{"S5/planar2", "S1/puma3-xyx", "S1/puma560",
                                             "S5/puma3-points"};
  return rows;
}

std::uint64_t SeedOf(const SuiteEntry& entry, std::uint64_t seed) {
  std::uint64_t hash = 1469598103934665603u;  // FNV-1a, so that no two rows share a seed.
  for (const char c : Name(entry)) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211u;
  return hash ^ (seed * 0x9e3779b97f4a7c15u);
}

}  // namespace

std::string Name(const SuiteEntry& entry) {
  return entry.scenario + "/" + NameOf(entry.arms);
}

std::vector<SuiteEntry> SuiteEntries(const std::string& suite) {
  std::vector<SuiteEntry> entries;
  const std::string scenario = suite == "bad-starts" ? "S1" : suite;
  for (const auto& [name, arm_sets] : Table()) {
    for (const ArmSet arms : arm_sets) {
      const SuiteEntry entry{name, arms};
      const auto& quick = QuickRows();
      const bool in_quick =
          suite == "quick" && std::find(quick.begin(), quick.end(), Name(entry)) != quick.end();
      const bool family = scenario == "S8" && entry.scenario.rfind("S8", 0) == 0;
      if (scenario == "all" || scenario == name || scenario == Name(entry) || in_quick || family) {
        entries.push_back(entry);
      }
    }
  }
  for (const auto& [name, arm_sets] : LongTasks()) {
    for (const ArmSet arms : arm_sets) {
      const SuiteEntry entry{name, arms};
      if (suite == name || suite == Name(entry)) entries.push_back(entry);
    }
  }
  if (entries.empty()) {
    throw ConfigError(
        "", "suite",
        "must be bad-starts, all, quick, follow, sequence, a scenario (S1 to S12) or a row such as "
        "S4/planar2, is " +
            suite);
  }
  return entries;
}

bool Follows(const Scenario& scenario) {
  return GreatestSpeed(scenario.sim.goal_motion) > 0.0;
}

SuiteTask MakeSuiteTask(const SuiteEntry& entry, std::uint64_t seed) {
  const std::uint64_t mixed = SeedOf(entry, seed);
  Random random(mixed);
  const Recipe recipe = RecipeOf(entry.scenario);
  const Scenario cell = MakeCell(entry.arms, recipe.housed);
  for (int draw = 0; draw < kTaskDraws; ++draw) {
    Draft draft{cell, {}, {}, {}, {}};
    if (!DrawMotion(entry.arms, recipe.motion, &random, &draft)) continue;
    if (recipe.change_cell) recipe.change_cell(&random, &draft);
    if (!Feasible(draft, &random)) continue;
    if (recipe.goal_moves && !DrawGoalMotion(&random, &draft)) continue;
    const std::optional<RigVector> q_c = ChooseCamera(recipe.camera, draft, &random);
    if (!q_c) continue;
    Scenario& scenario = draft.scenario;
    scenario.q_c_start = *q_c;
    scenario.name = Name(entry) + "/" + std::to_string(seed);
    scenario.description = "seed " + std::to_string(seed);
    scenario.sim.q_start = draft.q_start;
    scenario.sim.seed = mixed % 1000000000u;
    recipe.add_error(&random, &scenario);
    SuiteTask task{scenario, draft.q_goal, {}};
    if (!AddGoals(entry.arms, recipe, cell, &random, &task)) continue;
    return task;
  }
  throw Error("suite: no task found for " + Name(entry) + ", seed " + std::to_string(seed));
}

}  // namespace vantage::sim
