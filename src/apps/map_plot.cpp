#include "map_plot.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <numeric>

#include "vantage/math/angles.h"
#include "vantage/math/error.h"
#include "vantage/math/format.h"
#include "vantage/report/gnuplot.h"

namespace vantage {
namespace {

std::string Short(double value) {
  return Format("%.4g", value);
}

std::string Degrees(double radians) {
  return Short(radians * kDegreesPerRadian) + "°";
}

std::string Triple(const Eigen::Vector3d& v) {
  const auto clean = [](double x) { return Short(std::abs(x) < 1e-12 ? 0.0 : x); };
  return "(" + clean(v.x()) + ", " + clean(v.y()) + ", " + clean(v.z()) + ")";
}

bool IsSwept(const MapRecipe& recipe, SweepAxis::Kind kind, int index) {
  for (const SweepAxis& axis : recipe.axes) {
    if (axis.kind == SweepAxis::Kind::kPath && kind == SweepAxis::Kind::kJoint) return true;
    if (axis.kind != kind) continue;
    for (const int swept : axis.indices) {
      if (swept == index) return true;
    }
  }
  return false;
}

std::string ArmNote(const MapRecipe& recipe) {
  const MeasureSetup& setup = recipe.setup;
  std::string text = "arm: " + setup.arm.name();
  for (int i = 0; i < setup.arm.size(); ++i) {
    if (IsSwept(recipe, SweepAxis::Kind::kJoint, i)) continue;
    const bool revolute = setup.arm.joint_kinds()[i] == JointKind::kRevolute;
    text += ", " + setup.arm.joint_names()[i] + " = " +
            (revolute ? Degrees(setup.q(i)) : Short(setup.q(i)) + " " + recipe.length_unit);
  }
  return text;
}

std::string CameraNote(const MapRecipe& recipe) {
  const MeasureSetup& setup = recipe.setup;
  if (setup.eye_in_hand) return "camera: in hand";
  std::string text = "camera: ";
  if (setup.rig.kind == RigKind::kSpherical) {
    text += setup.rig.orientation == RigOrientation::kLookAt
                ? "looks at " + Triple(setup.rig.target_W)
                : "looks along -Z, about " + Triple(setup.rig.target_W);
  } else {
    text += "at " + Triple(setup.rig.X_WC_fixed.translation());
  }
  for (int i = 0; i < setup.rig.size(); ++i) {
    if (IsSwept(recipe, SweepAxis::Kind::kRig, i)) continue;
    text += ", " + SymbolOf(setup.rig.axes[i].name) + " = " +
            (AxisTurns(setup.rig, i) ? Degrees(setup.q_c(i))
                                     : Short(setup.q_c(i)) + " " + recipe.length_unit);
  }
  return text + ", f = " + Short(setup.camera.fx) + (setup.pixels ? " px" : "");
}

std::string FeatureNote(const MeasureSetup& setup) {
  std::string text = "features:";
  const auto& features = setup.features.features();
  for (std::size_t i = 0; i < features.size(); ++i) {
    text += (i == 0 ? " " : ", ") + NameOf(features[i]);
  }
  text += setup.points.size() == 1 ? " of point" : " of points";
  for (std::size_t i = 0; i < setup.points.size(); ++i) {
    text += (i == 0 ? " " : ", ") + std::to_string(i) + " " + Triple(setup.points[i].marker.p);
  }
  return text + (setup.points.front().on_body ? " on the end effector" : " in the world");
}

// Only where all rows and joints have one unit does a product of singular values have a plain one.
std::string UnitNote(const MapRecipe& recipe, MapQuantity quantity) {
  if (quantity == MapQuantity::kViewW || quantity == MapQuantity::kArmW) return "";
  const MeasureSetup& setup = recipe.setup;
  for (const Feature& feature : setup.features.features()) {
    const std::string unit = UnitOf(feature, setup.pixels);
    if (unit != "px" && unit != "-") return "";
  }
  for (const JointKind kind : setup.arm.joint_kinds()) {
    if (kind != JointKind::kRevolute) return "";
  }
  const int rows = static_cast<int>(setup.features.features().size());
  const bool product =
      quantity == MapQuantity::kCompositeW || quantity == MapQuantity::kPaperProduct;
  const int power = product ? std::min({rows, setup.arm.size(), kTaskDimension}) : 1;
  const std::string exponent = power == 1 ? "" : "^{" + std::to_string(power) + "}";
  if (setup.pixels) return " [(px/rad)" + exponent + "]";
  return " [rad^{-" + std::to_string(power) + "}]";
}

std::string QuantityText(MapQuantity quantity) {
  switch (quantity) {
    case MapQuantity::kSigmaMin:
      return "σ_{min} of J_c";
    case MapQuantity::kGeometricMean:
      return "w_c^{1/s}";
    case MapQuantity::kPaperProduct:
      return "w_v w_r";
    default:
      return Name(quantity);
  }
}

// "π/3" for k = 4 twelfths of π.
std::string PiText(int twelfths) {
  if (twelfths == 0) return "0";
  const int divisor = std::gcd(std::abs(twelfths), 12);
  const int top = std::abs(twelfths) / divisor, bottom = 12 / divisor;
  return (twelfths < 0 ? "-" : "") + (top == 1 ? std::string() : std::to_string(top)) + "π" +
         (bottom == 1 ? "" : "/" + std::to_string(bottom));
}

// Tics at fractions of π where the range of an angle has its ends at some; else gnuplot's own.
std::string Tics(const SweepAxis& axis, char name) {
  const double lower = std::min(axis.from, axis.to) / kPi * 12.0;
  const double upper = std::max(axis.from, axis.to) / kPi * 12.0;
  const int first = static_cast<int>(std::lround(lower)),
            last = static_cast<int>(std::lround(upper));
  if (axis.unit != "rad" || std::abs(lower - first) > 1e-9 || std::abs(upper - last) > 1e-9)
    return "";
  int step = 1;
  for (const int coarser : {2, 3, 4, 6, 12}) {
    if ((last - first) / step > 6 && (last - first) % coarser == 0) step = coarser;
  }
  std::string tics = std::string("set ") + name + "tics (";
  for (int k = first; k <= last; k += step) {
    tics += (k == first ? "\"" : ", \"") + PiText(k) + "\" " + ExactText(k * kPi / 12.0);
  }
  return tics + ")\n";
}

void WriteData(const MapRecipe& recipe, const MapTable& table, MapQuantity quantity,
               std::ofstream* script) {
  *script << "$map << EOD\n" << std::setprecision(9);
  for (int row = 0; row < table.rows; ++row) {
    for (int column = 0; column < table.columns; ++column) {
      const MapCell& cell = table.cells[static_cast<std::size_t>(row) * table.columns + column];
      std::optional<double> value = ValueOf(cell, quantity);
      if (value && recipe.logarithmic) {
        value = *value > 0.0 ? std::optional<double>(std::log10(*value)) : std::nullopt;
      }
      *script << cell.x << ' ' << cell.y << ' ';
      if (value && std::isfinite(*value)) {
        *script << *value << '\n';
      } else {
        *script << "?\n";
      }
    }
    *script << '\n';
  }
  *script << "EOD\n";
}

std::string AxisLabel(const SweepAxis& axis) {
  return axis.unit.empty() ? axis.symbol : axis.symbol + " [" + axis.unit + "]";
}

void WriteCommon(const MapRecipe& recipe, std::ofstream* script) {
  const SweepAxis& x = recipe.axes[0];
  const SweepAxis& y = recipe.axes[1];
  // Viridis: even in lightness, and safe for readers who see fewer colours.
  *script
      << "set datafile missing '?'\n"
         "set palette defined (0 '#440154', 0.125 '#472d7b', 0.25 '#3b528b', 0.375 '#2c728e', 0.5 "
         "'#21918c', 0.625 '#28ae80', 0.75 '#5ec962', 0.875 '#addc30', 1 '#fde725')\n"
         "set encoding utf8\nunset key\nset tics out nomirror\n"
      << "set title " << GnuplotString(recipe.title) << " font ',15' offset 0,0.3\n"
      << "set xrange [" << x.from << ':' << x.to << "]\nset yrange [" << y.from << ':' << y.to
      << "]\n"
      << Tics(x, 'x') << Tics(y, 'y');
  double height = 0.018;
  std::vector<std::string> notes{FeatureNote(recipe.setup), CameraNote(recipe), ArmNote(recipe)};
  if (!recipe.notes.empty()) notes.insert(notes.begin(), recipe.notes);
  for (const std::string& note : notes) {
    *script << "set label " << GnuplotString(note) << " at screen 0.03, screen " << height
            << " left noenhanced font ',10' textcolor rgb '#404040'\n";
    height += 0.026;
  }
}

void WriteSurface(const MapRecipe& recipe, const std::string& z_label, std::ofstream* script) {
  *script << "set border 31 linecolor rgb '#707070' linewidth 0.8\n"
             "set tics textcolor rgb '#202020'\n"
             "set ztics offset -0.3, 0.65\n"
             "set xyplane relative 0\nset origin 0.025, 0.09\nset size 0.975, 0.91\n"
          << "set view 62, " << recipe.view_turn << ", 1.03, 1.25\n"
          << "set xlabel " << GnuplotString(AxisLabel(recipe.axes[0]))
          << " rotate parallel offset 0,-0.5 font ',13'\n"
          << "set ylabel " << GnuplotString(AxisLabel(recipe.axes[1]))
          << " rotate parallel offset 0,-0.5 font ',13'\n"
          << "set zlabel " << GnuplotString(z_label) << " rotate by 90 offset -2.5,0 font ',13'\n"
          << "set pm3d depthorder border linecolor rgb '#202020' linewidth 0.3\n"
             "unset colorbox\n";
  // Measures are not negative: a surface that stands on 0 shows ratios.
  if (!recipe.logarithmic) *script << "set zrange [0:*]\nset cbrange [0:*]\n";
}

void WriteHeat(const MapRecipe& recipe, const std::string& z_label, std::ofstream* script) {
  *script << "unset grid\nunset zlabel\nset xlabel norotate\nset ylabel rotate by 90\nset border "
             "31 linecolor rgb '#404040' linewidth 1\n"
             "set colorbox\nset view map\nset origin 0, 0\nset size 1, 1\n"
             "set lmargin screen 0.11\nset rmargin screen 0.82\nset bmargin screen 0.225\n"
             "set tmargin screen 0.925\n"
          << "set xlabel " << GnuplotString(AxisLabel(recipe.axes[0])) << " offset 0,0 font ',13'\n"
          << "set ylabel " << GnuplotString(AxisLabel(recipe.axes[1])) << " offset 0,0 font ',13'\n"
          << "set cblabel " << GnuplotString(z_label) << " offset 1,0 font ',13'\n"
          << "set pm3d map corners2color mean\nset pm3d noborder\n"
             "set contour base\nset cntrparam levels auto 8\nset cntrlabel onecolor\n";
}

}  // namespace

std::vector<std::string> PlotMap(const MapRecipe& recipe, const MapTable& table,
                                 MapQuantity quantity, const std::string& stem) {
  if (!FindExtremes(table, quantity)) {
    throw Error("nothing to show: no cell of the map sees all its features");
  }
  const std::string base = stem + "_" + Name(quantity);
  const std::string path = base + ".gp";
  const std::string name = std::filesystem::path(base).filename().string();
  std::ofstream script(path);
  WriteData(recipe, table, quantity, &script);
  WriteCommon(recipe, &script);
  const std::string z_label =
      (recipe.logarithmic ? "log_{10} " : "") + QuantityText(quantity) + UnitNote(recipe, quantity);
  std::vector<std::string> files;
  const auto write = [&](const std::string& kind, const std::string& ending) {
    const bool png = ending == "png";
    script << "set pm3d interpolate " << (png && kind == "heat" ? "4, 4" : "1, 1") << '\n'
           << "set terminal "
           << (png ? "pngcairo size 1000,820 enhanced font 'DejaVu Sans,12' background 'white'"
                   : "svg size 1000,820 enhanced font 'DejaVu Sans,12' background 'white'")
           << "\nset output " << GnuplotString(name + "_" + kind + "." + ending) << '\n'
           << "splot $map using 1:2:3 with pm3d nocontour"
           << (kind == "heat" ? ", $map using 1:2:3 with lines nosurface linewidth 1 linecolor rgb "
                                "'#90ffffff'\n"
                              : "\n");
    files.push_back(base + "_" + kind + "." + ending);
  };
  WriteSurface(recipe, z_label, &script);
  write("surface", "png");
  write("surface", "svg");
  WriteHeat(recipe, z_label, &script);
  write("heat", "png");
  write("heat", "svg");
  script << "unset output\n";
  script.close();
  if (!script) throw WriteError(path);
  RunGnuplot(path);
  files.push_back(path);
  return files;
}

}  // namespace vantage
