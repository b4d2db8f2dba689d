#include <algorithm>
#include <filesystem>
#include <sstream>

#include "vantage/config/loaders.h"
#include "vantage/math/angles.h"
#include "vantage/math/error.h"
#include "vantage/robot/urdf.h"

namespace vantage {
namespace {

constexpr double kLongest = 100.0;  // Of any length of an arm [m].
constexpr double kSlowest = 1e-4;   // Least speed and acceleration limits, in the file's unit.

const Range kLength{-kLongest, kLongest, "m"};
const Range kTurns{-3600.0, 3600.0, "deg"};

struct Joints {
  std::vector<DhRow> rows;
  std::vector<JointLimits> limits;
  std::vector<std::string> names;
};

DhRow LoadRow(const Section& joint, JointKind kind) {
  DhRow row;
  row.kind = kind;
  row.a = joint.Number("a", kLength, 0.0, "DH length a.");
  row.alpha = joint.Degrees("alpha_deg", {-360.0, 360.0, "deg"}, 0.0, "DH twist alpha.");
  if (kind == JointKind::kRevolute) {
    row.d = joint.Number("d", kLength, 0.0, "DH offset d of a revolute joint.");
    row.offset = joint.Degrees("offset_deg", {-360.0, 360.0, "deg"}, 0.0,
                               "Revolute joint: theta = q + offset.");
  } else {
    row.theta = joint.Degrees("theta_deg", {-360.0, 360.0, "deg"}, 0.0,
                              "DH angle theta of a prismatic joint.");
    row.offset = joint.Number("offset", kLength, 0.0, "Prismatic joint: d = q + offset.");
  }
  return row;
}

JointLimits LoadLimits(const Section& joint, JointKind kind) {
  JointLimits limits;
  const bool revolute = kind == JointKind::kRevolute;
  const std::string lower_key = revolute ? "lower_deg" : "lower";
  if (revolute) {
    limits.lower = joint.Degrees("lower_deg", kTurns, kRequired, "Least joint angle.");
    limits.upper = joint.Degrees("upper_deg", kTurns, kRequired, "Greatest joint angle.");
    limits.velocity = joint.Degrees("max_speed_deg_s", {kSlowest, 1e5, "deg/s"}, kRequired,
                                    "Greatest speed of a revolute joint.");
    limits.acceleration = joint.Degrees("max_acceleration_deg_s2", {kSlowest, 1e6, "deg/s^2"},
                                        kRequired, "Greatest acceleration of a revolute joint.");
  } else {
    limits.lower = joint.Number("lower", kLength, kRequired, "Least shift of a prismatic joint.");
    limits.upper = joint.Number("upper", kLength, kRequired, "Greatest shift.");
    limits.velocity = joint.Number("max_speed", {kSlowest, 1e3, "m/s"}, kRequired,
                                   "Greatest speed of a prismatic joint.");
    limits.acceleration = joint.Number("max_acceleration", {kSlowest, 1e4, "m/s^2"}, kRequired,
                                       "Greatest acceleration of a prismatic joint.");
  }
  if (!(limits.upper > limits.lower)) joint.Fail(lower_key, "must be below the upper limit");
  return limits;
}

Joints LoadJointList(const Section& section) {
  const Section::Names<JointKind> kinds{{"revolute", JointKind::kRevolute},
                                        {"prismatic", JointKind::kPrismatic}};
  Joints joints;
  for (const Section& joint :
       section.Children("joints", 1, kMaxJoints, "Rows of the DH table, from the base on.")) {
    const std::string name =
        joint.Text("name", "joint" + std::to_string(joints.rows.size() + 1), "Unique name.");
    if (name == "base") joint.Fail("name", "'base' is the name of the base");
    if (std::count(joints.names.begin(), joints.names.end(), name) != 0) {
      joint.Fail("name", "'" + name + "' names two joints");
    }
    const auto kind = joint.Choice<JointKind>("kind", kinds, JointKind::kRevolute, "Joint kind.");
    joints.names.push_back(name);
    joints.rows.push_back(LoadRow(joint, kind));
    joints.limits.push_back(LoadLimits(joint, kind));
  }
  return joints;
}

ArmModel Remarked(const UrdfArm& urdf, RobotRemarks* remarks) {
  if (remarks != nullptr) {
    remarks->warnings.insert(remarks->warnings.end(), urdf.warnings.begin(), urdf.warnings.end());
    remarks->notes.insert(remarks->notes.end(), urdf.notes.begin(), urdf.notes.end());
  }
  return urdf.arm;
}

ArmModel LoadUrdfSection(const Section& section, RobotRemarks* remarks) {
  const std::string none;  // Section::Text() takes no empty text, but an empty default.
  const std::string path = section.Text("urdf", kRequired, "URDF file, relative to this one.");
  const std::string base_link = section.Text(
      "base_link", none, "Link whose frame is the arm's base; the root link if absent.");
  const std::string tip_link = section.Text(
      "tip_link", none, "Link that ends the arm; the end of the longest chain if absent.");
  UrdfOptions options;
  options.package_folders = RosPackageFolders();
  const std::string packages =
      section.Text("package_folder", none, "Where package:// meshes are looked up first.");
  if (!packages.empty()) {
    options.package_folders.insert(options.package_folders.begin(),
                                   PathBeside(section.folder(), packages));
  }
  options.acceleration_time =
      section.Number("acceleration_time", {0.001, 100.0, "s"}, options.acceleration_time,
                     "Each joint reaches its greatest speed in this time: URDF files do not say.");
  const Eigen::Isometry3d X_WBase =
      LoadPose(section, "base", false, "Pose of the base link in the world.");
  const Eigen::Isometry3d X_TE =
      LoadPose(section, "tool", false, "Pose of the end effector E in the tip link's frame.");
  const ArmModel arm = Remarked(
      LoadUrdfArm(PathBeside(section.folder(), path), base_link, tip_link, options), remarks);
  return arm.WithBase(X_WBase).WithTool(arm.X_LastE() * X_TE);
}

std::vector<Capsule> LoadCapsules(const Section& section, const std::vector<std::string>& names) {
  Section::Names<int> links{{"base", -1}};
  for (std::size_t i = 0; i < names.size(); ++i) links.emplace_back(names[i], static_cast<int>(i));
  std::vector<Capsule> capsules;
  for (const Section& body : section.Children(
           "capsules", 0, 64, "The arm's body: cylinders with round ends, fixed to its links.")) {
    Capsule capsule;
    capsule.link =
        body.Choice<int>("link", links, kRequired, "base, or the joint that moves the link.");
    capsule.p_LA = body.Vector3("from", kLength, kRequired,
                                "One end of the axis, in the link's DH frame (base: the base).");
    capsule.p_LB = body.Vector3("to", kLength, kRequired, "The other end.");
    capsule.radius = body.Number("radius", {1e-4, kLongest, "m"}, kRequired, "Radius.");
    capsules.push_back(capsule);
  }
  return capsules;
}

}  // namespace

ArmModel LoadRobot(const Section& section, RobotRemarks* remarks) {
  if (section.FormOf("urdf") != Section::Form::kAbsent) return LoadUrdfSection(section, remarks);
  const std::string name = section.Text("name", kRequired, "Name of the arm.");
  const auto convention = section.Choice<DhConvention>(
      "convention", {{"standard", DhConvention::kStandard}, {"modified", DhConvention::kModified}},
      kRequired,
      "DH convention: standard A = Rz(theta) Tz(d) Tx(a) Rx(alpha), or modified (Craig's) "
      "A = Rx(alpha) Tx(a) Rz(theta) Tz(d).");
  const Joints joints = LoadJointList(section);
  const Eigen::Isometry3d X_WBase =
      LoadPose(section, "base", false, "Pose of the first DH frame in the world.");
  const Eigen::Isometry3d X_LastE =
      LoadPose(section, "tool", false, "Pose of the end effector E in the last DH frame.");
  const std::vector<Capsule> capsules = LoadCapsules(section, joints.names);
  return ArmModel(name, convention, joints.rows, joints.limits, X_WBase, X_LastE, capsules,
                  joints.names);
}

ArmModel FindRobot(const std::string& name_or_path, const std::string& folder,
                   SchemaRecorder* recorder, RobotRemarks* remarks) {
  if (IsUrdfPath(name_or_path)) {
    UrdfOptions options;
    options.package_folders = RosPackageFolders();
    return Remarked(LoadUrdfArm(PathBeside(folder, name_or_path), "", "", options), remarks);
  }
  const Section root =
      ParseConfig(FindConfigText(ConfigKind::kRobot, name_or_path, folder), recorder);
  ArmModel arm = LoadRobot(root, remarks);
  root.RejectUnknownKeys();
  return arm;
}

ArmModel LoadRobotUnder(const Section& parent, const std::string& key, RobotRemarks* remarks) {
  const std::string help =
      "The arm: a built-in one, a robot file (YAML or URDF), or its description.";
  if (parent.FormOf(key) == Section::Form::kMapping) {
    return LoadRobot(parent.Child(key, help), remarks);
  }
  return FindRobot(parent.Text(key, kRequired, help), parent.folder(), nullptr, remarks);
}

JointVector LoadJoints(const Section& parent, const std::string& key, const ArmModel& arm,
                       const std::string& help) {
  const int n = arm.size();
  const std::string key_deg = key + "_deg";
  const bool in_degrees = parent.FormOf(key_deg) != Section::Form::kAbsent;
  if (in_degrees && parent.FormOf(key) != Section::Form::kAbsent) {
    parent.Fail(key, "must not be given beside " + key_deg);
  }
  const auto& kinds = arm.joint_kinds();
  const auto prismatic = std::find(kinds.begin(), kinds.end(), JointKind::kPrismatic);
  if (in_degrees && prismatic != kinds.end()) {
    parent.Fail(key_deg, "must be given as " + key + " (rad and m): joint " +
                             arm.joint_names()[prismatic - kinds.begin()] + " of " + arm.name() +
                             " is prismatic");
  }
  JointVector q(n);
  if (in_degrees) {
    q = parent.Numbers(key_deg, {-3600.0, 3600.0, "deg"}, n, n, help + " In degrees.") * kDegree;
  } else {
    q = parent.Numbers(key, {-100.0, 100.0, "rad or m"}, n, n, help + " In rad and m.");
  }
  for (int i = 0; i < n; ++i) {
    // The limits may come from degrees, and so be off by a rounding.
    const JointLimits& limit = arm.limits()[i];
    if (q(i) >= limit.lower - 1e-9 && q(i) <= limit.upper + 1e-9) continue;
    const double unit = in_degrees ? kDegreesPerRadian : 1.0;
    const std::string unit_name =
        in_degrees ? "deg" : (kinds[i] == JointKind::kRevolute ? "rad" : "m");
    std::ostringstream reason;
    reason << "joint " << arm.joint_names()[i] << " of " << arm.name() << " must be in ["
           << limit.lower * unit << ", " << limit.upper * unit << "] " << unit_name << ", is "
           << q(i) * unit;
    parent.Fail(in_degrees ? key_deg : key, reason.str());
  }
  return ClampToLimits(arm, q);
}

}  // namespace vantage
