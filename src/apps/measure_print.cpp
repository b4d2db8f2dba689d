#include "measure_print.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <vector>

#include <nlohmann/json.hpp>

#include "vantage/math/angles.h"
#include "vantage/math/format.h"

namespace vantage {
namespace {

using Json = nlohmann::ordered_json;

const char* const kTwistNames[] = {"vx", "vy", "vz", "wx", "wy", "wz"};

// ---- JSON ----

Json Number(double value) {
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}

template <typename Derived>
Json List(const Eigen::MatrixBase<Derived>& vector) {
  Json list = Json::array();
  for (Eigen::Index i = 0; i < vector.size(); ++i) list.push_back(Number(vector(i)));
  return list;
}

template <typename Derived>
Json Rows(const Eigen::MatrixBase<Derived>& matrix) {
  Json rows = Json::array();
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) rows.push_back(List(matrix.row(i)));
  return rows;
}

Json EllipsoidJson(const SingularSystem& system) {
  Json json;
  json["axes"] = Rows(system.axes.transpose());
  json["directions"] = Rows(system.directions.transpose());
  json["matrix"] = Rows(EllipsoidMatrix(system));
  json["volume"] = Number(EllipsoidVolume(system.measure));
  return json;
}

Json BoundsJson(const SingularSystem& system, Eigen::Index rows, Eigen::Index columns) {
  const ErrorBounds bounds =
      BoundErrors(system.measure, static_cast<int>(rows), static_cast<int>(columns));
  Json json;
  json["lower"] = Number(bounds.lower);
  json["upper"] = Number(bounds.upper);
  json["lower_needs_range"] = bounds.lower_needs_range;
  json["upper_needs_minimum_norm"] = bounds.upper_needs_minimum_norm;
  return json;
}

const char* NameOf(SelectionCriterion criterion) {
  switch (criterion) {
    case SelectionCriterion::kW:
      return "w_c";
    case SelectionCriterion::kSigmaMin:
      return "sigma_min";
    case SelectionCriterion::kTrace:
      return "trace";
  }
  return "?";
}

const char* NameOf(SelectionOver over) {
  return over == SelectionOver::kMean ? "mean" : "worst";
}

bool HasCommonFocal(const MeasureSetup& setup) {
  return setup.camera.fx == setup.camera.fy;
}

Json PointsJson(const MeasureSetup& setup, const Measurement& m) {
  Json points = Json::array();
  for (std::size_t i = 0; i < setup.points.size(); ++i) {
    Json point;
    point["frame"] = setup.points[i].on_body ? "end_effector" : "world";
    point["position"] = List(setup.points[i].marker.p);
    point["visible"] = m.faults[i] == ViewFault::kNone;
    point["fault"] = Name(m.faults[i]);
    const bool behind = m.faults[i] == ViewFault::kBehind;
    point["uv"] = behind ? Json(nullptr) : List(m.uv[i]);
    point["depth"] = Number(m.depth[i]);
    points.push_back(point);
  }
  return points;
}

Json FeaturesJson(const MeasureSetup& setup, const Measurement& m) {
  Json features = Json::array();
  for (int row = 0; row < m.rows.size(); ++row) {
    const Feature& feature = setup.features.features()[m.rows.feature[row]];
    Json json;
    json["name"] = NameOf(feature);
    json["unit"] = UnitOf(feature, setup.pixels);
    json["value"] = Number(m.rows.s(row));
    features.push_back(json);
  }
  return features;
}

Json MissingFeaturesJson(const MeasureSetup& setup, const Measurement& m) {
  Json missing = Json::array();
  for (std::size_t i = 0; i < setup.features.features().size(); ++i) {
    if (m.rows.status[i] == RowStatus::kOk) continue;
    missing.push_back(
        {{"name", NameOf(setup.features.features()[i])}, {"status", NameOf(m.rows.status[i])}});
  }
  return missing;
}

// Gradient of log w, times `factor`.
Json GradientJson(const MeasureSetup& setup, const LogMeasureGradient& gradient, double factor) {
  if (gradient.status != GradientStatus::kOk) return nullptr;
  Json json;
  json["camera_twist"] = List(factor * gradient.by.camera);
  Json rig = Json::object();
  for (int i = 0; i < gradient.rig.size(); ++i) {
    rig[setup.rig.axes[i].name] = Number(factor * gradient.rig(i));
  }
  json["rig"] = setup.eye_in_hand ? Json(nullptr) : rig;
  const Eigen::Matrix2d by_K = factor * gradient.by.calibration;
  json["fx"] = Number(by_K(0, 0));
  json["fy"] = Number(by_K(1, 1));
  json["skew"] = Number(by_K(0, 1));
  json["focal"] = HasCommonFocal(setup) ? Number(by_K.trace()) : Json(nullptr);
  json["joints"] = List(factor * gradient.by.joints);
  return json;
}

Json GradientsJson(const MeasureSetup& setup, const LogMeasureGradient& gradient, double w) {
  return {{"status", Name(gradient.status)},
          {"w", GradientJson(setup, gradient, w)},
          {"log_w", GradientJson(setup, gradient, 1.0)}};
}

Json WhitenedJson(const std::optional<WhitenedMeasures>& whitened) {
  if (!whitened) return nullptr;
  return {{"w_v", Number(whitened->view.w)},
          {"w_c", Number(whitened->composite.w)},
          {"log_w_v", Number(whitened->view.log_w)},
          {"log_w_c", Number(whitened->composite.log_w)},
          {"singular_values_v", List(whitened->view.sigma)},
          {"singular_values_c", List(whitened->composite.sigma)}};
}

// Twists as (v, l w), l the arm's characteristic length.
Json ScaledTwistJson(const Measurement& m) {
  const double length = CharacteristicLength(m.J_r);
  const Measure view = MeasureOf(ScaleTwistOfImage(m.J_v, length));
  const Measure arm = MeasureOf(ScaleTwistOfArm(m.J_r, length));
  return {{"length", Number(length)},
          {"w_v", Number(view.w)},
          {"w_r", Number(arm.w)},
          {"condition_v", Number(view.condition)},
          {"condition_r", Number(arm.condition)}};
}

Json ChoiceJson(const MeasureSetup& setup, const FeatureChoice& choice) {
  const Selection& selection = choice.selection;
  Json json;
  json["status"] = Name(selection.status);
  json["count"] = choice.count;
  json["criterion"] = NameOf(choice.options.criterion);
  json["over"] = NameOf(choice.options.over);
  json["samples"] = choice.samples;
  json["features"] = selection.rows;
  Json names = Json::array();
  for (const int row : selection.rows) names.push_back(NameOf(setup.features.features()[row]));
  json["names"] = names;
  json["value"] = Number(selection.value);
  json["value_of_all"] = Number(selection.value_of_all);
  json["exhaustive"] = selection.exhaustive;
  json["sets"] = selection.sets;
  return json;
}

// ---- Table ----

std::string Short(double value) {
  return Format("%.6g", value);
}

std::string Triple(const Eigen::Vector3d& v) {
  const auto clean = [](double x) { return Short(std::abs(x) < 1e-12 ? 0.0 : x); };
  return "(" + clean(v.x()) + ", " + clean(v.y()) + ", " + clean(v.z()) + ")";
}

using Cells = std::vector<std::string>;

// Lines of cells: the first column to the left, the others to the right.
std::string Aligned(const std::vector<Cells>& lines, const std::string& indent = "  ") {
  std::vector<std::size_t> widths;
  for (const Cells& line : lines) {
    widths.resize(std::max(widths.size(), line.size()));
    for (std::size_t i = 0; i < line.size(); ++i) widths[i] = std::max(widths[i], line[i].size());
  }
  std::string text;
  for (const Cells& line : lines) {
    std::string row = indent;
    for (std::size_t i = 0; i < line.size(); ++i) {
      const std::string pad(widths[i] - line[i].size(), ' ');
      row += i == 0 ? line[i] + pad : "  " + pad + line[i];
    }
    row.erase(row.find_last_not_of(' ') + 1);
    text += row + "\n";
  }
  return text;
}

template <typename Derived>
std::string MatrixTable(const std::string& title, const Cells& row_names, const Cells& column_names,
                        const Eigen::MatrixBase<Derived>& matrix) {
  const double rounding = matrix.size() == 0 ? 0.0 : 1e-14 * matrix.cwiseAbs().maxCoeff();
  std::vector<Cells> lines;
  Cells head{""};
  head.insert(head.end(), column_names.begin(), column_names.end());
  lines.push_back(head);
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    Cells line{row_names[i]};
    for (Eigen::Index j = 0; j < matrix.cols(); ++j) {
      line.push_back(Short(std::abs(matrix(i, j)) < rounding ? 0.0 : matrix(i, j)));
    }
    lines.push_back(line);
  }
  return title + "\n" + Aligned(lines) + "\n";
}

Cells FeatureNames(const MeasureSetup& setup, const Measurement& m) {
  Cells names;
  for (int row = 0; row < m.rows.size(); ++row) {
    names.push_back(NameOf(setup.features.features()[m.rows.feature[row]]));
  }
  return names;
}

std::string JointsText(const MeasureSetup& setup) {
  std::string text;
  for (int i = 0; i < setup.arm.size(); ++i) {
    const bool revolute = setup.arm.joint_kinds()[i] == JointKind::kRevolute;
    text += (i == 0 ? "" : ", ") + setup.arm.joint_names()[i] + " " +
            Short(revolute ? setup.q(i) * kDegreesPerRadian : setup.q(i)) +
            (revolute ? " deg" : " m");
  }
  return text;
}

std::string CameraText(const MeasureSetup& setup, const Measurement& m) {
  std::string text =
      "at " + Triple(m.X_WC.translation()) + " m, optical axis " + Triple(m.X_WC.linear().col(2));
  if (setup.eye_in_hand) return "in hand, " + text;
  for (int i = 0; i < setup.rig.size(); ++i) {
    const bool turns = AxisTurns(setup.rig, i);
    text += (i == 0 ? "; " : ", ") + setup.rig.axes[i].name + " " +
            Short(turns ? setup.q_c(i) * kDegreesPerRadian : setup.q_c(i)) +
            (turns ? " deg" : " m");
  }
  return text;
}

std::string PointsTable(const MeasureSetup& setup, const Measurement& m) {
  std::vector<Cells> lines{{"", "u", "v", "depth [m]", "visible"}};
  for (std::size_t i = 0; i < setup.points.size(); ++i) {
    const bool behind = m.faults[i] == ViewFault::kBehind;
    lines.push_back({std::to_string(i), behind ? "-" : Short(m.uv[i].x()),
                     behind ? "-" : Short(m.uv[i].y()), Short(m.depth[i]),
                     m.faults[i] == ViewFault::kNone ? "yes" : Name(m.faults[i])});
  }
  return std::string("Points") + (setup.pixels ? " [px]" : "") + "\n" + Aligned(lines);
}

std::string MissingFeaturesText(const MeasureSetup& setup, const Measurement& m) {
  std::string text;
  for (std::size_t i = 0; i < setup.features.features().size(); ++i) {
    if (m.rows.status[i] == RowStatus::kOk) continue;
    text += (text.empty() ? "" : ", ") + NameOf(setup.features.features()[i]) + " " +
            NameOf(m.rows.status[i]);
  }
  return text.empty() ? "" : "Features without a row: " + text + "\n";
}

std::string SizeText(Eigen::Index rows, Eigen::Index columns) {
  return std::to_string(rows) + "x" + std::to_string(columns);
}

std::string MeasuresTable(const Measurement& m) {
  const Measure* const measures[] = {&m.view.measure, &m.arm.measure, &m.composite.measure};
  std::vector<Cells> lines{{"", "view J_v " + SizeText(m.J_v.rows(), m.J_v.cols()),
                            "arm J_r " + SizeText(m.J_r.rows(), m.J_r.cols()),
                            "composite J_c " + SizeText(m.J_c.rows(), m.J_c.cols())}};
  const auto add = [&](const std::string& name, auto&& value) {
    Cells line{name};
    for (const Measure* measure : measures) line.push_back(value(*measure));
    lines.push_back(line);
  };
  add("w", [](const Measure& a) { return Short(a.w); });
  add("log w", [](const Measure& a) { return Short(a.log_w); });
  add("w^(1/s)", [](const Measure& a) { return Short(a.geometric_mean()); });
  add("rank of s",
      [](const Measure& a) { return std::to_string(a.rank) + " of " + std::to_string(a.size()); });
  add("condition", [](const Measure& a) { return Short(a.condition); });
  add("sigma_min", [](const Measure& a) { return Short(a.sigma_min); });
  add("sum of 1/sigma^2", [](const Measure& a) { return Short(a.inverse_trace()); });
  int most = 0;
  for (const Measure* measure : measures) most = std::max(most, measure->size());
  for (int i = 0; i < most; ++i) {
    add("sigma " + std::to_string(i + 1),
        [i](const Measure& a) { return i < a.size() ? Short(a.sigma(i)) : std::string(); });
  }
  return "Measures\n" + Aligned(lines);
}

std::string EllipsoidTable(const Cells& names, const Measurement& m) {
  if (m.composite.axes.cols() == 0) return "";
  Cells columns;
  for (Eigen::Index i = 0; i < m.composite.axes.cols(); ++i) {
    columns.push_back("axis " + std::to_string(i + 1));
  }
  return MatrixTable("Ellipsoid of J_c: axes sigma_i u_i in feature space, volume " +
                         Short(EllipsoidVolume(m.composite.measure)),
                     names, columns, m.composite.axes);
}

// One line for each parameter: its name and unit, and four gradients.
std::string GradientsTable(const MeasureSetup& setup, const MeasureReport& report) {
  const MeasureGradients& gradients = report.gradients;
  const Measurement& m = report.measurement;
  std::vector<Cells> lines{{"", "per", "d w_c", "d log w_c", "d w_v", "d log w_v"}};
  const auto add = [&](const std::string& name, const std::string& unit, auto&& entry) {
    Cells line{name, unit};
    for (const bool composite : {true, false}) {
      const LogMeasureGradient& gradient = composite ? gradients.composite : gradients.view;
      const double w = composite ? m.composite.measure.w : m.view.measure.w;
      const bool known = gradient.status == GradientStatus::kOk;
      const double value = known ? entry(gradient) : 0.0;
      line.push_back(known ? Short(w * value) : "-");
      line.push_back(known ? Short(value) : "-");
    }
    lines.push_back(line);
  };
  for (int i = 0; i < 6; ++i) {
    add(std::string("camera ") + kTwistNames[i], i < 3 ? "m" : "rad",
        [i](const LogMeasureGradient& g) { return g.by.camera(i); });
  }
  for (int i = 0; i < gradients.composite.rig.size(); ++i) {
    add(setup.rig.axes[i].name, AxisTurns(setup.rig, i) ? "rad" : "m",
        [i](const LogMeasureGradient& g) { return g.rig(i); });
  }
  if (HasCommonFocal(setup)) {
    add("focal length", setup.pixels ? "px" : "1",
        [](const LogMeasureGradient& g) { return g.by.calibration.trace(); });
  }
  for (int i = 0; i < setup.arm.size(); ++i) {
    add(setup.arm.joint_names()[i],
        setup.arm.joint_kinds()[i] == JointKind::kRevolute ? "rad" : "m",
        [i](const LogMeasureGradient& g) { return g.by.joints(i); });
  }
  std::string text = "Gradients (camera: displacement in its own axes)\n" + Aligned(lines);
  for (const bool composite : {true, false}) {
    const GradientStatus status = (composite ? gradients.composite : gradients.view).status;
    if (status == GradientStatus::kOk) continue;
    text += std::string("  none for ") + (composite ? "w_c" : "w_v") + ": " + Name(status) +
            (status == GradientStatus::kSingular ? " (w is 0 there, with a kink)" : "") + "\n";
  }
  return text;
}

std::string BoundsText(const SingularSystem& system, Eigen::Index rows, Eigen::Index columns) {
  const ErrorBounds bounds =
      BoundErrors(system.measure, static_cast<int>(rows), static_cast<int>(columns));
  return Short(bounds.lower) + (bounds.lower_needs_range ? " (of errors in its range)" : "") +
         " to " + Short(bounds.upper) +
         (bounds.upper_needs_minimum_norm ? " (of the least motion)" : "");
}

std::string ChoiceTable(const MeasureSetup& setup, const FeatureChoice& choice) {
  const Selection& selection = choice.selection;
  const auto all = setup.features.features().size();
  std::string text = "Selection: " + std::to_string(choice.count) + " of " + std::to_string(all) +
                     " features by " + NameOf(choice.options.criterion);
  if (choice.samples > 1) {
    text += std::string(", ") + NameOf(choice.options.over) + " of " +
            std::to_string(choice.samples) + " configurations along the path";
  }
  text += "\n";
  if (selection.status == SelectionStatus::kBadCount) {
    return text + "  BAD_COUNT: must be 1 to " + std::to_string(all) + "\n";
  }
  if (selection.status != SelectionStatus::kOk) {
    return text + "  none: " + Name(selection.status) +
           (selection.status == SelectionStatus::kSingular
                ? " (no such set shows all directions of the motion)"
                : "") +
           "\n";
  }
  std::string names;
  for (const int row : selection.rows) {
    names += (names.empty() ? "" : " ") + NameOf(setup.features.features()[row]);
  }
  const std::string what = choice.options.criterion == SelectionCriterion::kTrace
                               ? "1 / sum of 1/sigma^2"
                               : NameOf(choice.options.criterion);
  return text + "  " + names + "\n  " + what + " " + Short(selection.value) +
         " (all features: " + Short(selection.value_of_all) + "); " +
         (selection.exhaustive ? "the best of all " + std::to_string(selection.sets) + " sets"
                               : "by exchange, " + std::to_string(selection.sets) + " sets tried") +
         "\n";
}

const char* Explanation(LowCause cause) {
  switch (cause) {
    case LowCause::kNone:
      return "w_c is not low";
    case LowCause::kView:
      return "the view hides a motion: a camera move can help";
    case LowCause::kArm:
      return "the joints hardly move the points that way: no camera move can help";
    case LowCause::kFeatures:
      return "too few feature rows are seen";
  }
  return "";
}

std::string Conclusions(const MeasureSetup& setup, const MeasureReport& report) {
  const Measurement& m = report.measurement;
  std::string text;
  const auto line = [&](const std::string& what, const std::string& value) {
    text += "  " + what + std::string(what.size() < 26 ? 26 - what.size() : 1, ' ') + value + "\n";
  };
  line("cause", std::string(Name(m.cause)) + ": " + Explanation(m.cause) +
                    (setup.threshold > 0.0
                         ? " (w_c^(1/s) counts as low below " + Short(setup.threshold) + ")"
                         : ""));
  line("w_c / (w_v w_r)", Short(m.coupling.ratio));
  line("motion per feature error", "by J_v " + BoundsText(m.view, m.J_v.rows(), m.J_v.cols()) +
                                       ", by J_c " +
                                       BoundsText(m.composite, m.J_c.rows(), m.J_c.cols()));
  const double length = CharacteristicLength(m.J_r);
  line("twists as (v, " + Short(length) + " m w)",
       "w_v " + Short(MeasureOf(ScaleTwistOfImage(m.J_v, length)).w) + ", w_r " +
           Short(MeasureOf(ScaleTwistOfArm(m.J_r, length)).w));
  if (report.whitened) {
    line("whitened features",
         "w_v " + Short(report.whitened->view.w) + ", w_c " + Short(report.whitened->composite.w));
  }
  if (m.mm_per_px) {
    line("one pixel may hide",
         std::isfinite(*m.mm_per_px) ? Short(*m.mm_per_px) + " mm" : "any motion");
  }
  if (m.translation) {
    line("translation alone", "w_v " + Short(m.translation->view.w) + ", w_r " +
                                  Short(m.translation->arm.w) + ", paper product " +
                                  Short(m.translation->product) +
                                  (m.translation->exact ? " (is w_c)" : " (is not w_c)"));
  }
  return text;
}

}  // namespace

std::string ToJson(const MeasureSetup& setup, const MeasureReport& report) {
  const Measurement& m = report.measurement;
  Json json;
  json["name"] = setup.name;
  json["robot"] = setup.arm.name();
  json["q"] = List(setup.q);
  json["camera_pose"] = Rows(m.X_WC.matrix());
  json["points"] = PointsJson(setup, m);
  json["features"] = FeaturesJson(setup, m);
  json["features_missing"] = MissingFeaturesJson(setup, m);
  json["J_v"] = Rows(m.J_v);
  json["J_r"] = Rows(m.J_r);
  json["J_c"] = Rows(m.J_c);
  json["singular_values_v"] = List(m.view.measure.sigma);
  json["singular_values_r"] = List(m.arm.measure.sigma);
  json["singular_values_c"] = List(m.composite.measure.sigma);
  json["status_v"] = Name(m.view.measure.status);
  json["status_r"] = Name(m.arm.measure.status);
  json["status_c"] = Name(m.composite.measure.status);
  json["w_v"] = m.view.measure.w;
  json["w_r"] = m.arm.measure.w;
  json["w_c"] = m.composite.measure.w;
  json["log_w_v"] = Number(m.view.measure.log_w);
  json["log_w_r"] = Number(m.arm.measure.log_w);
  json["log_w_c"] = Number(m.composite.measure.log_w);
  json["rank_v"] = m.view.measure.rank;
  json["rank_r"] = m.arm.measure.rank;
  json["rank_c"] = m.composite.measure.rank;
  json["sigma_min_c"] = m.composite.measure.sigma_min;
  json["condition_c"] = Number(m.composite.measure.condition);
  json["geometric_mean_c"] = m.composite.measure.geometric_mean();
  json["inverse_trace_c"] = Number(m.composite.measure.inverse_trace());
  json["cause"] = Name(m.cause);
  json["coupling"] = {{"ratio", Number(m.coupling.ratio)}, {"horn", Number(m.coupling.horn)}};
  json["ellipsoid"] = EllipsoidJson(m.composite);
  json["ellipsoid_v"] = EllipsoidJson(m.view);
  json["error_bounds_v"] = BoundsJson(m.view, m.J_v.rows(), m.J_v.cols());
  json["error_bounds_c"] = BoundsJson(m.composite, m.J_c.rows(), m.J_c.cols());
  json["visible"] = std::all_of(m.faults.begin(), m.faults.end(),
                                [](ViewFault fault) { return fault == ViewFault::kNone; });
  json["gradient_v"] = GradientsJson(setup, report.gradients.view, m.view.measure.w);
  json["gradient_c"] = GradientsJson(setup, report.gradients.composite, m.composite.measure.w);
  json["scaled_twist"] = ScaledTwistJson(m);
  json["whitened"] = WhitenedJson(report.whitened);
  json["mm_per_px"] = m.mm_per_px ? Number(*m.mm_per_px) : Json(nullptr);
  if (m.translation) {
    json["translation"] = {{"w_v", m.translation->view.w},
                           {"w_r", m.translation->arm.w},
                           {"paper_product", m.translation->product},
                           {"exact", m.translation->exact}};
  }
  if (report.choice) json["selection"] = ChoiceJson(setup, *report.choice);
  return json.dump(2) + "\n";
}

std::string ToTable(const MeasureSetup& setup, const MeasureReport& report) {
  const Measurement& m = report.measurement;
  const Cells names = FeatureNames(setup, m);
  const Cells twist(std::begin(kTwistNames), std::end(kTwistNames));
  const std::string unit = setup.pixels ? "px" : "units of f";
  std::string text =
      setup.name + (setup.description.empty() ? "" : ": " + setup.description) + "\n";
  text += "  arm     " + setup.arm.name() + ": " + JointsText(setup) + "\n";
  const Eigen::Isometry3d& X_WE = m.kinematics.X_WE;
  text += "  E       at " + Triple(X_WE.translation()) + " m, z axis " +
          Triple(X_WE.linear().col(2)) + "\n";
  text += "  camera  " + CameraText(setup, m) + "\n\n";
  text += PointsTable(setup, m) + MissingFeaturesText(setup, m) + "\n";
  if (m.rows.size() == 0) {
    text += "No feature is seen: J_v and J_c have no rows.\n\n";
  } else {
    text += MatrixTable(
        "J_v: features by the end effector's twist in world axes [" + unit + " per m, per rad]",
        names, twist, m.J_v);
  }
  text += MatrixTable("J_r: that twist by the joints [m, rad per rad or m]", twist,
                      setup.arm.joint_names(), m.J_r);
  if (m.rows.size() > 0) {
    text += MatrixTable("J_c = J_v J_r: features by the joints [" + unit + " per rad or m]", names,
                        setup.arm.joint_names(), m.J_c);
  }
  text += MeasuresTable(m) + "\n" + EllipsoidTable(names, m);
  text += GradientsTable(setup, report) + "\n";
  if (report.choice) text += ChoiceTable(setup, *report.choice) + "\n";
  text += "Verdict\n" + Conclusions(setup, report);
  return text;
}

}  // namespace vantage
