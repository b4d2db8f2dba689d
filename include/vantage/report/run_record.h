#pragma once

#include <optional>
#include <string>
#include <vector>

#include "vantage/servo/servo_report.h"

/// @file
/// What a run leaves behind for people: a table of samples, a picture of them, a summary.

namespace vantage {

/// One line of a run, on the run's own time axis.
struct RunSample {
  double t{0.0};                         ///< Since the start of the run [s].
  ServoState state{ServoState::kIdle};   ///< What the servo was doing.
  HoldReason reason{HoldReason::kNone};  ///< Why it holds, if it does.
  double error_px{0.0};                  ///< Root mean square error of the feature rows [px].
  double w_v{0.0};                       ///< Observability, of J_v, as in ObservabilityReport.
  double w_r{0.0};                       ///< Manipulability, of J_r, as there.
  double w_c{0.0};                       ///< Composite, of J_c [px^s/rad^s].
  double sigma_min{0.0};                 ///< Smallest singular value of J_c that counts [px/rad].
  double trigger_value{0.0};             ///< What the trigger compares, in its measure's unit.
  double threshold{0.0};                 ///< Below it the camera is to move, in the same unit.
  double mm_per_px{0.0};      ///< Worst motion of a marker that one pixel may hide [mm/px].
  bool camera_moving{false};  ///< On its way to a better view.
  std::optional<double> true_error_mm;  ///< Worst marker's distance to its goal, from a simulator.
};

/// The sample of what a servo says at time t.
[[nodiscard]] RunSample MakeSample(double t, const ServoStatus& status,
                                   const ObservabilityReport& observability);

/// How a run ended.
struct RunSummary {
  std::string scenario;   ///< Its name, as in Scenario.
  std::string camera;     ///< "active" or "fixed".
  bool converged{false};  ///< Converged, and stayed so for a while.
  /// "converged", "time limit", "stopped by the user", or which process ended and how.
  std::string end;
  double duration{0.0};                 ///< [s].
  double time_to_converge{0.0};         ///< [s]; duration when it did not.
  ServoStatus status;                   ///< The last one.
  ObservabilityReport observability;    ///< The last one.
  std::optional<double> true_error_mm;  ///< At the end.
  /// Of all samples, in the measure's unit; inf: there was none.
  double lowest_trigger_value{0.0};
  std::int64_t camera_moves{0};      ///< Moves of the active camera begun.
  std::int64_t limit_violations{0};  ///< As the simulator's monitor counted them.
};

/// Comma-separated samples with a header line that names columns and units.
/// Throws Error when the file cannot be written.
void WriteSamples(const std::vector<RunSample>& samples, const std::string& path);

/// The summary as JSON with stable keys. Throws Error when the file cannot be written.
void WriteSummary(const RunSummary& summary, const std::string& path);

/// Picture of error and measures over time: folder/run.png from folder/samples.csv, with the gnuplot
/// script left beside it. Throws Error as RunGnuplot() does.
void PlotRun(const RunSummary& summary, const std::vector<RunSample>& samples,
             const std::string& folder);

}  // namespace vantage
