#include "run_console.h"

#include <cmath>
#include <iostream>

#include <unistd.h>

#include "vantage/math/format.h"

namespace vantage {
namespace {

constexpr double kTerminalStep = 0.5;  // [s] between lines that stay
constexpr double kPlainStep = 1.0;

// At most six characters for any positive number.
std::string Short(double value) {
  if (!std::isfinite(value)) return "inf";
  if (value != 0.0 && (value >= 1e5 || value < 1e-2)) return Format("%.1e", value);
  return Format(value < 10.0 ? "%.3f" : "%.1f", value);
}

}  // namespace

RunConsole::RunConsole(bool quiet) : quiet_(quiet), terminal_(isatty(STDOUT_FILENO) != 0) {}

void RunConsole::Line(const std::string& text, bool keep) {
  if (quiet_) return;
  if (open_line_) std::cout << "\r\033[K";
  std::cout << text;
  open_line_ = !keep;
  if (keep) std::cout << '\n';
  std::cout << std::flush;
}

void RunConsole::Note(const std::string& text) {
  Line(text, true);
}

void RunConsole::Titles(TriggerMeasure measure) {
  Line(Format("%6s  %-13s %9s %8s %8s %8s  %9s / %-6s %8s  %s", "t [s]", "state", "error px", "w_v",
              "w_r", "w_c", Name(measure), "thresh", "mm/px", "camera"),
       true);
  titled_ = true;
}

void RunConsole::Show(const RunSample& sample, const ObservabilityReport& observability,
                      const ServoStatus& status) {
  if (!titled_) Titles(observability.trigger_measure);
  const bool keep = sample.t >= next_line_;
  if (!keep && !terminal_) return;
  if (keep) {
    const double step = terminal_ ? kTerminalStep : kPlainStep;
    next_line_ = step * (std::floor(sample.t / step) + 1.0);
  }
  std::string camera = Name(observability.active_state);
  if (observability.active_state == ActiveState::kMoving) {
    camera += std::string(" ") + Name(observability.active_reason);
  } else if (sample.trigger_value < sample.threshold) {
    camera += std::string(" (low: ") + Name(observability.cause) + ")";
  }
  if (status.reason != HoldReason::kNone) camera += std::string("; arm: ") + Name(status.reason);
  Line(Format("%6.2f  %-13s %9s %8s %8s %8s  %9s / %-6s %8s  %s", sample.t, Name(status.state),
              Short(sample.error_px).c_str(), Short(sample.w_v).c_str(), Short(sample.w_r).c_str(),
              Short(sample.w_c).c_str(), Short(sample.trigger_value).c_str(),
              Short(sample.threshold).c_str(), Short(sample.mm_per_px).c_str(), camera.c_str()),
       keep);
}

void RunConsole::End(const RunSummary& summary, const std::string& folder) {
  if (open_line_) Line("", true);
  std::string text =
      summary.converged ? "converged after " : "NOT converged: " + summary.end + " after ";
  text +=
      Format("%.2f s: error ", summary.converged ? summary.time_to_converge : summary.duration) +
      Short(summary.status.error_px) + " px";
  if (summary.true_error_mm) text += ", true error " + Short(*summary.true_error_mm) + " mm";
  text += ", " + std::to_string(summary.camera_moves) + " camera moves";
  if (std::isfinite(summary.lowest_trigger_value)) {
    text += Format(", lowest trigger value %.1f", summary.lowest_trigger_value);
  }
  Line(text, true);
  if (!summary.converged && summary.status.reason != HoldReason::kNone) {
    Line(std::string("the servo ended in ") + Name(summary.status.state) + " because of " +
             Name(summary.status.reason),
         true);
  } else if (!summary.converged && summary.observability.k > 0 && summary.status.error_px < 1.0) {
    const double hidden = summary.observability.mm_per_px;
    Line("the error in the image is small, but one pixel may hide " +
             (std::isfinite(hidden) ? Short(hidden) + " mm" : "any motion") +
             " in this view: it certifies nothing",
         true);
  }
  // In simulated time nothing is late.
  const bool timed = summary.status.loop_time_max_us > 0.0;
  Line("loop: " + std::to_string(summary.status.seq) + " periods" +
           (timed ? ", " + std::to_string(summary.status.deadline_misses) + " late, p99.9 " +
                        Short(summary.status.loop_time_p999_us) + " us, longest " +
                        Short(summary.status.loop_time_max_us) + " us"
                  : "") +
           "; stops: " + DescribeStops(summary.status) + "; " +
           std::to_string(summary.limit_violations) + " limit violations",
       true);
  if (!summary.status.calibration.none()) {
    Line("calibration found: " + Describe(summary.status.calibration), true);
  }
  if (!folder.empty()) Line("wrote " + folder, true);
}

}  // namespace vantage
