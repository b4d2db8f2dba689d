#include "run_figures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "figure.h"
#include "measure_label.h"
#include "vantage/math/angles.h"
#include "vantage/math/format.h"
#include "vantage/report/gnuplot.h"
#include "vantage/robot/kinematics.h"

namespace vantage {
namespace {

constexpr int kWidth = 1200;

std::string Range(double from, double to) {
  return "[" + Format("%.9g", from) + ":" + Format("%.9g", to) + "]";
}

/// (t, value) rows of a list of stamped values.
template <typename Values, typename Get>
std::vector<FigureRow> Curve(const RunLog& log, const Values& values, Get&& get) {
  std::vector<FigureRow> rows;
  rows.reserve(values.size());
  for (const auto& value : values) rows.push_back({log.At(value.stamp), get(value)});
  return Thinned(rows);
}

double PositiveOrGap(double value) {
  return value > 0.0 ? value : std::nan("");
}

// Reports from before the first image hold no measures.
double Measured(const ObservabilityReport& report, double value) {
  return report.k > 0 ? value : std::nan("");
}

void TimeAxis(const RunLog& log, Figure* figure) {
  *figure << "set xrange " + Range(std::min(0.0, log.At(log.t0)), std::max(0.1, log.At(log.end)))
          << "set lmargin 11"
          << "set rmargin 12";
}

// Blue where the camera moves, red where the servo holds.
void Bands(const RunLog& log, Figure* figure) {
  for (const CameraMove& move : CameraMovesOf(log)) {
    figure->Band(move.begin, move.end, Palette::kMoving);
  }
  for (const StateInterval& stop : StopsOf(StatesOf(log))) {
    figure->Band(stop.begin, stop.end, Palette::kHolding);
  }
}

constexpr char kBandsText[] =
    "Blue bands: the camera moves. Red bands: the servo holds or is stopped.";

DrawnFigure DrawError(const RunLog& log, const std::string& folder) {
  Figure figure("error", kWidth, 420);
  TimeAxis(log, &figure);
  Bands(log, &figure);
  const std::string error = figure.Data(
      Curve(log, log.statuses, [](const ServoStatus& s) { return PositiveOrGap(s.error_px); }));
  figure << "set logscale y"
         << "set format y '10^{%L}'"
         << "set ylabel 'image error [px]'"
         << "set xlabel 'time [s]'";
  std::string plot = "plot " + error + " using 1:2 with lines lw 1.8 lc rgb '" + Palette::Line(0) +
                     "' title 'image error (root mean square)'";
  const auto truths = Curve(
      log, log.truths, [](const GroundTruth& t) { return PositiveOrGap(1e3 * t.worst_error); });
  if (std::any_of(truths.begin(), truths.end(), IsPoint)) {
    const std::string truth = figure.Data(truths);
    figure << "set ytics nomirror"
           << "set y2tics"
           << "set logscale y2"
           << "set format y2 '10^{%L}'"
           << "set y2label 'true error [mm]'";
    plot += ", " + truth + " using 1:2 axes x1y2 with lines lw 1.8 lc rgb '" + Palette::Line(1) +
            "' title 'true error of the worst marker (simulator)'";
  }
  if (log.scenario) {
    plot += ", " + Format("%g", log.scenario->servo.convergence.tolerance_px) +
            " with lines dashtype 2 lc rgb '#6b7280' title 'tolerance of convergence'";
  }
  figure << plot;
  figure.Draw(folder);
  return {"error", "Error", std::string("Error of the features in the image. ") + kBandsText};
}

// One curve over time, on a logarithmic axis.
std::string LogCurve(const RunLog& log, Figure* figure, double ObservabilityReport::*value,
                     int colour, const std::string& title) {
  const std::string data =
      figure->Data(Curve(log, log.observability, [&](const ObservabilityReport& report) {
        return PositiveOrGap(Measured(report, report.*value));
      }));
  return data + " using 1:2 with lines lw 1.8 lc rgb '" + Palette::Line(colour) + "' title '" +
         title + "'";
}

void PlotTrigger(const RunLog& log, Figure* figure) {
  const std::string value = figure->Data(Curve(log, log.observability, [](const auto& report) {
    return Measured(report, report.trigger_value);
  }));
  const std::string threshold = figure->Data(
      Curve(log, log.observability, [](const auto& report) { return report.threshold; }));
  std::vector<FigureRow> fired;
  for (const TriggerInterval& trigger : TriggersOf(log)) {
    for (const ObservabilityReport& report : log.observability) {
      if (log.At(report.stamp) < trigger.begin) continue;
      fired.push_back({trigger.begin, report.trigger_value});
      break;
    }
  }
  *figure << std::string("set ylabel '") + MeasureLabel(log.observability.back().trigger_measure) +
                 "'"
          << "set yrange [0:*]"
          << "plot " + value + " using 1:2 with lines lw 1.8 lc rgb '" + Palette::Line(2) +
                 "' title 'trigger value', " + threshold +
                 " using 1:2 with lines dashtype 2 lw 1.5 lc rgb '" + Palette::kLimit +
                 "' title 'threshold'" +
                 (fired.empty() ? ""
                                : ", " + figure->Data(fired) +
                                      " using 1:2 with points pt 11 ps 1.6 lc rgb '" +
                                      Palette::kLimit + "' title 'trigger fires'")
          << "set yrange [*:*]";
}

void PlotSigma(const RunLog& log, Figure* figure) {
  int most = 0;
  for (const ObservabilityReport& report : log.observability) {
    most = std::max(most, report.composite.size());
  }
  std::string plot = "plot ";
  for (int i = 0; i < most; ++i) {
    const std::string data =
        figure->Data(Curve(log, log.observability, [i](const ObservabilityReport& report) {
          return i < report.composite.size() ? PositiveOrGap(report.composite.sigma(i))
                                             : std::nan("");
        }));
    plot += (i > 0 ? ", " : "") + data + " using 1:2 with lines lw 1.6 lc rgb '" +
            Palette::Line(i) + "' title 'σ" + std::to_string(i + 1) + "'";
  }
  *figure << "set ylabel 'σ_i of J_c [px/rad]'" << plot;
}

DrawnFigure DrawMeasures(const RunLog& log, const std::string& folder) {
  Figure figure("measures", kWidth, 1500);
  TimeAxis(log, &figure);
  figure << "set multiplot layout 5,1 spacing 0,0.035"
         << "set key outside right top width -6"
         << "set rmargin 22";
  Bands(log, &figure);
  PlotTrigger(log, &figure);
  figure << "set logscale y"
         << "set format y '10^{%L}'"
         << "set ylabel 'w_v, w_c'"
         << "plot " + LogCurve(log, &figure, &ObservabilityReport::w_v, 0, "w_v (view)") + ", " +
                LogCurve(log, &figure, &ObservabilityReport::w_c, 5, "w_c (both)")
         << "set ylabel 'w_r'"
         << "plot " + LogCurve(log, &figure, &ObservabilityReport::w_r, 7, "w_r (arm)");
  PlotSigma(log, &figure);
  figure << "set ylabel 'hidden motion [mm/px]'"
         << "set xlabel 'time [s]'"
         << "plot " +
                LogCurve(log, &figure, &ObservabilityReport::mm_per_px, 6, "one pixel may hide") +
                (log.scenario
                     ? ", " + Format("%g", log.scenario->servo.convergence.max_mm_per_px) +
                           " with lines dashtype 2 lc rgb '#6b7280' title 'most at the end'"
                     : "")
         << "unset multiplot";
  figure.Draw(folder);
  return {"measures", "Observability",
          std::string("The trigger's measure against its threshold; observability of the view, "
                      "manipulability of the arm and the composite of both; singular values of the "
                      "composite Jacobian; the motion that one pixel may hide. ") +
              kBandsText};
}

/// Where one marker went in the image.
struct ImagePath {
  std::vector<FigureRow> rows;
  std::optional<Eigen::Vector2d> first, last;
};

std::map<int, ImagePath> ImagePaths(const RunLog& log) {
  std::map<int, ImagePath> paths;
  for (const ImageFeatures& image : log.features) {
    for (int i = 0; i < image.count; ++i) {
      const MarkerMeasurement& marker = image.markers[i];
      ImagePath& path = paths[marker.id];
      if (!marker.valid) {
        if (!path.rows.empty() && !path.rows.back().empty()) path.rows.push_back({});
        continue;
      }
      path.rows.push_back({marker.pixel.x(), marker.pixel.y()});
      if (!path.first) path.first = marker.pixel;
      path.last = marker.pixel;
    }
  }
  return paths;
}

// Goal points as the last camera pose sees them, by the model.
std::vector<FigureRow> GoalInImage(const RunLog& log) {
  std::vector<FigureRow> rows;
  if (!log.scenario || log.camera_poses.empty()) return rows;
  const CameraModel& camera = log.scenario->task.view.camera;
  const ServoGoal& goal = log.scenario->task.goal;
  const Eigen::Isometry3d X_CW = log.camera_poses.back().X_WC.inverse();
  for (const Eigen::Vector3d& p_WG : goal.p_WG) {
    const auto image = Project(X_CW * (p_WG + goal.offset_W));
    if (!image) continue;
    const Eigen::Vector2d pixel = ToUndistortedPixel(camera, image->n);
    rows.push_back({pixel.x(), pixel.y()});
  }
  return rows;
}

DrawnFigure DrawFeatures(const RunLog& log, const std::string& folder) {
  const CameraModel camera = log.scenario ? log.scenario->task.view.camera : CameraModel();
  const int height = 130 + 900 * camera.height / camera.width;
  Figure figure("features", kWidth, height);
  std::string plot;
  const auto add = [&](const std::string& part) { plot += (plot.empty() ? "plot " : ", ") + part; };
  std::vector<FigureRow> starts, ends;
  int colour = 0;
  for (const auto& [id, path] : ImagePaths(log)) {
    if (!path.first) continue;
    const bool goal = log.IsGoalMarker(id);
    const std::string line = goal ? "#9ca3af" : Palette::Line(colour++);
    add(figure.Data(path.rows) + " using 1:2 with lines lw " + (goal ? "1.2" : "1.8") +
        " lc rgb '" + line + "' title '" + (goal ? "goal marker " : "marker ") +
        std::to_string(id) + "'");
    if (goal) continue;
    starts.push_back({path.first->x(), path.first->y()});
    ends.push_back({path.last->x(), path.last->y()});
  }
  if (!starts.empty()) {
    add(figure.Data(starts) +
        " using 1:2 with points pt 6 ps 1.5 lw 1.5 lc rgb '#111827' title 'first seen'");
    add(figure.Data(ends) +
        " using 1:2 with points pt 7 ps 1.3 lc rgb '#111827' title 'last seen'");
  }
  const std::vector<FigureRow> goal = GoalInImage(log);
  if (!goal.empty()) {
    add(figure.Data(goal) + " using 1:2 with points pt 1 ps 2.2 lw 2 lc rgb '" + Palette::kLimit +
        "' title 'goal in the last view (prior)'");
  }
  figure << "set size ratio -1"
         << "set xrange " + Range(-0.5, camera.width - 0.5)
         << "set yrange " + Range(camera.height - 0.5, -0.5) << "set xlabel 'u [px]'"
         << "set ylabel 'v [px]'"
         << "set key outside right top" << plot;
  figure.Draw(folder);
  return {
      "features", "Paths in the image",
      "Where the markers went in the image; a line is broken where its marker was not seen. The "
      "camera's own motion is in them."};
}

// Limits of a joint as lines, and the range to show so that both curve and limits are seen.
struct JointPanel {
  std::string measured, commanded;
  double lower{0.0}, upper{0.0};
  bool limited{false};
};

void PlotPanel(const JointPanel& panel, const std::string& label, Figure* figure) {
  std::string plot = "plot ";
  if (!panel.commanded.empty()) {
    plot += panel.commanded + " using 1:2 with lines lw 1.2 lc rgb '" + Palette::Line(1) +
            "' title 'commanded', ";
  }
  plot += panel.measured + " using 1:2 with lines lw 1.6 lc rgb '" + Palette::Line(0) +
          "' title 'measured'";
  if (panel.limited) {
    const double margin = 0.06 * (panel.upper - panel.lower);
    *figure << "set yrange " + Range(panel.lower - margin, panel.upper + margin);
    for (const double limit : {panel.lower, panel.upper}) {
      plot += ", " + Format("%.9g", limit) + " with lines dashtype 2 lw 1.3 lc rgb '" +
              Palette::kLimit + "' " + (limit == panel.lower ? "title 'limit'" : "notitle");
    }
  }
  *figure << "set ylabel " + GnuplotString(label) << plot << "set yrange [*:*]";
}

DrawnFigure DrawJoints(const RunLog& log, const std::string& folder) {
  const int n = static_cast<int>(log.joint_states.front().q.size());
  Figure figure("joints", kWidth, 90 + 200 * n);
  TimeAxis(log, &figure);
  figure << "set multiplot layout " + std::to_string(n) + ",2 spacing 0.06,0.02"
         << "set rmargin 2"
         << "unset key";
  for (int i = 0; i < n; ++i) {
    const auto of = [i](const JointVector& values, double factor) {
      return i < values.size() ? factor * values(i) : std::nan("");
    };
    const bool modelled = log.scenario && log.scenario->task.view.arm.size() == n;
    const ArmModel* arm = modelled ? &log.scenario->task.view.arm : nullptr;
    const bool turns = !modelled || arm->joint_kinds()[i] == JointKind::kRevolute;
    const double unit = turns ? kDegreesPerRadian : 1e3;
    const std::string name = modelled ? arm->joint_names()[i] : "joint " + std::to_string(i + 1);
    JointPanel position, velocity;
    position.measured = figure.Data(
        Curve(log, log.joint_states, [&](const JointState& s) { return of(s.q, unit); }));
    velocity.measured = figure.Data(
        Curve(log, log.joint_states, [&](const JointState& s) { return of(s.qdot, unit); }));
    if (!log.joint_commands.empty()) {
      velocity.commanded = figure.Data(
          Curve(log, log.joint_commands, [&](const JointCommand& c) { return of(c.qdot, unit); }));
    }
    if (modelled) {
      const JointLimits& limit = arm->limits()[i];
      position.limited = velocity.limited = true;
      position.lower = unit * limit.lower;
      position.upper = unit * limit.upper;
      velocity.lower = -unit * limit.velocity;
      velocity.upper = unit * limit.velocity;
    }
    if (i == n - 1) figure << "set xlabel 'time [s]'";
    PlotPanel(position, GnuplotLiteral(name) + (turns ? " [deg]" : " [mm]"), &figure);
    figure << "set key top right horizontal";
    if (i > 0) figure << "unset key";
    PlotPanel(velocity, turns ? "[deg/s]" : "[mm/s]", &figure);
    figure << "unset key";
  }
  figure << "unset multiplot";
  figure.Draw(folder);
  return {
      "joints", "Joints",
      "Position (left) and velocity (right) of each joint against its limits; blue is measured, "
      "red commanded."};
}

// The pyramid that a camera sees, `depth` deep, as one line.
void AppendFrustum(const CameraModel& camera, const Eigen::Isometry3d& X_WC, double depth,
                   std::vector<FigureRow>* rows) {
  const auto corner = [&](double u, double v) -> Eigen::Vector3d {
    return X_WC * Eigen::Vector3d(depth * (u - camera.u0) / camera.fx,
                                  depth * (v - camera.v0) / camera.fy, depth);
  };
  const std::array<Eigen::Vector3d, 4> corners{corner(0, 0), corner(camera.width, 0),
                                               corner(camera.width, camera.height),
                                               corner(0, camera.height)};
  const Eigen::Vector3d eye = X_WC.translation();
  const auto add = [rows](const Eigen::Vector3d& p) { rows->push_back({p.x(), p.y(), p.z()}); };
  for (int i = 0; i < 4; ++i) {
    add(eye);
    add(corners[i]);
    add(corners[(i + 1) % 4]);
    add(eye);
    rows->push_back({});
    rows->push_back({});
  }
}

// Where a point of the end effector went, from the joints.
std::vector<FigureRow> MarkerPath(const RunLog& log) {
  std::vector<FigureRow> rows;
  if (!log.scenario) return rows;
  const ViewModel& view = log.scenario->task.view;
  const std::size_t step = std::max<std::size_t>(1, log.joint_states.size() / 600);
  Eigen::Vector3d p_EM = Eigen::Vector3d::Zero();
  for (const Marker& marker : view.markers) p_EM += marker.p;
  p_EM /= static_cast<double>(view.markers.size());
  for (std::size_t i = 0; i < log.joint_states.size(); i += step) {
    const JointVector& q = log.joint_states[i].q;
    if (q.size() != view.arm.size()) continue;
    const Eigen::Vector3d p_WM = EndEffectorPose(view.arm, q) * p_EM;
    rows.push_back({p_WM.x(), p_WM.y(), p_WM.z()});
  }
  return rows;
}

// The arm as a line through its joints at one configuration.
std::vector<FigureRow> ArmLine(const ArmModel& arm, const JointVector& q) {
  std::vector<FigureRow> rows;
  const auto add = [&](const Eigen::Vector3d& p) { rows.push_back({p.x(), p.y(), p.z()}); };
  add(arm.X_WBase().translation());
  const LinkPoses X_WL = ComputeLinkPoses(arm, q);
  for (int i = 0; i < arm.size(); ++i) add(X_WL[static_cast<std::size_t>(i)].translation());
  add(EndEffectorPose(arm, q).translation());
  return rows;
}

DrawnFigure DrawCameraPath(const RunLog& log, const std::string& folder) {
  Figure figure("camera", kWidth, 820);
  const CameraModel camera = log.scenario ? log.scenario->task.view.camera : CameraModel();
  std::vector<FigureRow> path;
  const std::size_t step = std::max<std::size_t>(1, log.camera_poses.size() / 1000);
  for (std::size_t i = 0; i < log.camera_poses.size(); i += step) {
    const Eigen::Vector3d p = log.camera_poses[i].X_WC.translation();
    path.push_back({p.x(), p.y(), p.z(), log.At(log.camera_poses[i].stamp)});
  }
  const double depth = 0.09 * (log.camera_poses.front().X_WC.translation().norm() + 0.5);
  std::vector<FigureRow> first, last;
  AppendFrustum(camera, log.camera_poses.front().X_WC, depth, &first);
  AppendFrustum(camera, log.camera_poses.back().X_WC, depth, &last);
  std::string plot = "splot " + figure.Data(path) +
                     " using 1:2:3:4 with lines lw 3 lc palette title 'camera', " +
                     figure.Data(first) +
                     " using 1:2:3 with lines lw 1.2 lc rgb '#6b7280' title "
                     "'first view', " +
                     figure.Data(last) +
                     " using 1:2:3 with lines lw 1.6 lc rgb '#111827' title "
                     "'last view'";
  if (log.scenario && !log.joint_states.empty()) {
    const ArmModel& arm = log.scenario->task.view.arm;
    if (log.joint_states.back().q.size() == arm.size()) {
      plot += ", " + figure.Data(ArmLine(arm, log.joint_states.front().q)) +
              " using 1:2:3 with linespoints lw 2 pt 7 ps 0.7 lc rgb '#d1d5db' title 'arm, first'";
      plot += ", " + figure.Data(ArmLine(arm, log.joint_states.back().q)) +
              " using 1:2:3 with linespoints lw 4 pt 7 ps 1 lc rgb '#6b7280' title 'arm, last'";
    }
    const std::vector<FigureRow> markers = MarkerPath(log);
    if (!markers.empty()) {
      plot += ", " + figure.Data(markers) + " using 1:2:3 with lines lw 2 lc rgb '" +
              Palette::Line(1) + "' title 'markers (their centre)'";
    }
    std::vector<FigureRow> goal;
    for (const Eigen::Vector3d& p : log.scenario->task.goal.p_WG) {
      const Eigen::Vector3d p_WG = p + log.scenario->task.goal.offset_W;
      goal.push_back({p_WG.x(), p_WG.y(), p_WG.z()});
    }
    plot += ", " + figure.Data(goal) + " using 1:2:3 with points pt 1 ps 1.6 lw 2 lc rgb '" +
            Palette::kLimit + "' title 'goal (prior)'";
  }
  figure << "set view 62,35,1.3"
         << "set view equal xyz"
         << "set xyplane relative 0"
         << "set xlabel 'x [m]'"
         << "set ylabel 'y [m]'"
         << "set zlabel 'z [m]' rotate"
         << "set palette defined (0 '#93c5fd', 1 '#1e3a8a')"
         << "set cblabel 'time [s]'"
         << "set cbrange " + Range(0.0, std::max(0.1, log.At(log.end)))
         << "set key outside left top vertical"
         << "set colorbox user origin 0.94,0.2 size 0.015,0.6" << plot;
  figure.Draw(folder);
  return {
      "camera", "Camera path",
      "The path of the camera's centre in the arm's world, coloured by time, with the pyramid it "
      "sees at the begin and at the end, and the arm."};
}

// Counts of durations in equal steps of their logarithm: (microseconds, count).
std::vector<FigureRow> LogHistogram(const std::vector<double>& us) {
  constexpr int kPerDecade = 20;
  std::map<int, int> counts;
  for (const double value : us) {
    ++counts[static_cast<int>(std::floor(kPerDecade * std::log10(std::max(value, 0.1))))];
  }
  std::vector<FigureRow> rows;
  for (const auto& [bucket, count] : counts) {
    const double from = std::pow(10.0, static_cast<double>(bucket) / kPerDecade);
    const double to = std::pow(10.0, static_cast<double>(bucket + 1) / kPerDecade);
    rows.push_back({std::sqrt(from * to), static_cast<double>(count), from, to});
  }
  return rows;
}

void PlotHistogram(const std::vector<double>& us, const std::string& label, int colour,
                   Figure* figure) {
  std::vector<double> sorted = us;
  std::sort(sorted.begin(), sorted.end());
  const auto percentile = [&](double fraction) {
    return sorted[static_cast<std::size_t>(fraction * static_cast<double>(sorted.size() - 1))];
  };
  const std::string data = figure->Data(LogHistogram(us));
  *figure << "set title \"" + label + ": median " + Format("%.1f", percentile(0.5)) + ", 99 % " +
                 Format("%.1f", percentile(0.99)) + ", 99.9 % " +
                 Format("%.1f", percentile(0.999)) + ", longest " + Format("%.1f", sorted.back()) +
                 " µs\""
          << "plot " + data +
                 " using 1:2:3:4:(0.5):2 with boxxyerror fillstyle solid 0.75 lc rgb '" +
                 Palette::Line(colour) + "' notitle";
}

DrawnFigure DrawTiming(const RunLog& log, const std::string& folder) {
  std::vector<double> execution, lateness;
  for (const PeriodTiming& period : log.periods) {
    if (period.execution.count() > 0) execution.push_back(1e6 * ToSeconds(period.execution));
    lateness.push_back(1e6 * ToSeconds(period.lateness));
  }
  // A log from before there was a record of every period has those of its reports.
  if (execution.empty()) {
    for (const ServoStatus& status : log.statuses) execution.push_back(status.loop_time_us);
  }
  Figure figure("timing", kWidth, lateness.empty() ? 400 : 760);
  figure << "set multiplot layout " + std::string(lateness.empty() ? "1" : "2") + ",1"
         << "set logscale xy"
         << "set yrange [0.5:*]"
         << "set ylabel 'periods'"
         << "set xlabel '[µs]'"
         << "set lmargin 9";
  PlotHistogram(execution, "Execution of a control period", 0, &figure);
  if (!lateness.empty()) PlotHistogram(lateness, "Begin after the deadline", 3, &figure);
  figure << "unset multiplot";
  figure.Draw(folder);
  return {"timing", "Timing",
          "How long each control period took, and how late it began. Both axes are logarithmic."};
}

}  // namespace

std::vector<DrawnFigure> DrawFigures(const RunLog& log, const std::string& folder) {
  std::vector<DrawnFigure> figures;
  const bool measured = std::any_of(log.observability.begin(), log.observability.end(),
                                    [](const ObservabilityReport& o) { return o.k > 0; });
  const bool error = std::any_of(log.statuses.begin(), log.statuses.end(),
                                 [](const ServoStatus& s) { return s.error_px > 0.0; });
  const auto paths = ImagePaths(log);
  const bool seen = std::any_of(paths.begin(), paths.end(),
                                [](const auto& path) { return path.second.first.has_value(); });
  if (error) figures.push_back(DrawError(log, folder));
  if (measured) figures.push_back(DrawMeasures(log, folder));
  if (seen) figures.push_back(DrawFeatures(log, folder));
  if (!log.camera_poses.empty()) figures.push_back(DrawCameraPath(log, folder));
  if (!log.joint_states.empty()) figures.push_back(DrawJoints(log, folder));
  if (!log.statuses.empty()) figures.push_back(DrawTiming(log, folder));
  return figures;
}

}  // namespace vantage
