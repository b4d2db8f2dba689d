#include "measure_setup.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

#include "vantage/active/trigger.h"
#include "vantage/config/loaders.h"
#include "vantage/config/oracle_case.h"
#include "vantage/math/angles.h"
#include "vantage/observability/measures.h"

namespace vantage {
namespace {

constexpr double kFarthest = 1000.0;  // [m]

// The camera's model, and whether it speaks in pixels.
std::pair<CameraModel, bool> LoadLens(const Section& root) {
  const Section section = root.OptionalChild("camera", "Intrinsics of the camera.");
  const auto units = section.Choice<ImageUnits>(
      "units",
      {{"pixels", ImageUnits::kPixels},
       {"normalised", ImageUnits::kNormalised},
       {"metric", ImageUnits::kMetric}},
      ImageUnits::kPixels,
      "Units of the features: pixels, those of the plane at unit distance, "
      "or those of `focal` as in the paper.");
  if (units == ImageUnits::kPixels) return {LoadCamera(section), true};
  const double focal = units == ImageUnits::kNormalised
                           ? 1.0
                           : section.Number("focal", {1e-6, 1e6, ""}, kRequired,
                                            "Metric units: the focal length f.");
  return {InUnits(CameraModel{}, units, focal), false};
}

RigSetup LoadSphere(const Section& section) {
  RigSetup setup;
  setup.rig.kind = RigKind::kSpherical;
  setup.rig.orientation = section.Choice<RigOrientation>(
      "orientation",
      {{"look_at", RigOrientation::kLookAt}, {"fixed_down", RigOrientation::kFixedDown}},
      RigOrientation::kLookAt, "The camera looks at the target, or always straight down.");
  setup.rig.target_W = section.Vector3("target", {-kFarthest, kFarthest, "m"},
                                       Eigen::Vector3d(0, 0, 0), "Centre of the sphere.");
  setup.q_c_start.resize(4);
  setup.q_c_start(0) = section.Number("R", {1e-3, kFarthest, "m"}, kRequired, "Distance.");
  setup.q_c_start(1) = section.Degrees("theta_deg", {0.0, 180.0, "deg"}, kRequired,
                                       "Angle from the world's z axis.");
  setup.q_c_start(2) = section.Degrees("phi_deg", {-3600.0, 3600.0, "deg"}, 0.0,
                                       "Angle about the world's z axis, from x.");
  setup.q_c_start(3) =
      section.Degrees("roll_deg", {-3600.0, 3600.0, "deg"}, 0.0, "Turn about the optical axis.");
  // The axes are free: a map sweeps them where it likes.
  setup.rig.axes = {{"R", 1e-3, kFarthest, 1.0, 1.0},
                    {"theta", 0.0, kPi, 1.0, 1.0},
                    {"phi", -20.0 * kPi, 20.0 * kPi, 1.0, 1.0},
                    {"roll", -20.0 * kPi, 20.0 * kPi, 1.0, 1.0}};
  return setup;
}

// The one of the keys that the file has.
std::string OneOf(const Section& root, const std::vector<std::string>& keys,
                  const std::string& what) {
  std::string found, names;
  for (const std::string& key : keys) {
    names += (names.empty() ? "" : ", ") + key;
    if (root.FormOf(key) == Section::Form::kAbsent) continue;
    if (!found.empty()) root.Fail(key, "must not be given beside " + found);
    found = key;
  }
  if (found.empty()) root.Fail("", what + " is missing: one of " + names);
  return found;
}

void LoadMount(const Section& root, MeasureSetup* setup) {
  const std::string key = OneOf(
      root, {"camera_sphere", "camera_pose", "camera_in_hand", "camera_rig"}, "the camera's place");
  RigSetup rig;
  if (key == "camera_sphere") {
    rig = LoadSphere(root.Child(key, "Camera by spherical coordinates about a target."));
  } else if (key == "camera_pose") {
    rig.rig.X_WC_fixed = LoadCameraPose(root, key, "The camera's optical frame in the world.");
  } else if (key == "camera_in_hand") {
    setup->eye_in_hand = true;
    setup->X_EC = LoadPose(root, key, true, "The camera's optical frame in the end effector's.");
  } else {
    rig = LoadRig(root.Child(key, "A rig as scenarios have it; measured at its start."));
  }
  setup->rig = rig.rig;
  setup->q_c = rig.q_c_start;
}

std::vector<MeasuredPoint> LoadPoints(const Section& root) {
  const std::string key = OneOf(root, {"points", "markers"}, "what is seen");
  std::vector<MeasuredPoint> points;
  if (key == "markers") {
    for (const Marker& marker :
         LoadMarkers(root, key, 1, kMaxPoints,
                     "Markers on the end effector, seen from their front alone.")) {
      points.push_back({marker, true, true});
    }
    return points;
  }
  for (const Section& section : root.Children(key, 1, kMaxPoints, "Points that are seen.")) {
    MeasuredPoint point;
    point.marker.id = static_cast<int>(points.size());
    point.marker.p = section.Vector3("position", {-kFarthest, kFarthest, "m"}, kRequired,
                                     "In the frame it is fixed to.");
    point.on_body = section.Choice<bool>("frame", {{"end_effector", true}, {"world", false}}, true,
                                         "Frame that the point is fixed to.");
    points.push_back(point);
  }
  return points;
}

std::vector<JointVector> LoadWaypoints(const Section& root, const ArmModel& arm) {
  std::vector<JointVector> waypoints;
  if (root.FormOf("path") == Section::Form::kAbsent) return waypoints;
  for (const Section& point :
       root.Children("path", 2, 64, "Joints of a trajectory: straight lines between these.")) {
    waypoints.push_back(LoadJoints(point, "joints", arm, "Joints of a waypoint."));
  }
  return waypoints;
}

// Covariance of the features' errors: independent ones by their standard deviations, or all of it.
Eigen::MatrixXd LoadCovariance(const Section& root, int k) {
  if (root.FormOf("feature_sigmas") != Section::Form::kAbsent &&
      root.FormOf("feature_covariance") != Section::Form::kAbsent) {
    root.Fail("feature_covariance", "must not be given beside feature_sigmas");
  }
  if (root.FormOf("feature_sigmas") != Section::Form::kAbsent) {
    const Eigen::VectorXd sigmas =
        root.Numbers("feature_sigmas", {1e-9, 1e9, ""}, k, k,
                     "Standard deviation of each feature's error, in its unit.");
    return sigmas.cwiseAbs2().asDiagonal();
  }
  if (root.FormOf("feature_covariance") == Section::Form::kAbsent) return {};
  const Eigen::VectorXd entries =
      root.Numbers("feature_covariance", {-1e18, 1e18, ""}, k * k, k * k,
                   "Covariance of the features' errors, row by row.");
  const Eigen::MatrixXd C = Eigen::Map<const Eigen::MatrixXd>(entries.data(), k, k);
  TaskJacobian unused = TaskJacobian::Zero(k, 1);
  if (!C.isApprox(C.transpose(), 1e-12) || !Whiten(C, &unused)) {
    root.Fail("feature_covariance", "must be symmetric and positive definite");
  }
  return C;
}

}  // namespace

MeasureSetup LoadMeasureSetup(const Section& root) {
  const std::string description = root.Text("description", "", "One line.");
  ArmModel arm = LoadRobotUnder(root, "robot");
  const JointVector q = LoadJoints(root, "joints", arm, "Joint values.");
  const std::vector<MeasuredPoint> points = LoadPoints(root);
  const int count = static_cast<int>(points.size());
  FeatureSet features(LoadFeatures(root, "features", count), count);
  const auto [camera, pixels] = LoadLens(root);
  MeasureSetup setup{
      "", description, std::move(arm), q, camera, pixels, false, Eigen::Isometry3d::Identity(), {},
      {}, points,      features,       0, 0.0,    {},     {}};
  setup.waypoints = LoadWaypoints(root, setup.arm);
  setup.covariance = LoadCovariance(root, static_cast<int>(setup.features.features().size()));
  LoadMount(root, &setup);
  setup.translation_task =
      root.Choice<int>("translation_task", {{"none", 0}, {"plane", 2}, {"space", 3}}, 0,
                       "Also measure J_v and J_r of E's translation alone, as the paper's examples "
                       "do: in W's x and y, "
                       "or in space.");
  setup.threshold =
      root.Number("threshold", {0.0, 1e12, "px/rad"}, pixels ? TriggerOptions{}.threshold : 0.0,
                  "w_c^(1/s) below which w_c counts as low.");
  return setup;
}

MeasureSetup FindMeasureSetup(const std::string& name_or_path, SchemaRecorder* recorder) {
  const Section root = ParseConfig(FindConfigText(ConfigKind::kMeasure, name_or_path), recorder);
  MeasureSetup setup = LoadMeasureSetup(root);
  root.RejectUnknownKeys();
  setup.name = std::filesystem::path(name_or_path).stem().string();
  return setup;
}

MeasureSetup LoadOracleSetup(const std::string& path, const std::string& id) {
  const OracleCase oracle = LoadOracleCase(path, id);
  MeasureSetup setup{oracle.id,
                     oracle.description,
                     oracle.arm,
                     oracle.q,
                     oracle.camera.model,
                     false,
                     oracle.camera.eye_in_hand,
                     oracle.camera.X,
                     {},
                     {},
                     {},
                     oracle.features,
                     0,
                     0.0,
                     {},
                     {}};
  setup.rig.X_WC_fixed = oracle.camera.X;
  if (oracle.camera.sphere) {
    setup.rig = oracle.camera.sphere->rig;
    setup.q_c = oracle.camera.sphere->q_c;
  }
  for (const OraclePoint& point : oracle.points) {
    MeasuredPoint measured;
    measured.marker.id = static_cast<int>(setup.points.size());
    measured.marker.p = point.p;
    measured.on_body = point.on_body;
    setup.points.push_back(measured);
  }
  return setup;
}

std::string NameOf(const Feature& feature) {
  std::string name = NameOf(feature.kind);
  if (feature.kind == FeatureKind::kPointX) name = "x";
  if (feature.kind == FeatureKind::kPointY) name = "y";
  if (feature.order_x + feature.order_y > 0) {
    name += std::to_string(feature.order_x) + std::to_string(feature.order_y);
  }
  for (const int point : feature.points) name += "_" + std::to_string(point);
  return name;
}

JointVector JointsAlong(const std::vector<JointVector>& waypoints, double t) noexcept {
  const auto lines = static_cast<double>(waypoints.size() - 1);
  const double place = std::min(std::max(t, 0.0), 1.0) * lines;
  const auto line = static_cast<std::size_t>(std::min(std::floor(place), lines - 1.0));
  const double share = place - static_cast<double>(line);
  return (1.0 - share) * waypoints[line] + share * waypoints[line + 1];
}

std::string UnitOf(const Feature& feature, bool pixels) {
  switch (feature.kind) {
    case FeatureKind::kAngle:
    case FeatureKind::kEdgeAngle:
    case FeatureKind::kSegmentAngle:
    case FeatureKind::kMomentAlpha:
      return "rad";
    case FeatureKind::kArea:
    case FeatureKind::kMomentArea:
      return pixels ? "px^2" : "-";
    case FeatureKind::kMomentBasic:
    case FeatureKind::kMomentCentred: {
      const int order = feature.order_x + feature.order_y;
      return !pixels ? "-" : order == 1 ? "px" : "px^" + std::to_string(order);
    }
    case FeatureKind::kSegmentXNormalised:
    case FeatureKind::kSegmentYNormalised:
      return "-";
    case FeatureKind::kSegmentInverseLength:
      return pixels ? "1/px" : "-";
    case FeatureKind::kMomentAreaNormalised:
      return "m";
    case FeatureKind::kMomentXNormalised:
    case FeatureKind::kMomentYNormalised:
      return pixels ? "px m" : "m";
    case FeatureKind::kPointX:
    case FeatureKind::kPointY:
    case FeatureKind::kDistance:
    case FeatureKind::kCentroidX:
    case FeatureKind::kCentroidY:
    case FeatureKind::kSegmentX:
    case FeatureKind::kSegmentY:
    case FeatureKind::kSegmentLength:
    case FeatureKind::kMomentX:
    case FeatureKind::kMomentY:
      return pixels ? "px" : "-";
  }
  return "";
}

}  // namespace vantage
