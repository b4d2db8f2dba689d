#include <cmath>

#include "vantage/config/loaders.h"

namespace vantage {
namespace {

// What the file has to say of one axis. Its checks cover those of Validate(), with lines.
struct AxisForm {
  const char* name;
  bool turns;    // In degrees; else metres.
  double lower;  // Bounds that the axis' limits must keep, in the file's unit.
  double upper;
  const char* help;
};

struct Axis {
  RigAxis limits;
  double start;
};

Axis LoadAxis(const Section& axes, const AxisForm& form) {
  const Section section = axes.Child(form.name, form.help);
  const std::string suffix = form.turns ? "_deg" : "";
  const std::string unit = form.turns ? "deg" : "m";
  const Range range{form.lower, form.upper, unit};
  const auto read = [&](const std::string& key, const Range& bounds, std::optional<double> fallback,
                        const std::string& help) {
    return form.turns ? section.Degrees(key, bounds, fallback, help)
                      : section.Number(key, bounds, fallback, help);
  };
  Axis axis;
  axis.limits.name = form.name;
  axis.limits.lower = read("lower" + suffix, range, kRequired, "Least coordinate.");
  axis.limits.upper = read("upper" + suffix, range, kRequired, "Greatest coordinate.");
  if (axis.limits.upper < axis.limits.lower) {
    section.Fail("upper" + suffix, "must not be below lower" + suffix);
  }
  axis.start = read("start" + suffix, range, kRequired, "Coordinate at the start.");
  if (!(axis.start >= axis.limits.lower && axis.start <= axis.limits.upper)) {
    section.Fail("start" + suffix, "must be between the axis' limits");
  }
  axis.limits.max_speed = read(form.turns ? "max_speed_deg_s" : "max_speed",
                               {0.0, form.turns ? 3600.0 : 100.0, unit + "/s"}, kRequired,
                               "Greatest speed; 0 locks the axis where it starts.");
  const std::string acceleration = form.turns ? "max_acceleration_deg_s2" : "max_acceleration";
  axis.limits.max_acceleration =
      read(acceleration, {0.0, form.turns ? 36000.0 : 1000.0, unit + "/s^2"},
           axis.limits.max_speed > 0.0 ? std::optional<double>() : 0.0,
           "Greatest acceleration; needed where the axis moves.");
  if (axis.limits.max_speed > 0.0 && !(axis.limits.max_acceleration > 0.0)) {
    section.Fail(acceleration, "must be > 0 on an axis that moves");
  }
  return axis;
}

void LoadAxes(const Section& section, const std::vector<AxisForm>& forms, RigSetup* setup) {
  const Section axes = section.Child("axes", "The rig's axes, by name.");
  setup->q_c_start.resize(static_cast<Eigen::Index>(forms.size()));
  for (std::size_t i = 0; i < forms.size(); ++i) {
    const Axis axis = LoadAxis(axes, forms[i]);
    setup->rig.axes.push_back(axis.limits);
    setup->q_c_start(static_cast<Eigen::Index>(i)) = axis.start;
  }
}

const AxisForm kPan{"pan", true, -360.0, 360.0, "Turn of the camera to the right."};
const AxisForm kTilt{"tilt", true, -360.0, 360.0, "Turn of the camera upwards."};
const AxisForm kRoll{"roll", true, -3600.0, 3600.0, "Turn about the optical axis."};

// A pan-tilt head is there when the file has either of its axes; LoadAxis() then asks for both.
bool HasHead(const Section& section) {
  const Section axes = section.Child("axes", "The rig's axes, by name.");
  return axes.FormOf("pan") != Section::Form::kAbsent ||
         axes.FormOf("tilt") != Section::Form::kAbsent;
}

void LoadSpherical(const Section& section, RigSetup* setup) {
  setup->rig.orientation = section.Choice<RigOrientation>(
      "orientation",
      {{"look_at", RigOrientation::kLookAt}, {"fixed_down", RigOrientation::kFixedDown}},
      RigOrientation::kLookAt,
      "Spherical rig: the camera looks at the target, or always straight down.");
  setup->rig.target_W = section.Vector3("target", {-1000.0, 1000.0, "m"}, kRequired,
                                        "Spherical rig: centre of the sphere, in the world.");
  std::vector<AxisForm> forms{
      {"R", false, 1e-3, 1000.0, "Distance from the target."},
      {"theta", true, 0.0, 180.0, "Angle from the world's z axis."},
      {"phi", true, -3600.0, 3600.0, "Angle about the world's z axis, from x."},
      kRoll};
  if (HasHead(section)) forms.insert(forms.end(), {kPan, kTilt});
  LoadAxes(section, forms, setup);
}

void LoadRail(const Section& section, RigSetup* setup) {
  const Eigen::Vector3d rail =
      section.Vector3("rail", {-1000.0, 1000.0, ""}, kRequired,
                      "Rail: its direction in the world; need not have length 1.");
  if (!(rail.norm() > 1e-3)) section.Fail("rail", "must not be zero");
  setup->rig.rail_W = rail.normalized();
  std::vector<AxisForm> forms{{"s", false, -1000.0, 1000.0, "Shift along the rail."}};
  if (HasHead(section)) forms.insert(forms.end(), {kPan, kTilt});
  LoadAxes(section, forms, setup);
}

void LoadFree(const Section& section, RigSetup* setup) {
  LoadAxes(section,
           {{"x", false, -1000.0, 1000.0, "Shift along the world's x axis."},
            {"y", false, -1000.0, 1000.0, "Shift along the world's y axis."},
            {"z", false, -1000.0, 1000.0, "Shift along the world's z axis."},
            kPan,
            kTilt,
            kRoll},
           setup);
}

// An arm that carries the camera: joint 0 is nearest to its base.
void LoadCarrier(const Section& section, RigSetup* setup) {
  std::vector<std::string> names;
  for (const Section& joint :
       section.Children("joints", 1, kMaxRigAxes,
                        "The carrying arm's joints, base first, where all stand at 0.")) {
    names.push_back(joint.Text("name", kRequired, "Of the joint, and of its entry in axes."));
    RigJoint form;
    form.prismatic = joint.Flag("prismatic", false, "Whether it slides along its axis.");
    const Eigen::Vector3d axis = joint.Vector3("axis", {-1000.0, 1000.0, ""}, kRequired,
                                               "Direction in the world; need not have length 1.");
    if (!(axis.norm() > 1e-3)) joint.Fail("axis", "must not be zero");
    form.axis_W = axis.normalized();
    form.point_W = joint.Vector3(
        "point", {-1000.0, 1000.0, "m"},
        form.prismatic ? std::optional<Eigen::Vector3d>(Eigen::Vector3d::Zero()) : std::nullopt,
        "A point on the axis, in the world; needed where it turns.");
    setup->rig.joints.push_back(form);
  }
  std::vector<AxisForm> forms;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const bool turns = !setup->rig.joints[i].prismatic;
    const double reach = turns ? 3600.0 : 1000.0;
    forms.push_back({names[i].c_str(), turns, -reach, reach, "Joint of the carrying arm."});
  }
  LoadAxes(section, forms, setup);
}

}  // namespace

RigSetup LoadRig(const Section& section) {
  RigSetup setup;
  setup.rig.kind = section.Choice<RigKind>(
      "kind",
      {{"fixed", RigKind::kFixed},
       {"spherical", RigKind::kSpherical},
       {"pan_tilt", RigKind::kPanTilt},
       {"rail", RigKind::kRail},
       {"free", RigKind::kFree},
       {"arm", RigKind::kArm}},
      kRequired,
      "fixed: the camera stands still; spherical (axes R, theta, phi, roll, or these with pan and "
      "tilt): it moves on a sphere about a target; pan_tilt (pan, tilt): it turns in place; rail "
      "(s, "
      "or these with pan and tilt): it moves along a line; free (x, y, z, pan, tilt, roll); arm "
      "(its joints): "
      "carried by an arm of its own.");
  if (setup.rig.kind != RigKind::kSpherical) {
    setup.rig.X_WC_fixed = LoadCameraPose(
        section, "pose", "The camera's optical frame in the world, with all axes at zero.");
  }
  switch (setup.rig.kind) {
    case RigKind::kFixed:
      return setup;
    case RigKind::kSpherical:
      LoadSpherical(section, &setup);
      break;
    case RigKind::kPanTilt:
      LoadAxes(section, {kPan, kTilt}, &setup);
      break;
    case RigKind::kRail:
      LoadRail(section, &setup);
      break;
    case RigKind::kFree:
      LoadFree(section, &setup);
      break;
    case RigKind::kArm:
      LoadCarrier(section, &setup);
      break;
  }
  setup.rig.max_linear_speed =
      section.Number("max_linear_speed", {1e-3, 100.0, "m/s"}, setup.rig.max_linear_speed,
                     "Greatest speed of the camera's centre, all axes together.");
  return setup;
}

}  // namespace vantage
