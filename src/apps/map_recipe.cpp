#include "map_recipe.h"

#include <algorithm>
#include <filesystem>
#include <sstream>

#include "vantage/config/loaders.h"
#include "vantage/math/angles.h"

namespace vantage {
namespace {

constexpr int kMostSamples = 2001;

std::string Names(const MeasureSetup& setup, bool has_path) {
  std::string names;
  for (const RigAxis& axis : setup.rig.axes) names += axis.name + ", ";
  for (const std::string& joint : setup.arm.joint_names()) names += joint + ", ";
  if (has_path) names += "path, ";
  return names.substr(0, names.size() - 2);
}

int JointIndex(const MeasureSetup& setup, const std::string& name) {
  const auto& names = setup.arm.joint_names();
  const auto found = std::find(names.begin(), names.end(), name);
  return found == names.end() ? -1 : static_cast<int>(found - names.begin());
}

// What `axis` names; several joints are written as "shoulder + elbow".
SweepAxis FindAxis(const Section& section, const MeasureSetup& setup, bool has_path) {
  SweepAxis axis;
  axis.name = section.Text("axis", kRequired,
                           "What is swept: an axis of the camera's rig, a joint, joints that turn "
                           "alike (a + b) or path.");
  axis.symbol = SymbolOf(axis.name);
  if (axis.name == "path" && has_path) {
    axis.kind = SweepAxis::Kind::kPath;
    return axis;
  }
  for (int i = 0; i < setup.rig.size(); ++i) {
    if (setup.rig.axes[i].name != axis.name) continue;
    axis.indices = {i};
    return axis;
  }
  axis.kind = SweepAxis::Kind::kJoint;
  std::istringstream names(axis.name);
  for (std::string name; std::getline(names, name, '+');) {
    name.erase(0, name.find_first_not_of(' '));
    name.erase(name.find_last_not_of(' ') + 1);
    const int joint = JointIndex(setup, name);
    if (joint < 0) {
      section.Fail("axis", "'" + name + "' is neither an axis of the rig nor a joint (there are: " +
                               Names(setup, has_path) + ")");
    }
    axis.indices.push_back(joint);
  }
  return axis;
}

bool Turns(const Section& section, const MeasureSetup& setup, const SweepAxis& axis) {
  if (axis.kind == SweepAxis::Kind::kPath) return false;
  if (axis.kind == SweepAxis::Kind::kRig) return AxisTurns(setup.rig, axis.indices[0]);
  const auto& kinds = setup.arm.joint_kinds();
  for (const int joint : axis.indices) {
    if (kinds[joint] != kinds[axis.indices[0]]) {
      section.Fail("axis", "must not mix revolute and prismatic joints");
    }
  }
  return kinds[axis.indices[0]] == JointKind::kRevolute;
}

// The range must lie within the limits of what is swept.
void CheckRange(const Section& section, const MeasureSetup& setup, const SweepAxis& axis) {
  for (const int index : axis.indices) {
    double lower = 0.0, upper = 0.0;
    if (axis.kind == SweepAxis::Kind::kRig) {
      lower = setup.rig.axes[index].lower;
      upper = setup.rig.axes[index].upper;
    } else {
      lower = setup.arm.limits()[index].lower;
      upper = setup.arm.limits()[index].upper;
    }
    if (std::min(axis.from, axis.to) < lower - 1e-9 ||
        std::max(axis.from, axis.to) > upper + 1e-9) {
      const double unit = axis.unit == "rad" ? kDegreesPerRadian : 1.0;
      std::ostringstream reason;
      reason << "the range of " << axis.name << " must be in [" << lower * unit << ", "
             << upper * unit << (axis.unit == "rad" ? "] deg" : "]") << ", is from "
             << axis.from * unit << " to " << axis.to * unit;
      section.Fail("", reason.str());
    }
  }
}

SweepAxis LoadAxis(const Section& sweep, const std::string& key, const MeasureSetup& setup,
                   bool has_path, const std::string& length_unit) {
  const Section section = sweep.Child(key, "One of the two swept parameters.");
  SweepAxis axis = FindAxis(section, setup, has_path);
  axis.symbol = section.Text("symbol", axis.symbol, "As pictures write it.");
  if (Turns(section, setup, axis)) {
    axis.unit = "rad";
    axis.from = section.Degrees("from_deg", {-3600, 3600, "deg"}, kRequired, "First value.");
    axis.to = section.Degrees("to_deg", {-3600, 3600, "deg"}, kRequired, "Last value.");
  } else if (axis.kind == SweepAxis::Kind::kPath) {
    axis.from = section.Number("from", {0.0, 1.0, ""}, 0.0, "First value; path: 0 is its start.");
    axis.to = section.Number("to", {0.0, 1.0, ""}, 1.0, "Last value; path: 1 is its end.");
  } else {
    axis.unit = length_unit;
    axis.from = section.Number("from", {-1e4, 1e4, "m"}, kRequired, "First value.");
    axis.to = section.Number("to", {-1e4, 1e4, "m"}, kRequired, "Last value.");
  }
  if (axis.from == axis.to) section.Fail("", "the range of " + axis.name + " is empty");
  axis.samples = static_cast<int>(
      section.Integer("samples", 2, kMostSamples, 41, "Values in the range, both ends included."));
  CheckRange(section, setup, axis);
  return axis;
}

MapQuantity LoadPicture(const Section& plot, bool translation) {
  const Section::Names<MapQuantity> names{{"w_v", MapQuantity::kViewW},
                                          {"w_r", MapQuantity::kArmW},
                                          {"w_c", MapQuantity::kCompositeW},
                                          {"sigma_min_c", MapQuantity::kSigmaMin},
                                          {"geometric_mean_c", MapQuantity::kGeometricMean},
                                          {"paper_product", MapQuantity::kPaperProduct}};
  const auto quantity = plot.Choice<MapQuantity>("show", names, MapQuantity::kCompositeW,
                                                 "The quantity that the pictures show.");
  if (quantity == MapQuantity::kPaperProduct && !translation) {
    plot.Fail("show", "paper_product needs translation_task");
  }
  return quantity;
}

}  // namespace

double ValueAt(const SweepAxis& axis, int i) noexcept {
  const double t = static_cast<double>(i) / (axis.samples - 1);
  return i == axis.samples - 1 ? axis.to : axis.from + t * (axis.to - axis.from);
}

std::string SymbolOf(const std::string& name) {
  if (name == "theta") return "θ";
  if (name == "phi") return "φ";
  return name;
}

const char* Name(MapQuantity quantity) noexcept {
  switch (quantity) {
    case MapQuantity::kViewW:
      return "w_v";
    case MapQuantity::kArmW:
      return "w_r";
    case MapQuantity::kCompositeW:
      return "w_c";
    case MapQuantity::kSigmaMin:
      return "sigma_min_c";
    case MapQuantity::kGeometricMean:
      return "geometric_mean_c";
    case MapQuantity::kPaperProduct:
      return "paper_product";
  }
  return "?";
}

MapRecipe FindMapRecipe(const std::string& name_or_path, SchemaRecorder* recorder) {
  const Section root = ParseConfig(FindConfigText(ConfigKind::kRecipe, name_or_path), recorder);
  MapRecipe recipe{LoadMeasureSetup(root), "", "", "", {}};
  recipe.setup.name = std::filesystem::path(name_or_path).stem().string();
  const Section plot = root.OptionalChild("plot", "How pictures show the map.");
  recipe.title = plot.Text("title", recipe.setup.name, "Title of the pictures.");
  recipe.notes = plot.Text("notes", "", "A line below the pictures.");
  recipe.length_unit = plot.Text("length_unit", "m", "What the recipe's lengths are called.");
  recipe.logarithmic = plot.Flag("logarithmic", false, "Show log10.");
  recipe.view_turn = plot.Number("view_turn", {0.0, 360.0, "deg"}, recipe.view_turn,
                                 "Turn of the surface about its vertical axis.");
  recipe.picture = LoadPicture(plot, recipe.setup.translation_task > 0);
  const Section sweep = root.Child("sweep", "The two parameters that are swept.");
  const bool has_path = !recipe.setup.waypoints.empty();
  recipe.axes = {LoadAxis(sweep, "x", recipe.setup, has_path, recipe.length_unit),
                 LoadAxis(sweep, "y", recipe.setup, has_path, recipe.length_unit)};
  root.RejectUnknownKeys();
  return recipe;
}

}  // namespace vantage
