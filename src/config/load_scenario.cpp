#include <filesystem>

#include "vantage/config/camera_plan_file.h"
#include "vantage/config/loaders.h"
#include "vantage/config/scenario.h"
#include "vantage/math/angles.h"
#include "vantage/robot/kinematics.h"

namespace vantage {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

ServoLawOptions LoadLaw(const Section& section) {
  const ServoLawOptions defaults;
  ServoLawOptions law;
  law.gain_at_zero = section.Number("gain_at_zero", {0.01, 50.0, "1/s"}, defaults.gain_at_zero,
                                    "Gain near the goal.");
  law.gain_at_infinity = section.Number("gain_at_infinity", {0.01, 50.0, "1/s"},
                                        std::min(defaults.gain_at_infinity, law.gain_at_zero),
                                        "Gain far from the goal.");
  if (law.gain_at_infinity > law.gain_at_zero) {
    section.Fail("gain_at_infinity", "must not be above gain_at_zero");
  }
  law.gain_slope = section.Number("gain_slope", {0.0, 10.0, "1/(s px)"}, defaults.gain_slope,
                                  "How fast the gain falls as the error grows.");
  law.damping = section.Number("damping", {0.0, 1e4, "px/rad"}, defaults.damping,
                               "Largest damping of the inverse near a singularity.");
  law.damping_onset = section.Number("damping_onset", {0.0, 1e5, "px/rad"}, defaults.damping_onset,
                                     "Least singular value without damping.");
  law.max_error_rate = section.Number("max_error_rate", {1.0, 1e5, "px/s"}, defaults.max_error_rate,
                                      "Greatest image speed that is asked for.");
  law.start_time = section.Number("start_time", {0.0, 10.0, "s"}, defaults.start_time,
                                  "Time constant of the gain's rise after a rest.");
  law.ascent_gain =
      section.Number("ascent_gain", {0.0, 100.0, "rad2/s"}, defaults.ascent_gain,
                     "Ascent of log w_c by joint motions that the features do not see.");
  law.self_motion = section.Number("self_motion", {0.0, 1.0, ""}, defaults.self_motion,
                                   "Share of the velocity limits that such motions may use.");
  return law;
}

ServoOptions LoadServo(const Section& section) {
  const ServoOptions defaults;
  ServoOptions servo;
  servo.period = section.Number("period", {0.0005, 0.1, "s"}, defaults.period, "Control period.");
  servo.interaction = section.Choice<InteractionSource>(
      "interaction",
      {{"visp", InteractionSource::kVisp}, {"closed_form", InteractionSource::kClosedForm}},
      defaults.interaction,
      "Interaction matrices from ViSP's feature classes, or the same in closed form: nothing is "
      "allocated in the control period then.");
  servo.law = LoadLaw(section);
  servo.latency_compensation =
      section.Flag("latency_compensation", defaults.latency_compensation,
                   "The model carries each image from its exposure to now; false for comparison.");
  const Section staleness = section.OptionalChild(
      "staleness", "Greatest ages of inputs; older ones make the servo hold.");
  const Range age{0.001, 10.0, "s"};
  servo.staleness.joint_state =
      staleness.Number("joint_state", age, defaults.staleness.joint_state, "Joint state.");
  servo.staleness.camera_pose =
      staleness.Number("camera_pose", age, defaults.staleness.camera_pose, "Camera pose.");
  servo.staleness.features = staleness.Number("features", age, defaults.staleness.features,
                                              "Exposure of the newest image.");
  servo.staleness.marker =
      staleness.Number("marker", {0.0, 10.0, "s"}, defaults.staleness.marker,
                       "A marker not seen is carried on by the model this long.");
  servo.staleness.hidden_marker = staleness.Number(
      "hidden_marker", {0.0, 60.0, "s"}, defaults.staleness.hidden_marker,
      "The same while two other markers of the arm are seen, which confirm the model.");
  const Section convergence = section.OptionalChild("convergence", "When the task counts as done.");
  servo.convergence.tolerance_px =
      convergence.Number("tolerance_px", {0.001, 1000.0, "px"}, defaults.convergence.tolerance_px,
                         "Root mean square error of the feature rows.");
  servo.convergence.settle_time =
      convergence.Number("settle_time", {0.0, 60.0, "s"}, defaults.convergence.settle_time,
                         "The error must stay below the tolerance this long.");
  servo.convergence.max_mm_per_px = convergence.Number(
      "max_mm_per_px", {0.001, 1e6, "mm/px"}, defaults.convergence.max_mm_per_px,
      "Worst motion of a marker that one pixel may hide: the view's certificate.");
  servo.convergence.tolerance_mm =
      convergence.Number("tolerance_mm", {0.001, 1e6, "mm"}, defaults.convergence.tolerance_mm,
                         "By the image every marker must be nearer to its goal point.");
  const Section path = section.OptionalChild(
      "path", "The reference's way in the image: that of a straight way in joint space.");
  servo.path.enabled =
      path.Flag("enabled", defaults.path.enabled, "Whether far goals are approached along it.");
  servo.path.reach = path.Number("reach", {1e-3, 10.0, "rad"}, defaults.path.reach,
                                 "Largest joint step that the reference is ahead.");
  servo.path.trust =
      path.Number("trust", {0.0, 1e5, "px/rad"}, defaults.path.trust,
                  "What the image shows by less than this follows the model on the way.");
  servo.offset_time = section.Number("offset_time", {0.0, 10.0, "s"}, defaults.offset_time,
                                     "Time over which image and model are compared.");
  servo.limit_margin = section.Number("limit_margin", {0.0, 1.0, "rad"}, defaults.limit_margin,
                                      "Joints are kept this far inside their limits.");
  servo.wait_mm_per_px =
      section.Number("wait_mm_per_px", {0.001, 1e6, "mm/px"}, defaults.wait_mm_per_px,
                     "In a view where one pixel hides more, the arm rests while the camera moves.");
  servo.stall_time = section.Number("stall_time", {0.1, 60.0, "s"}, defaults.stall_time,
                                    "An error that does not fall for this long is a stall.");
  servo.feature_noise_px =
      section.Number("feature_noise_px", {0.001, 100.0, "px"}, defaults.feature_noise_px,
                     "Standard deviation of a measured pixel coordinate.");
  servo.calibration_px =
      section.Number("calibration_px", {0.0, 100.0, "px"}, defaults.calibration_px,
                     "By how much errors of calibration shift a whole image.");
  const Section calibration =
      section.OptionalChild("calibration",
                            "What may be wrong with the calibration; found from the arm's own "
                            "markers. Standard deviations.");
  servo.calibration.estimate = calibration.Flag("estimate", defaults.calibration.estimate,
                                                "Whether it is found, and minded.");
  servo.calibration.position =
      calibration.Number("position", {0.0, 1.0, "m"}, defaults.calibration.position,
                         "Of the camera's pose on its rig, each axis.");
  servo.calibration.rotation = calibration.Number(
      "rotation", {0.0, 1.0, "rad"}, defaults.calibration.rotation, "The same, about each axis.");
  servo.calibration.focal = calibration.Number("focal", {0.0, 0.5, ""}, defaults.calibration.focal,
                                               "Of the focal length, as a share of it.");
  servo.calibration.joint =
      calibration.Number("joint", {0.0, 1.0, "rad"}, defaults.calibration.joint,
                         "Of each encoder's zero (m for a prismatic joint).");
  return servo;
}

ActiveOptions LoadActive(const Section& section) {
  const ActiveOptions defaults;
  ActiveOptions active;
  active.enabled = section.Flag("enabled", defaults.enabled, "Whether the camera may move.");
  active.replan_interval =
      section.Number("replan_interval", {0.01, 60.0, "s"}, defaults.replan_interval,
                     "Least time between two plans.");
  active.look_ahead = section.Number("look_ahead", {0.0, 10.0, "s"}, defaults.look_ahead,
                                     "A marker predicted to be lost within this time fires too.");
  const Section trigger = section.OptionalChild("trigger", "When the camera is asked to move.");
  active.trigger.measure = trigger.Choice<TriggerMeasure>(
      "measure", TriggerMeasureKeys(), defaults.trigger.measure,
      "geometric_mean is w_c^(1/s) in px/rad, composite_w is w_c itself.");
  active.trigger.threshold =
      trigger.Number("threshold", {1e-12, 1e24, ""}, defaults.trigger.threshold,
                     "The camera moves below it; in the measure's unit.");
  active.trigger.hysteresis =
      trigger.Number("hysteresis", {1.0, 100.0, ""}, defaults.trigger.hysteresis,
                     "Armed again above hysteresis times the threshold.");
  active.trigger.debounce = static_cast<int>(trigger.Integer(
      "debounce", 1, 1000, defaults.trigger.debounce, "Evaluations in a row that fire."));
  const Section planner = section.OptionalChild("planner", "How a better view is sought.");
  PlannerOptions& plan = active.planner;
  plan.candidates = static_cast<int>(planner.Integer("candidates", 8, 100000, plan.candidates,
                                                     "Camera positions tried per plan."));
  plan.path_samples = static_cast<int>(planner.Integer("path_samples", 1, 100, plan.path_samples,
                                                       "Configurations each one is scored at."));
  plan.travel_cost = planner.Number("travel_cost", {0.0, 100.0, "1/m"}, plan.travel_cost,
                                    "Cost of camera travel, in units of log w / s.");
  plan.cap = planner.Number("cap", {1.0, 1e6, ""}, plan.cap,
                            "Above cap times the threshold a view is good enough.");
  plan.min_gain = planner.Number("min_gain", {0.0, 100.0, ""}, plan.min_gain,
                                 "Relative gain of w_c^(1/s) that a move must promise.");
  const Section limits = section.OptionalChild("view_limits", "What every view must keep.");
  ViewLimits& view = plan.limits;
  view.margin = limits.Number("margin", {0.0, 10000.0, "px"}, view.margin,
                              "Distance of markers to the image's border.");
  view.min_depth =
      limits.Number("min_depth", {0.001, 1e4, "m"}, view.min_depth, "Least depth of a marker.");
  view.max_depth =
      limits.Number("max_depth", {0.001, 1e4, "m"}, view.max_depth, "Greatest depth of a marker.");
  if (view.max_depth <= view.min_depth) limits.Fail("max_depth", "must be above min_depth");
  view.min_semi_axis = limits.Number("min_semi_axis", {0.0, 1000.0, "px"}, view.min_semi_axis,
                                     "Short semi-axis of a disc's image.");
  view.max_incidence =
      limits.Degrees("max_incidence_deg", {1.0, 90.0, "deg"}, view.max_incidence * 180.0 / kPi,
                     "Greatest angle between a marker's normal and the ray to it.");
  return active;
}

SimOptions LoadSim(const Section& section, const ArmModel& arm) {
  SimOptions sim;
  sim.q_start = LoadJoints(section, "start_joints", arm, "True joints at the start.");
  sim.step = section.Number("step", {1e-4, 0.01, "s"}, sim.step, "Step of the plants.");
  sim.seed = static_cast<std::uint64_t>(
      section.Integer("seed", 0, 1000000000, 1, "Of every random number."));
  sim.renderer = section.Choice<RendererBackend>(
      "renderer",
      {{"auto", RendererBackend::kAuto},
       {"osmesa", RendererBackend::kOsmesa},
       {"egl", RendererBackend::kEgl}},
      sim.renderer, "osmesa: software; egl: a GPU where there is one; auto: osmesa if installed.");
  const Section motion = section.OptionalChild(
      "goal_motion", "Motion of the goal's markers: a (1 - cos ωt) / 2 + b (1 - cos 2ωt) / 2.");
  GoalMotion& m = sim.goal_motion;
  m.a = motion.Vector3("a", {-10.0, 10.0, "m"}, m.a, "In world axes.");
  m.b = motion.Vector3("b", {-10.0, 10.0, "m"}, m.b, "In world axes.");
  m.period = motion.Number("period", {0.1, 3600.0, "s"}, m.period, "2π / ω.");
  const Section effects = section.OptionalChild("arm", "Effects of a real arm.");
  ArmEffects& a = sim.arm;
  a.lag = effects.Number("lag", {0.0, 1.0, "s"}, a.lag, "Time constant of the velocity loop.");
  a.encoder_noise = effects.Degrees("encoder_noise_deg", {0.0, 10.0, "deg"}, 0.0,
                                    "Standard deviation of a joint reading.");
  a.encoder_bias = effects.Degrees("encoder_bias_deg", {0.0, 10.0, "deg"}, 0.0,
                                   "Standard deviation of each joint's constant error.");
  a.watchdog = effects.Number("watchdog", {0.005, 10.0, "s"}, a.watchdog,
                              "The arm brakes when no command came for this long.");
  const Section image = section.OptionalChild("camera", "Effects of a real camera and its rig.");
  CameraEffects& c = sim.camera;
  c.rate = image.Number("rate", {1.0, 1000.0, "1/s"}, c.rate, "Images per second.");
  c.noise_grey = image.Number("noise_grey", {0.0, 50.0, ""}, c.noise_grey,
                              "Standard deviation of a pixel, of 255 grey levels.");
  c.kinematic = image.Flag("kinematic", c.kinematic,
                           "Projects markers instead of drawing and detecting them: fast.");
  c.noise_px = image.Number("noise_px", {0.0, 50.0, "px"}, c.noise_px,
                            "Standard deviation of a marker's coordinate, where kinematic.");
  c.blur = image.Number("blur", {0.0, 10.0, "px"}, c.blur, "Standard deviation of the blur.");
  c.gain_step = image.Number("gain_step", {0.0, 1.0, ""}, c.gain_step,
                             "Exposure jumps: the gain's logarithm is within +- this.");
  c.gain_period =
      image.Number("gain_period", {0.01, 1e4, "s"}, c.gain_period, "Mean time between two jumps.");
  c.latency_frames = static_cast<int>(image.Integer("latency_frames", 0, 60, c.latency_frames,
                                                    "Images between exposure and arrival."));
  c.drop_rate = image.Number("drop_rate", {0.0, 0.99, ""}, c.drop_rate, "Share of images lost.");
  c.position_error = image.Number("position_error", {0.0, 1.0, "m"}, c.position_error,
                                  "Standard deviation of the pose's constant error, each axis.");
  c.rotation_error = image.Degrees("rotation_error_deg", {0.0, 45.0, "deg"}, 0.0,
                                   "The same of its rotation vector.");
  c.focal_error = image.Number("focal_error", {0.0, 0.5, ""}, c.focal_error,
                               "Standard deviation of the true focal length, relative.");
  return sim;
}

TrackerOptions LoadVision(const Section& section) {
  TrackerOptions vision;
  vision.kind =
      section.Choice<DetectorKind>("detector",
                                   {{"disc", DetectorKind::kDisc},
                                    {"vpdot2", DetectorKind::kVispDot},
                                    {"apriltag", DetectorKind::kAprilTag}},
                                   vision.kind,
                                   "disc is Vantage's own, vpdot2 and apriltag are ViSP's; "
                                   "apriltag goes with tags in place of markers.");
  DetectorOptions& detector = vision.detector;
  detector.search_margin =
      section.Number("search_margin", {1.0, 1000.0, "px"}, detector.search_margin,
                     "A marker may be this far from its prediction.");
  vision.followed_margin =
      section.Number("followed_margin", {1.0, 1000.0, "px"}, vision.followed_margin,
                     "The same for one that was seen in the last two images.");
  vision.retry_interval = section.Number("retry_interval", {0.0, 60.0, "s"}, vision.retry_interval,
                                         "Least time between two searches of the whole image.");
  detector.disc.min_contrast =
      section.Number("min_contrast", {5.0, 255.0, ""}, detector.disc.min_contrast,
                     "Least contrast of disc and ring, of 255 grey levels.");
  vision.acquisition.max_shift =
      section.Number("max_shift", {1.0, 10000.0, "px"}, vision.acquisition.max_shift,
                     "Markers are acquired this far from the model.");
  return vision;
}

std::vector<Tag> LoadTags(const Section& root) {
  std::vector<Tag> tags;
  for (const Section& section : root.Children(
           "tags", 1, kMaxPoints / 4, "AprilTags (36h11) on the end effector, in its frame.")) {
    Tag tag;
    tag.id = static_cast<int>(section.Integer("id", 0, kMaxTagId, kRequired, "Of the tag."));
    for (const Tag& other : tags) {
      if (other.id == tag.id) section.Fail("id", std::to_string(tag.id) + " names two tags");
    }
    tag.size = section.Number("size", {1e-3, 10.0, "m"}, kRequired, "Edge of the black square.");
    tag.X_FT =
        LoadPose(section, "pose", true, "Of the tag: x to its right, y up, z out of the paper.");
    tags.push_back(tag);
  }
  return tags;
}

std::vector<Vector3d> Points(const Isometry3d& X_WE, const std::vector<Marker>& markers) {
  std::vector<Vector3d> points;
  for (const Marker& marker : markers) points.push_back(X_WE * marker.p);
  return points;
}

// A goal that markers in the scene show: where they are believed to be goes to the servo, where they
// are to the simulator.
void LoadSeenGoal(const Section& seen, std::size_t count, Scenario* scenario) {
  ServoGoal& goal = scenario->task.goal;
  const std::vector<Marker> truth = LoadMarkers(
      seen, "markers", static_cast<int>(count), static_cast<int>(count),
      "Markers in the scene, one for each of the end effector's; positions in the world, "
      "for the simulator alone.");
  goal.offset_W = seen.Vector3("offset", {-10.0, 10.0, "m"}, Vector3d(0.0, 0.0, 0.0),
                               "From each marker of the goal to its goal point, in world axes.");
  goal.max_speed = seen.Number("max_speed", {0.0, 100.0, "m/s"}, goal.max_speed,
                               "Greatest speed of the goal's markers; 0: they stand.");
  goal.prior_sigma = seen.Number("prior_sigma", {1e-4, 10.0, "m"}, goal.prior_sigma,
                                 "Standard deviation of the prior along each axis.");
  const Vector3d error = seen.Vector3("prior_error", {-10.0, 10.0, "m"}, Vector3d(0.0, 0.0, 0.0),
                                      "How far the servo's prior is off, in world axes.");
  goal.marker_radius = truth.front().radius;
  for (const Marker& marker : truth) {
    for (const Marker& own : scenario->task.view.markers) {
      if (own.id == marker.id) {
        seen.Fail("markers",
                  "id " + std::to_string(marker.id) + " is a marker of the end effector");
      }
    }
    goal.marker_ids.push_back(marker.id);
    goal.p_WG.push_back(marker.p + error);
    goal.normals.push_back(marker.normal);
    scenario->p_WG_true.push_back(marker.p + goal.offset_W);
  }
  scenario->sim.goal_markers = truth;
}

void LoadGoal(const Section& section, Scenario* scenario) {
  const ViewModel& view = scenario->task.view;
  const bool joints = section.FormOf("joints") != Section::Form::kAbsent ||
                      section.FormOf("joints_deg") != Section::Form::kAbsent;
  const bool pose = section.FormOf("end_effector") != Section::Form::kAbsent;
  const bool seen = section.FormOf("seen") != Section::Form::kAbsent;
  if (static_cast<int>(joints) + static_cast<int>(pose) + static_cast<int>(seen) != 1) {
    section.Fail("", "needs one of joints (or joints_deg), end_effector, seen");
  }
  if (seen) {
    if (!scenario->tags.empty())
      section.Fail("seen", "needs dots: no detector finds both them and tags");
    LoadSeenGoal(section.Child("seen", "A goal that markers in the scene show."),
                 view.markers.size(), scenario);
    return;
  }
  const Isometry3d X_WE =
      joints ? EndEffectorPose(view.arm, LoadJoints(section, "joints", view.arm,
                                                    "Joints whose end-effector pose is the goal."))
             : LoadPose(section, "end_effector", true, "Pose of the end effector in the world.");
  scenario->task.goal.p_WG = Points(X_WE, view.markers);
  scenario->p_WG_true = scenario->task.goal.p_WG;
  // A known goal is as good as the model.
  scenario->task.goal.prior_sigma = 1e-6;
}

ViewModel LoadView(const Section& root, const std::vector<Tag>& tags, RobotRemarks* remarks) {
  const ArmModel arm = LoadRobotUnder(root, "robot", remarks);
  const CameraModel camera = LoadCamera(root.OptionalChild("camera", "Intrinsics of the camera."));
  std::vector<Marker> markers;
  for (const Tag& tag : tags) {
    for (const Marker& marker : TagMarkers(tag)) markers.push_back(marker);
  }
  if (tags.empty()) {
    markers =
        LoadMarkers(root, "markers", 1, kMaxPoints, "Dots on the end effector, in its frame.");
  }
  const int count = static_cast<int>(markers.size());
  return {arm, camera, FeatureSet(LoadFeatures(root, "features", count), count), markers};
}

}  // namespace

std::vector<Marker> BelievedGoalMarkers(const Scenario& scenario) {
  std::vector<Marker> markers = scenario.sim.goal_markers;
  for (std::size_t i = 0; i < markers.size(); ++i) markers[i].p = scenario.task.goal.p_WG[i];
  return markers;
}

Scenario LoadScenario(const std::string& name_or_path, SchemaRecorder* recorder) {
  return ReadScenario(FindConfigText(ConfigKind::kScenario, name_or_path),
                      std::filesystem::path(name_or_path).stem().string(), recorder);
}

Scenario ReadScenario(const ConfigText& text, const std::string& name, SchemaRecorder* recorder) {
  const Section root = ParseConfig(text, recorder);
  const std::string description =
      root.Text("description", std::string("-"), "One line about the scenario.");
  RobotRemarks remarks;
  const TrackerOptions vision =
      LoadVision(root.OptionalChild("vision", "How markers are found in images."));
  const std::vector<Tag> tags =
      vision.kind == DetectorKind::kAprilTag ? LoadTags(root) : std::vector<Tag>();
  const ViewModel view = LoadView(root, tags, &remarks);
  RigSetup rig = LoadRig(root.Child("camera_rig", "What carries the camera."));
  if (root.FormOf("camera_start") != Section::Form::kAbsent) {
    rig.q_c_start = ReadCameraStart(root, rig.rig);
  }
  Scenario scenario{name, description, {view, {}}, rig.rig, rig.q_c_start, {},  {},
                    60.0, {},          {},         remarks, vision,        tags};
  scenario.servo = LoadServo(root.OptionalChild("servo", "The control law and its limits."));
  scenario.active = LoadActive(root.OptionalChild("active", "The active camera."));
  scenario.active.planner.max_mm_per_px = scenario.servo.convergence.max_mm_per_px;
  scenario.time_limit = root.Number("time_limit", {0.1, 86400.0, "s"}, scenario.time_limit,
                                    "vantage-run gives up after this long.");
  scenario.sim = LoadSim(root.Child("sim", "For the simulator alone."), view.arm);
  LoadGoal(root.Child("goal", "Where the end effector has to go."), &scenario);
  root.RejectUnknownKeys();
  return scenario;
}

Scenario ReadRecordedScenario(const std::string& name, const std::string& text) {
  return ReadScenario({"log:" + name, "", text}, name);
}

}  // namespace vantage
