#include "plan_result.h"

#include <cmath>
#include <fstream>

#include "plan_print.h"
#include "vantage/config/camera_plan_file.h"
#include "vantage/math/error.h"
#include "vantage/math/format.h"

namespace vantage {
namespace {

std::string Exact(double value) {
  if (std::isinf(value)) return value > 0.0 ? ".inf" : "-.inf";
  return ExactText(value);
}

std::string List(const Eigen::VectorXd& values) {
  std::string text = "[";
  for (Eigen::Index i = 0; i < values.size(); ++i) text += (i > 0 ? ", " : "") + Exact(values(i));
  return text + "]";
}

std::string Margins(const PlacementModel& model, const PlacedCamera& camera) {
  std::string text = "{";
  for (int i = 0; i < kPlanLimits; ++i) {
    if (!std::isfinite(camera.margins[i])) continue;
    text += (text.size() > 1 ? ", " : "") + model.NameOf(static_cast<PlanLimit>(i)) + ": " +
            Exact(camera.margins[i]);
  }
  // Commas part entries here.
  return text + "}";
}

}  // namespace

void WritePlacementResult(const std::string& path, const PlacementSetup& setup,
                          const PlacementModel& model, const PlacementResult& result,
                          double seconds, const std::optional<GridCheck>& check) {
  std::ofstream out(path);
  const PlacedCamera& best = result.best;
  const Eigen::Quaterniond q(best.X_WC.linear());
  out << "# Written by vantage-plan for " << setup.name << ": " << setup.description << "\n"
      << "# Makes great " << ObjectiveText(setup.problem) << ".\n"
      << "problem: " << setup.name << "\n";
  if (!setup.scenario.empty()) out << "scenario: " << setup.scenario << "\n";
  out << CameraStartText(setup.problem.rig, best.q_c)
      << "pose: {position: " << List(best.X_WC.translation())
      << ", quaternion: " << List(Eigen::Vector4d(q.w(), q.x(), q.y(), q.z())) << "}\n"
      << "value: " << Exact(best.value) << "\n"
      << "value_at_start: " << Exact(result.start.value) << "\n"
      << "certificate:\n"
      << "  feasible: " << (best.feasible ? "true" : "false") << "\n"
      << "  margins_m: " << Margins(model, best) << "\n"
      << "  active: [";
  for (std::size_t i = 0; i < result.active.size(); ++i) {
    out << (i > 0 ? ", " : "") << '"' << result.active[i].name << '"';
  }
  out << "]\n"
      << "  cameras: " << result.cameras << "\n"
      << "  jacobians: " << result.evaluations << "\n"
      << "  seconds: " << Exact(seconds) << "\n";
  if (check) {
    out << "  grid_check: {cameras: " << check->cameras
        << ", best_on_grid: " << Exact(check->best_on_grid)
        << ", polished: " << Exact(check->best.feasible ? check->best.value : -INFINITY)
        << ", gap: " << Exact(check->gap) << "}\n";
  }
  if (result.warning.kind != WorstCaseWarning::Kind::kNone) {
    out << "  least_value_is_zero_near_sample: " << result.warning.sample + 1 << "\n";
  }
  out.close();
  if (!out) throw WriteError(path);
}

void WriteCameraPath(const std::string& path, const PlacementSetup& setup,
                     const CameraPath& camera) {
  std::ofstream out(path);
  const CameraRig& rig = setup.problem.rig;
  out << "time";
  for (int i = 0; i < rig.size(); ++i) {
    out << ',' << rig.axes[i].name << (AxisTurns(rig, i) ? " [rad]" : " [m]");
  }
  out << ",x [m],y [m],z [m]";
  for (const std::string& joint : setup.view.arm.joint_names()) out << ',' << joint;
  out << '\n';
  const ArmMotion& motion = setup.problem.motion;
  for (int i = 0; i < motion.size(); ++i) {
    out << Exact(motion.time[i]);
    for (const double q : camera.q_c[i]) out << ',' << Exact(q);
    const Eigen::Vector3d p_WC = RigPose(rig, camera.q_c[i]).translation();
    for (const double p : p_WC) out << ',' << Exact(p);
    for (const double q : motion.samples[i].q) out << ',' << Exact(q);
    out << '\n';
  }
  out.close();
  if (!out) throw WriteError(path);
}

}  // namespace vantage
