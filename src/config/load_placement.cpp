#include <algorithm>
#include <filesystem>
#include <optional>

#include "vantage/config/loaders.h"
#include "vantage/config/placement_file.h"
#include "vantage/config/scenario.h"
#include "vantage/features/marker.h"
#include "vantage/math/angles.h"
#include "vantage/math/error.h"
#include "vantage/plan/placement_model.h"
#include "vantage/robot/kinematics.h"

namespace vantage {
namespace {

constexpr double kFarthest = 1000.0;  // [m]

// What is placed for what: of a scenario, or the file's own.
struct Cell {
  ViewModel view;
  RigSetup rig;
  ViewLimits limits;
  bool pixels{true};
  BatchLens lens;
  std::optional<std::pair<JointVector, JointVector>> motion;  // start and goal of a scenario
  std::vector<PlacedMarker> scene_markers;
};

std::vector<BatchRow> RowsOf(const Section& root, const ViewModel& view) {
  std::vector<BatchRow> rows;
  for (const Feature& feature : view.features.features()) {
    if (feature.kind != FeatureKind::kPointX && feature.kind != FeatureKind::kPointY) {
      root.Fail("features", std::string("must be coordinates of points (point, point_x, point_y) "
                                        "where a camera is placed for them; ") +
                                NameOf(feature.kind) + " is not");
    }
    rows.push_back({feature.points[0], feature.kind == FeatureKind::kPointX ? 0 : 1});
  }
  if (rows.size() > 16) {
    root.Fail("features", "must be 16 rows at most, are " + std::to_string(rows.size()));
  }
  return rows;
}

Cell CellOfScenario(const Section& root, const Scenario& scenario) {
  const ViewModel& view = scenario.task.view;
  Cell cell{view, {scenario.rig, scenario.q_c_start}, scenario.active.planner.limits, true, {}, {},
            {}};
  std::vector<Eigen::Vector3d> p_EP, p_WP;
  for (std::size_t i = 0; i < view.markers.size(); ++i) {
    p_EP.push_back(view.markers[i].p);
    p_WP.push_back(scenario.p_WG_true[i]);
  }
  const PointGoalSolution goal = SolveForPoints(view.arm, p_EP, p_WP, scenario.sim.q_start);
  if (!(goal.rms_error < 1e-3)) {
    root.Fail("scenario",
              "has a goal that the arm misses by " + std::to_string(1e3 * goal.rms_error) + " mm");
  }
  const ServoGoal& shown = scenario.task.goal;
  for (std::size_t i = 0; i < shown.marker_ids.size(); ++i) {
    cell.scene_markers.push_back({shown.p_WG[i], shown.normals[i], shown.marker_radius});
  }
  cell.motion = std::make_pair(scenario.sim.q_start, goal.q);
  return cell;
}

Cell OwnCell(const Section& root) {
  const ArmModel arm = LoadRobotUnder(root, "robot");
  const std::vector<Marker> markers =
      LoadMarkers(root, "markers", 1, kMaxPoints, "Dots on the end effector, in its frame.");
  const int count = static_cast<int>(markers.size());
  const FeatureSet features(LoadFeatures(root, "features", count), count);
  const Section section = root.OptionalChild("camera", "Intrinsics of the camera.");
  Cell cell{{arm, CameraModel(), features, markers}, {}, {}, true, {}, {}, {}};
  cell.pixels = section.Choice<bool>(
      "units", {{"pixels", true}, {"metric", false}}, true,
      "Units of the features: pixels, or those of `focal` as in the paper (focal 1: normalised).");
  if (cell.pixels) {
    cell.view.camera = LoadCamera(section);
  } else {
    const double focal =
        section.Number("focal", {1e-6, 1e6, ""}, kRequired, "Metric units: the focal length f.");
    cell.view.camera = InUnits(CameraModel(), ImageUnits::kMetric, focal);
    cell.lens.fx = cell.lens.fy = focal;
    const Eigen::VectorXd half =
        section.FormOf("half_view") == Section::Form::kAbsent
            ? Eigen::VectorXd::Constant(2, 1e6)
            : section.Numbers("half_view", {1e-3, 1e6, ""}, 2, 2,
                              "Metric units: largest |x| and |y| in the image at unit distance.");
    cell.lens.x_min = -half(0);
    cell.lens.x_max = half(0);
    cell.lens.y_min = -half(1);
    cell.lens.y_max = half(1);
  }
  cell.rig =
      LoadRig(root.Child("camera_rig", "What carries the camera; limits are its workspace."));
  return cell;
}

BatchBox LoadBox(const Section& section) {
  BatchBox box;
  box.X_WB = LoadPose(section, "pose", true, "Of the box's centre in the world.");
  box.half = 0.5 * section.Vector3("size", {0.0, kFarthest, "m"}, kRequired, "Edge lengths.");
  return box;
}

std::vector<BatchBox> LoadBoxes(const Section& section, const std::string& key,
                                const std::string& help) {
  std::vector<BatchBox> boxes;
  for (const Section& box : section.Children(key, 0, 16, help)) boxes.push_back(LoadBox(box));
  return boxes;
}

PlanLimits LoadLimits(const Section& section, Cell* cell) {
  PlanLimits limits;
  ViewLimits& view = cell->limits;
  if (cell->pixels) {
    view.margin = section.Number("margin", {0.0, 10000.0, "px"}, view.margin,
                                 "Distance of markers to the image's border.");
    try {
      cell->lens = BatchLens::FromCamera(cell->view.camera, view.margin);
    } catch (const ConfigError& error) {
      section.Fail("margin", error.what());
    }
  }
  limits.depth.min = section.Number("min_depth", {0.001, kFarthest, "m"}, view.min_depth,
                                    "Least depth of a marker.");
  limits.depth.max = section.Number("max_depth", {0.001, kFarthest, "m"}, view.max_depth,
                                    "Greatest depth of a marker.");
  if (limits.depth.max <= limits.depth.min) section.Fail("max_depth", "must be above min_depth");
  if (section.FormOf("focus") != Section::Form::kAbsent) {
    const Eigen::VectorXd focus = section.Numbers("focus", {0.001, kFarthest, "m"}, 2, 2,
                                                  "Depths between which the lens is sharp.");
    if (!(focus(1) > focus(0))) section.Fail("focus", "must end farther than it begins");
    limits.focus = DepthLimits{focus(0), focus(1)};
  }
  double ring = 0.0;
  for (const Marker& marker : cell->view.markers) ring = std::max(ring, kRingRadii * marker.radius);
  for (const PlacedMarker& marker : cell->scene_markers)
    ring = std::max(ring, kRingRadii * marker.radius);
  limits.rim = section.Number(
      "rim", {0.0, 100.0, "m"}, cell->pixels ? ring : 0.0,
      "Radius about each marker that has to be in the image too; default: its ring's, in pixels.");
  limits.max_incidence = section.Degrees(
      "max_incidence_deg", {1.0, 180.0, "deg"}, view.max_incidence * kDegreesPerRadian,
      "Greatest angle between a marker's normal and the ray to it; 180: any.");
  limits.occlusion = section.Flag("occlusion", true, "Whether the arm's links hide markers.");
  limits.boxes = LoadBoxes(section, "boxes", "Things in the world that hide markers.");
  limits.keep_out = LoadBoxes(section, "keep_out", "Where the camera's centre must not be.");
  limits.clearance = section.Number("clearance", {0.0, kFarthest, "m"}, 0.0,
                                    "Distance of the camera's centre to keep_out boxes.");
  return limits;
}

PlanObjective LoadObjective(const Section& section) {
  PlanObjective objective;
  objective.quantity = section.Choice<PlanQuantity>(
      "of",
      {{"composite", PlanQuantity::kComposite},
       {"view", PlanQuantity::kView},
       {"weighted_sum", PlanQuantity::kWeightedSum},
       {"product", PlanQuantity::kProduct}},
      objective.quantity,
      "composite: J_c (eqs. 14, 16); view: J_v (eq. 13); weighted_sum: k_v w_v + k_r w_r (eq. 23); "
      "product: w_v w_r.");
  objective.aggregate = section.Choice<PlanAggregate>(
      "over", {{"integral", PlanAggregate::kIntegral}, {"worst", PlanAggregate::kWorst}},
      objective.aggregate, "Integral over the motion's time, or its least value (eq. 16).");
  objective.measure =
      section.Choice<BatchMeasure>("measure",
                                   {{"w", BatchMeasure::kW},
                                    {"log_w", BatchMeasure::kLogW},
                                    {"sigma_min", BatchMeasure::kSigmaMin},
                                    {"inverse_condition", BatchMeasure::kInverseCondition},
                                    {"trace", BatchMeasure::kNegativeTrace}},
                                   objective.measure,
                                   "What is measured of the Jacobian; trace: the sum of 1/sigma^2, "
                                   "which is made small.");
  objective.task = section.Choice<ViewTask>(
      "task", {{"body", ViewTask::kBody}, {"plane", ViewTask::kPlane}, {"space", ViewTask::kSpace}},
      objective.task,
      "Motions that J_v maps: the end effector's twist, or its translation along x and y or in "
      "space.");
  objective.k_v = section.Number("k_v", {0.0, 1e12, ""}, objective.k_v, "Weight of w_v (eq. 23).");
  objective.k_r = section.Number("k_r", {0.0, 1e12, ""}, objective.k_r, "Weight of w_r (eq. 23).");
  return objective;
}

PoseUncertainty LoadUncertainty(const Section& section) {
  PoseUncertainty uncertainty;
  uncertainty.position = section.Number("position", {0.0, 10.0, "m"}, 0.0,
                                        "Standard deviation of the camera's place, each axis.");
  uncertainty.rotation =
      section.Degrees("rotation_deg", {0.0, 45.0, "deg"}, 0.0, "The same of its rotation vector.");
  uncertainty.worst = section.Choice<bool>("by", {{"mean", false}, {"worst", true}}, false,
                                           "Mean over the perturbed poses, or the worst of them "
                                           "(two standard deviations along each axis).");
  return uncertainty;
}

ArmMotion LoadMotion(const Section& section, const Cell& cell) {
  const double duration =
      section.Number("duration", {1e-6, 86400.0, "s"}, 1.0, "Of the whole motion.");
  const int samples = static_cast<int>(
      section.Integer("samples", 1, 4096, 128, "Configurations it is measured at."));
  if (section.FormOf("poses") != Section::Form::kAbsent) {
    std::vector<Eigen::Isometry3d> poses;
    for (const Section& pose :
         section.Children("poses", 1, 256, "Poses of the end effector that the motion passes.")) {
      Eigen::Isometry3d X_WE = LoadPose(pose, "pose", true, "In the world.");
      poses.push_back(X_WE);
    }
    const PathFrame frame = section.Choice<PathFrame>(
        "keep", {{"position", PathFrame::kPosition}, {"pose", PathFrame::kPose}}, PathFrame::kPose,
        "Whether the poses' orientations count.");
    const JointVector q_near =
        LoadJoints(section, "near", cell.view.arm, "Joints near those of the first pose.");
    return MoveThroughPoses(cell.view, poses, frame, q_near, duration, samples);
  }
  std::vector<JointVector> waypoints;
  if (section.FormOf("joints") == Section::Form::kAbsent && cell.motion) {
    waypoints = {cell.motion->first, cell.motion->second};
  } else {
    for (const Section& point :
         section.Children("joints", 1, 256, "Joints that the motion passes.")) {
      waypoints.push_back(LoadJoints(point, "at", cell.view.arm, "Joints of a waypoint."));
    }
    if (waypoints.empty()) section.Fail("", "needs joints or poses that the motion passes");
  }
  return MoveThroughJoints(cell.view, waypoints, duration, samples);
}

PlacementSearch LoadSearch(const Section& section) {
  PlacementSearch search;
  const auto count = [&](const char* key, int most, int fallback, const char* help) {
    return static_cast<int>(section.Integer(key, fallback == 0 ? 0 : 1, most, fallback, help));
  };
  search.grid = count("grid", 10000000, 0, "Cameras scored at first; 0: by the free axes.");
  search.starts = count("starts", 4096, 0, "Hills that are climbed; 0: by the free axes.");
  search.members =
      count("members", 4096, 0, "Of a generation of an evolution strategy; 0: by the free axes.");
  if (search.members > 0 && search.members < 4) section.Fail("members", "must be 0 or >= 4");
  search.generations =
      count("generations", 100000, 0, "Of the evolution; 0: by the free axes and the objective.");
  search.polished = count("polished", 4096, search.polished, "Ends that are polished.");
  search.seed = static_cast<std::uint64_t>(
      section.Integer("seed", 0, 1000000000, 1, "Of the search's random numbers."));
  return search;
}

PlacementSetup Assemble(const Section& root, const Cell& given, const std::string& name) {
  Cell cell = given;
  PlacementSetup setup{name, "", "", cell.pixels, cell.view, {}, {}, false, {}, {}, 0};
  setup.problem.limits =
      LoadLimits(root.OptionalChild("limits", "What every view must keep."), &cell);
  setup.problem.lens = cell.lens;
  setup.problem.rig = cell.rig.rig;
  setup.problem.q_c_start = cell.rig.q_c_start;
  setup.problem.scene_markers = cell.scene_markers;
  setup.problem.rows = RowsOf(root, cell.view);
  setup.problem.objective =
      LoadObjective(root.OptionalChild("objective", "What a camera is worth."));
  setup.problem.uncertainty = LoadUncertainty(
      root.OptionalChild("robust", "How well the camera will stand where it is placed."));
  setup.problem.motion =
      LoadMotion(root.OptionalChild("motion", "The arm's motion that is to be seen."), cell);
  const Section search = root.OptionalChild("search", "How hard to search.");
  setup.search = LoadSearch(search);
  setup.path_search.states = static_cast<int>(
      search.Integer("path_states", 2, 20000, setup.path_search.states,
                     "Camera coordinates of the coarse lattice of a camera path."));
  setup.path_search.rounds = static_cast<int>(search.Integer(
      "path_rounds", 1, 10000, setup.path_search.rounds, "Refinements of a camera path."));
  setup.camera_moves = root.Flag(
      "camera_moves", false,
      "Also plans how the camera moves along with the arm within its rig's speeds (eq. 15).");
  return setup;
}

PlacementSetup OfScenario(const Scenario& scenario) {
  const Section nothing = ParseConfig({"scenario " + scenario.name, "", "description: none"});
  PlacementSetup setup = Assemble(nothing, CellOfScenario(nothing, scenario), scenario.name);
  setup.scenario = scenario.name;
  setup.description = scenario.description;
  return setup;
}

std::vector<double> LoadSteps(const Section& base, const std::string& key, bool turns,
                              const std::string& help) {
  if (base.FormOf(key) == Section::Form::kAbsent) return {0.0};
  const Section section = base.Child(key, help);
  const auto read = [&](const std::string& name) {
    return turns
               ? section.Degrees(name + "_deg", {-360.0, 360.0, "deg"}, kRequired,
                                 "End of the range.")
               : section.Number(name, {-kFarthest, kFarthest, "m"}, kRequired, "End of the range.");
  };
  const double from = read("from"), to = read("to");
  const auto count = static_cast<int>(
      section.Integer("samples", 1, 100000, kRequired, "Values in the range, both ends included."));
  std::vector<double> steps;
  for (int i = 0; i < count; ++i) {
    steps.push_back(count == 1 ? from : from + (to - from) * i / (count - 1));
  }
  return steps;
}

constexpr std::size_t kMostItems = 1000000;

// Every combination, yaw fastest; without a base where the arm stands.
std::vector<BaseShift> LoadBases(const Section& root, const Section& sweep) {
  const Section base = sweep.OptionalChild("base", "Shift of the arm's base in the world.");
  if (base.present() &&
      root.OptionalChild("motion", "").FormOf("poses") != Section::Form::kAbsent) {
    base.Fail("", "needs a motion by joints: poses in the world do not move with the base");
  }
  const std::vector<double> xs = LoadSteps(base, "x", false, "Along x.");
  const std::vector<double> ys = LoadSteps(base, "y", false, "Along y.");
  const std::vector<double> zs = LoadSteps(base, "z", false, "Along z.");
  const std::vector<double> yaws = LoadSteps(base, "yaw", true, "Turn about z.");
  std::size_t items = 1;
  for (const std::vector<double>* steps : {&xs, &ys, &zs, &yaws}) {
    items *= steps->size();  // at most 1e5 each, and not above kMostItems before: no overflow
    if (items > kMostItems) base.Fail("", "must have a million items at most");
  }
  std::vector<BaseShift> bases;
  for (const double x : xs) {
    for (const double y : ys) {
      for (const double z : zs) {
        for (const double yaw : yaws) bases.push_back({{x, y, z}, yaw});
      }
    }
  }
  return bases;
}

// FNV-1a.
std::uint64_t FingerprintOf(const std::string& text) {
  std::uint64_t hash = 14695981039346656037ULL;
  for (const char c : text) {
    hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211ULL;
  }
  return hash;
}

bool IsBuiltIn(ConfigKind kind, const std::string& name) {
  const std::vector<std::string> names = BuiltInConfigs(kind);
  return std::find(names.begin(), names.end(), name) != names.end();
}

ConfigText FindProblem(const std::string& name_or_path) {
  try {
    return FindConfigText(ConfigKind::kProblem, name_or_path);
  } catch (const ConfigError& error) {
    if (error.key() != "problem") throw;  // A path.
    throw ConfigError("", "", std::string(error.what()) + ", nor a built-in scenario");
  }
}

// One problem: a file without a sweep, or a case of one.
PlacementSetup LoadOne(const Section& root, const std::string& name, const std::string& source) {
  const std::string description = root.Text("description", std::string("-"), "One line.");
  const bool of_scenario = root.FormOf("scenario") != Section::Form::kAbsent;
  const std::string scenario =
      of_scenario ? root.Text("scenario", kRequired,
                              "Scenario (built in or a file) whose arm, markers, features, camera, "
                              "rig, view limits and motion are taken.")
                  : "";
  PlacementSetup setup =
      of_scenario
          ? Assemble(root,
                     CellOfScenario(root, ReadScenario(FindConfigText(ConfigKind::kScenario,
                                                                      scenario, root.folder()),
                                                       scenario)),
                     name)
          : Assemble(root, OwnCell(root), name);
  root.RejectUnknownKeys();
  setup.description = description;
  setup.scenario = scenario;
  try {
    static_cast<void>(PlacementModel(setup.problem));  // What no key can say alone.
  } catch (const ConfigError& error) {
    throw ConfigError(source, "", error.what());
  }
  return setup;
}

// Each case is the file's problem with the case's keys in place of the file's.
PlacementSetup LoadSweep(const Section& root, const std::string& name, const std::string& source) {
  const Section sweep =
      root.Child("sweep", "Problems that are compared, each with a camera of its own to be found.");
  std::vector<Section> cases = sweep.Children(
      "cases", 0, static_cast<int>(kMostItems),
      "What differs: every other key of a case takes the place of the problem's (robot, camera, "
      "camera_rig, motion, scenario, limits, ...). Together with `base` every combination is an "
      "item.");
  const std::vector<std::string> of_the_file{"sweep", "search", "camera_moves", "description"};
  for (const Section& one : cases) {
    for (const std::string& key : of_the_file) {
      if (one.FormOf(key) != Section::Form::kAbsent) one.Fail(key, "is not for a case to say");
    }
  }
  std::optional<PlacementSetup> setup;
  PlacementSweep items;
  const auto add = [&](const Section& problem, const std::string& case_name) {
    if (items.bases.empty()) items.bases = LoadBases(problem, sweep);
    PlacementSetup loaded = LoadOne(problem, name, source);
    items.cases.push_back({case_name, loaded.view, loaded.problem});
    if (!setup) setup = std::move(loaded);
  };
  if (cases.empty()) {
    if (sweep.FormOf("base") == Section::Form::kAbsent) sweep.Fail("", "needs base, cases or both");
    add(root.With(nullptr, {"sweep"}), name);
  }
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const std::string case_name =
        cases[i].Text("name", std::to_string(i + 1), "Of the case, in the table.");
    if (case_name.find_first_of(",\"") != std::string::npos) {
      cases[i].Fail("name", "must be without commas and quotes");
    }
    add(root.With(&cases[i], {"sweep", "name"}), case_name);
  }
  if (items.cases.size() * items.bases.size() > kMostItems) {
    sweep.Fail("", "must have a million items at most");
  }
  if (setup->camera_moves) root.Fail("camera_moves", "does not go with a sweep");
  sweep.RejectUnknownKeys();
  setup->sweep = std::move(items);
  return *std::move(setup);
}

}  // namespace

PlacementSetup LoadPlacement(const std::string& name_or_path, SchemaRecorder* recorder) {
  if (!IsBuiltIn(ConfigKind::kProblem, name_or_path) &&
      IsBuiltIn(ConfigKind::kScenario, name_or_path)) {
    return OfScenario(LoadScenario(name_or_path));
  }
  return ReadPlacement(FindProblem(name_or_path),
                       std::filesystem::path(name_or_path).stem().string(), recorder);
}

PlacementSetup ReadPlacement(const ConfigText& text, const std::string& name,
                             SchemaRecorder* recorder) {
  const Section root = ParseConfig(text, recorder);
  // A scenario's file: it has a goal, which no problem has.
  if (root.FormOf("goal") != Section::Form::kAbsent) return OfScenario(ReadScenario(text, name));
  PlacementSetup setup = root.FormOf("sweep") == Section::Form::kAbsent
                             ? LoadOne(root, name, text.source)
                             : LoadSweep(root, name, text.source);
  setup.fingerprint = FingerprintOf(text.text);
  return setup;
}

PlacementProblem ProblemAt(const PlacementSweep& sweep, int item) {
  const BaseShift& base = sweep.BaseOf(item);
  Eigen::Isometry3d X_W = Eigen::Isometry3d::Identity();
  X_W.translation() = base.shift;
  X_W.linear() = Eigen::AngleAxisd(base.yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  const PlacementCase& cell = sweep.CaseOf(item);
  ViewModel view = cell.view;
  view.arm = view.arm.WithBase(X_W * view.arm.X_WBase());
  PlacementProblem problem = cell.problem;
  for (ArmSample& sample : problem.motion.samples) sample = SampleArm(view, sample.q);
  return problem;
}

}  // namespace vantage
