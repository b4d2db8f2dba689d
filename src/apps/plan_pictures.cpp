#include "plan_pictures.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "plan_print.h"
#include "render_picture.h"
#include "sim/render/arm_scene.h"
#include "sim/render/renderer.h"
#include "vantage/math/angles.h"
#include "vantage/math/error.h"
#include "vantage/math/format.h"
#include "vantage/report/gnuplot.h"

namespace vantage {
namespace {

std::vector<int> FreeAxes(const CameraRig& rig) {
  std::vector<int> axes;
  for (int i = 0; i < rig.size(); ++i) {
    if (rig.axes[i].upper > rig.axes[i].lower) axes.push_back(i);
  }
  return axes;
}

// The two axes of the map: (phi, theta) where the rig has them.
bool MapAxes(const CameraRig& rig, int* x, int* y) {
  const std::vector<int> free = FreeAxes(rig);
  const auto has = [&](int axis) { return std::count(free.begin(), free.end(), axis) > 0; };
  if (rig.kind == RigKind::kSpherical && has(1) && has(2)) {
    *x = 2;
    *y = 1;
    return true;
  }
  if (free.size() < 2) return false;
  *x = free[0];
  *y = free[1];
  return true;
}

struct Scale {
  double unit;
  std::string label;
};
Scale ScaleOf(const CameraRig& rig, int axis) {
  const bool length = !AxisTurns(rig, axis);
  return {length ? 1.0 : kDegreesPerRadian,
          GnuplotLiteral(rig.axes[axis].name) + (length ? " [m]" : " [deg]")};
}

std::vector<Marker> SceneMarkers(const PlacementSetup& setup) {
  std::vector<Marker> markers;
  for (const PlacedMarker& placed : setup.problem.scene_markers) {
    Marker marker;
    marker.id = 1000 + static_cast<int>(markers.size());
    marker.p = placed.p_W;
    marker.normal = placed.normal_W;
    marker.radius = placed.radius;
    marker.dark = false;
    markers.push_back(marker);
  }
  return markers;
}

void WriteMapTable(const PlacementSetup& setup, const PlacementMap& map, const std::string& path) {
  std::ofstream table(path);
  const CameraRig& rig = setup.problem.rig;
  for (const RigAxis& axis : rig.axes) table << axis.name << ',';
  table << "value,feasible";
  for (int i = 0; i < kPlanLimits; ++i) {
    table << ",margin " << Name(static_cast<PlanLimit>(i));
  }
  table << '\n';
  table.precision(9);
  for (const PlacedCamera& cell : map.cells) {
    for (int i = 0; i < rig.size(); ++i) table << cell.q_c(i) << ',';
    table << cell.value << ',' << (cell.feasible ? 1 : 0);
    for (const double margin : cell.margins) table << ',' << margin;
    table << '\n';
  }
  table.close();
  if (!table) throw WriteError(path);
}

// What the map shows of a camera; NaN where a limit is broken.
double Shown(const PlacementSetup& setup, const PlacedCamera& cell) {
  if (!cell.feasible || !std::isfinite(cell.value)) return std::numeric_limits<double>::quiet_NaN();
  const bool ratio = setup.problem.objective.measure == BatchMeasure::kW;
  return ratio ? std::log10(std::max(cell.value, 1e-300)) : cell.value;
}

}  // namespace

std::vector<std::string> PlotPlacementMap(const PlacementSetup& setup, const PlacementModel& model,
                                          const PlacementResult& result, const std::string& stem) {
  const CameraRig& rig = setup.problem.rig;
  int axis_x = 0, axis_y = 0;
  if (!MapAxes(rig, &axis_x, &axis_y)) return {};
  constexpr int kColumns = 181, kRows = 91;
  const PlacementMap map = MapPlacements(model, result.best.q_c, axis_x, axis_y, kColumns, kRows);
  WriteMapTable(setup, map, stem + "_map.csv");
  const Scale x = ScaleOf(rig, axis_x), y = ScaleOf(rig, axis_y);
  const bool ratio = setup.problem.objective.measure == BatchMeasure::kW;
  const std::string script_path = stem + "_map.gp";
  const std::string name = std::filesystem::path(stem).filename().string();
  std::ofstream script(script_path);
  script << "$map << EOD\n";
  script.precision(9);
  double top = -std::numeric_limits<double>::infinity(), bottom = -top;
  for (int r = 0; r < kRows; ++r) {
    for (int c = 0; c < kColumns; ++c) {
      const double shown = Shown(setup, map.cells[static_cast<std::size_t>(r) * kColumns + c]);
      script << map.x[c] * x.unit << ' ' << map.y[r] * y.unit << ' ';
      if (std::isnan(shown)) {
        script << "NaN\n";
      } else {
        script << shown << '\n';
        top = std::max(top, shown);
        bottom = std::min(bottom, shown);
      }
    }
    script << '\n';
  }
  if (!(top > -std::numeric_limits<double>::infinity())) top = bottom = 0.0;
  // From the best to what is a hundred times worse: the rest is bad alike.
  if (ratio) bottom = std::max(bottom, top - 2.0);
  if (!(top > bottom)) bottom = top - 1.0;
  const auto mark = [&](const PlacedCamera& camera) {
    return std::to_string(camera.q_c(axis_x) * x.unit) + "," +
           std::to_string(camera.q_c(axis_y) * y.unit);
  };
  script << "EOD\n"
         << "set title "
         << GnuplotString(GnuplotLiteral(setup.name + ": value over " + rig.axes[axis_x].name +
                                         " and " + rig.axes[axis_y].name) +
                          "\n{/*0.8 grey: a limit is broken}")
         << " font ',15'\n"
         << "set xlabel " << GnuplotString(x.label) << "\nset ylabel " << GnuplotString(y.label)
         << '\n'
         << "set cblabel '" << (ratio ? "log_{10} value" : "value") << "'\n"
         << "set xrange [" << map.x.front() * x.unit << ":" << map.x.back() * x.unit << "]\n"
         << "set yrange [" << map.y.front() * y.unit << ":" << map.y.back() * y.unit << "]\n"
         << "set cbrange [" << bottom << ":" << top << "]\n"
         << "set palette defined (0 '#440154', 0.25 '#3b528b', 0.5 '#21918c', 0.75 '#5ec962', 1 "
            "'#fde725')\n"
         << "set object 1 rectangle from graph 0,0 to graph 1,1 fillcolor rgb '#d8d8d8' behind\n"
         << "set object 2 circle at " << mark(result.best)
         << " size graph 0.014 front fillstyle empty border rgb '#d01020' linewidth 3\n"
         << "set label 1 'best' at " << mark(result.best)
         << " front offset 1.2,0.8 textcolor rgb '#d01020' font ',13'\n"
         << "set object 3 circle at " << mark(result.start)
         << " size graph 0.010 front fillstyle solid border rgb 'black' linewidth 2\n"
         << "set label 2 'start' at " << mark(result.start)
         << " front offset 1.2,-0.8 textcolor rgb 'black' font ',12'\n"
         << "unset key\n";
  for (const bool png : {true, false}) {
    script << "set terminal "
           << (png ? "pngcairo size 1000,620 enhanced font 'DejaVu Sans,12' background 'white'"
                   : "svg size 1000,620 enhanced font 'DejaVu Sans,12' background 'white'")
           << "\nset output " << GnuplotString(name + "_map." + (png ? "png" : "svg")) << '\n'
           << "plot $map using 1:2:3 with image pixels\n";
  }
  script << "unset output\n";
  script.close();
  if (!script) throw WriteError(script_path);
  RunGnuplot(script_path);
  return {stem + "_map.png", stem + "_map.svg", stem + "_map.csv", script_path};
}

std::vector<std::string> DrawViews(const PlacementSetup& setup, const PlacementResult& result,
                                   const std::string& stem) {
  CameraModel camera = setup.view.camera;
  if (!setup.pixels) {
    // A picture of what the lens admits, or of 60 degrees.
    camera = CameraModel();
    const double half = std::min(setup.problem.lens.x_max, 0.6);
    camera.fx = camera.fy = 0.5 * camera.width / half;
  }
  const ArmMotion& motion = setup.problem.motion;
  const ArmSample& sample = motion.samples[motion.size() / 2];
  sim::Scene scene = sim::MakeArmScene(setup.view.arm, setup.view.markers, SceneMarkers(setup));
  for (const BatchBox& box : setup.problem.limits.boxes) {
    sim::Body body;
    sim::Append(&body.mesh, sim::BoxMesh(2.0 * box.half), box.X_WB);
    body.colour = Eigen::Vector3f(0.55F, 0.58F, 0.52F);
    scene.bodies.push_back(body);
  }
  sim::Renderer renderer(sim::MakeGlContext(), camera, std::move(scene));
  const sim::SceneState state(ComputeLinkPoses(setup.view.arm, sample.q), sample.kinematics.X_WE);
  cv::Mat both;
  for (const bool best : {true, false}) {
    const PlacedCamera& view = best ? result.best : result.worst;
    const cv::Mat bgr = RenderPicture(&renderer, view.X_WC, state);
    const std::string caption = Format("%s: %.4g", best ? "best" : "worst of the grid", view.value);
    cv::putText(bgr, caption, {14, 30}, cv::FONT_HERSHEY_SIMPLEX, 0.75, {255, 255, 255}, 4,
                cv::LINE_AA);
    cv::putText(bgr, caption, {14, 30}, cv::FONT_HERSHEY_SIMPLEX, 0.75, {30, 30, 30}, 1,
                cv::LINE_AA);
    if (both.empty()) {
      both = bgr.clone();
    } else {
      cv::Mat gap(bgr.rows, 8, CV_8UC3, cv::Scalar(255, 255, 255));
      cv::hconcat(std::vector<cv::Mat>{both, gap, bgr}, both);
    }
  }
  const std::string path = stem + "_views.png";
  if (!cv::imwrite(path, both)) throw WriteError(path);
  return {path};
}

}  // namespace vantage
