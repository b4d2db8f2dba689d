#include "plan_print.h"

#include <algorithm>
#include <cmath>

#include "vantage/math/angles.h"
#include "vantage/math/format.h"

namespace vantage {
namespace {

const char* MeasureName(BatchMeasure measure) {
  switch (measure) {
    case BatchMeasure::kW:
      return "w";
    case BatchMeasure::kLogW:
      return "log w";
    case BatchMeasure::kSigmaMin:
      return "sigma_min";
    case BatchMeasure::kInverseCondition:
      return "1/condition";
    case BatchMeasure::kNegativeTrace:
      break;
  }
  return "-sum 1/sigma^2";
}

// Least and greatest w^(1/s) along the motion.
std::pair<double, double> GeometricMeans(const PlacementModel& model, const PlacedCamera& camera) {
  BatchProfile profile;
  BatchEvaluator().Profile(model.scene(), camera.X_WC, 1.0, model.problem().lens, false, &profile);
  const auto [low, high] = std::minmax_element(profile.w.begin(), profile.w.end());
  const double power = 1.0 / model.scene().rank();
  return {std::pow(*low, power), std::pow(*high, power)};
}

std::string CameraLine(const PlacementSetup& setup, const PlacementModel& model, const char* name,
                       const PlacedCamera& camera) {
  std::string line = Format("  %-13s %-12.6g", name, camera.value);
  const PlanQuantity quantity = setup.problem.objective.quantity;
  if (quantity == PlanQuantity::kComposite || quantity == PlanQuantity::kView) {
    const auto [low, high] = GeometricMeans(model, camera);
    line += Format(" %9.4g to %-9.4g", low, high);
  } else {
    line += Format(" %-22s", "");
  }
  return line + " " + CoordinatesText(setup.problem.rig, camera.q_c) +
         (camera.feasible ? "" : "  (breaks a limit)") + "\n";
}

}  // namespace

PlanProgressBar::PlanProgressBar(bool quiet) : bar_(quiet) {}

void PlanProgressBar::operator()(const std::string& stage, double share,
                                 const std::optional<double>& best) {
  if (best && (!best_ || *best > *best_)) best_ = best;
  if (share < share_) bar_.Restart();
  share_ = share;
  bar_.Show(share, stage + (best_ ? Format(", best %.6g", *best_) : ", no camera yet"));
}

void PlanProgressBar::End() {
  bar_.End();
}

std::string CoordinatesText(const CameraRig& rig, const RigVector& q_c) {
  std::string text;
  for (int i = 0; i < rig.size(); ++i) {
    const bool turns = AxisTurns(rig, i);
    text += Format("%s%s %.6g %s", i > 0 ? ", " : "", rig.axes[i].name.c_str(),
                   q_c(i) * (turns ? kDegreesPerRadian : 1.0), turns ? "deg" : "m");
  }
  return text.empty() ? "a fixed camera" : text;
}

std::string ObjectiveText(const PlacementProblem& problem) {
  const PlanObjective& o = problem.objective;
  const std::string measure = MeasureName(o.measure);
  std::string what;
  switch (o.quantity) {
    case PlanQuantity::kComposite:
      what = measure + " of J_c";
      break;
    case PlanQuantity::kView:
      what = measure + " of J_v";
      break;
    case PlanQuantity::kWeightedSum:
      what = Format("%.4g %s_v + %.4g %s_r", o.k_v, measure.c_str(), o.k_r, measure.c_str());
      break;
    case PlanQuantity::kProduct:
      what = o.measure == BatchMeasure::kW ? "w_v w_r" : "log w_v + log w_r";
      break;
  }
  const char* equation = "(eq. 16)";
  if (o.aggregate == PlanAggregate::kIntegral) {
    equation = o.quantity == PlanQuantity::kComposite ? "(eq. 14)"
               : o.quantity == PlanQuantity::kView    ? "(eq. 13)"
                                                      : "(eq. 23)";
  }
  const ArmMotion& motion = problem.motion;
  return (o.aggregate == PlanAggregate::kWorst ? "the least " : "the integral of ") + what +
         Format(" over a motion of %.4g s, %d samples ", motion.time.back(), motion.size()) +
         equation;
}

std::string ResultText(const PlacementSetup& setup, const PlacementModel& model,
                       const PlacementResult& result, double seconds) {
  const PlacementProblem& problem = setup.problem;
  std::string text = "makes great " + ObjectiveText(problem) + "\n";
  const std::string range = Format("w^(1/s) [%s/rad]", setup.pixels ? "px" : "1");
  text += Format("  %-13s %-12s %-22s %s\n", "camera", "value", range.c_str(), "rig");
  text += CameraLine(setup, model, "best", result.best);
  text += CameraLine(setup, model, "start", result.start);
  text += CameraLine(setup, model, "worst of grid", result.worst);
  const Eigen::Vector3d p = result.best.X_WC.translation();
  const Eigen::Vector3d axis = result.best.X_WC.linear().col(2);
  text += Format("the best stands at (%.4f, %.4f, %.4f) m and looks along (%.4f, %.4f, %.4f)\n",
                 p.x(), p.y(), p.z(), axis.x(), axis.y(), axis.z());
  text += "held back by: ";
  for (std::size_t i = 0; i < result.active.size(); ++i) {
    text += (i > 0 ? "; " : "") + result.active[i].name;
  }
  if (result.active.empty()) text += "nothing, the optimum is inside";
  text += "\nother margins: ";
  bool first = true;
  for (int i = 0; i < kPlanLimits; ++i) {
    const double margin = result.best.margins[i];
    if (!std::isfinite(margin) || margin > 1e5 || margin < 1e-6 * model.unit()) continue;
    text += Format("%s%s %.3g m", first ? "" : "; ",
                   model.NameOf(static_cast<PlanLimit>(i)).c_str(), margin);
    first = false;
  }
  if (first) text += "none";
  text +=
      Format("\nsearch: %lld cameras, %.3g million Jacobians, %.3g ms (%s)\n",
             static_cast<long long>(result.cameras), 1e-6 * static_cast<double>(result.evaluations),
             1e3 * seconds, Name(BatchEvaluator().isa()).c_str());
  switch (result.warning.kind) {
    case WorstCaseWarning::Kind::kNone:
      break;
    case WorstCaseWarning::Kind::kChangesSign:
      text += Format(
          "warning: det J_c changes its sign between samples %d and %d (t = %.4g s): the least w_c "
          "of the motion is 0 there,\n  whatever the samples say. Ask for the integral, or for "
          "sigma_min of more features than joints.\n",
          result.warning.sample, result.warning.sample + 1, result.warning.time);
      break;
    case WorstCaseWarning::Kind::kArmSingular:
      text += Format(
          "warning: at sample %d (t = %.4g s) the Jacobian loses rank for every camera: the least "
          "value is 0 for all of them.\n  The arm is singular there; no camera can help.\n",
          result.warning.sample + 1, result.warning.time);
      break;
  }
  return text;
}

std::string InfeasibleText(const PlacementSetup& setup, const PlacementResult& result) {
  std::string text = "infeasible: no camera of the rig keeps all limits\n";
  text += "the nearest to it: " + CoordinatesText(setup.problem.rig, result.best.q_c) + "\n";
  bool one = false;
  for (const LimitDiagnosis& d : result.diagnosis) {
    if (d.best_margin < 0.0) {
      text += Format(
          "  %s: cannot be kept by any camera tried, even alone: the best is short by "
          "%.3g m\n",
          d.name.c_str(), -d.best_margin);
      one = true;
    } else {
      text += Format(
          "  %s: short by %.3g m at the nearest camera%s\n", d.name.c_str(), -d.margin_at_nearest,
          d.alone_prevents ? "; without this limit there are cameras that keep the rest" : "");
    }
  }
  if (!one) text += "each limit can be kept by itself; it is keeping them together that fails\n";
  return text;
}

std::string PathText(const PlacementModel& model, const CameraPathResult& result, double seconds) {
  std::string text = Format("camera path (eq. 15): value %.6g", result.path.value);
  if (result.fixed.broken == 0) {
    text += Format(", %.3g times that of the best camera that stands still",
                   result.path.value / result.fixed.value);
  }
  text += result.path.broken > 0 ? Format("; limits are broken at %d of %d samples\n",
                                          result.path.broken, model.problem().motion.size())
                                 : "; all limits and speeds are kept\n";
  return text + Format("  %.3g million Jacobians, %.3g ms\n",
                       1e-6 * static_cast<double>(result.evaluations), 1e3 * seconds);
}

std::string GridPartText(const PlacementModel& model, const Shard& shard,
                         const SearchedGrid& grid) {
  const std::string part = Format("part %d of %d of a grid of %lld cameras: ", shard.index,
                                  shard.count, static_cast<long long>(grid.cameras));
  const std::optional<double> best = grid.best.ValueOfBest(model);
  return part + (best ? Format("the best is worth %.8g\n", *best) : "none keeps all limits\n");
}

std::string GridCheckText(const GridCheck& check) {
  if (!check.best.feasible) {
    return Format("grid check: none of %lld cameras keeps all limits\n",
                  static_cast<long long>(check.cameras));
  }
  // Both are polished to some 1e-9.
  constexpr double kSame = 1e-6;
  const char* verdict = check.gap > kSame ? "the result is WORSE" : "the result is no worse";
  return Format(
      "grid check: the best of %lld cameras is worth %.8g, polished %.8g; %s (gap %.1e)\n",
      static_cast<long long>(check.cameras), check.best_on_grid, check.best.value, verdict,
      check.gap);
}

}  // namespace vantage
