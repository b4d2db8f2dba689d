#include "vantage/report/run_record.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iomanip>

#include <nlohmann/json.hpp>

#include "measure_label.h"
#include "vantage/math/error.h"
#include "vantage/math/format.h"
#include "vantage/report/gnuplot.h"

namespace vantage {
namespace {

std::ofstream Open(const std::string& path) {
  std::ofstream file(path);
  if (!file) throw WriteError(path);
  return file;
}

void Close(std::ofstream* file, const std::string& path) {
  file->flush();
  if (!*file) throw WriteError(path);
}

// JSON has no infinity: what is not finite becomes null.
nlohmann::ordered_json Number(double value) {
  if (!std::isfinite(value)) return nullptr;
  return value;
}

// Whether there is a point to draw on a logarithmic axis: gnuplot refuses a plot without any.
template <typename Get>
bool Drawable(const std::vector<RunSample>& samples, Get&& get) {
  return std::any_of(samples.begin(), samples.end(), [&](const RunSample& sample) {
    return std::isfinite(get(sample)) && get(sample) > 0.0;
  });
}

// "plot ", or the same for data without a point.
std::string Plot(bool drawable, const char* what) {
  if (drawable) return "plot ";
  return std::string("set label 1 '") + what +
         "' at graph 0.5,0.5 center\nplot [][0.1:10] NaN notitle, ";
}

// Grey bands where the camera moves.
void WriteBands(const std::vector<RunSample>& samples, std::ofstream* script) {
  int object = 1;
  std::optional<double> start;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const bool last = i + 1 == samples.size();
    if (samples[i].camera_moving && !start) start = samples[i].t;
    if (start && (!samples[i].camera_moving || last)) {
      *script << "set object " << object++ << " rectangle from first " << *start
              << ", graph 0 to first " << samples[i].t
              << ", graph 1 behind fillcolor rgb '#dce9f7' fillstyle solid 1.0 noborder\n";
      start.reset();
    }
  }
}

}  // namespace

RunSample MakeSample(double t, const ServoStatus& status,
                     const ObservabilityReport& observability) {
  RunSample sample;
  sample.t = t;
  sample.state = status.state;
  sample.reason = status.reason;
  sample.error_px = status.error_px;
  sample.w_v = observability.w_v;
  sample.w_r = observability.w_r;
  sample.w_c = observability.w_c;
  sample.sigma_min = observability.composite.sigma_min;
  sample.trigger_value = observability.trigger_value;
  sample.threshold = observability.threshold;
  sample.mm_per_px = observability.mm_per_px;
  sample.camera_moving = observability.active_state == ActiveState::kMoving;
  return sample;
}

void WriteSamples(const std::vector<RunSample>& samples, const std::string& path) {
  std::ofstream file = Open(path);
  file << "t [s],state,reason,error [px],w_v,w_r,w_c,sigma_min_c [px/rad],trigger value,threshold,"
          "hidden motion [mm/px],camera moving,true error [mm]\n"
       << std::setprecision(9);
  for (const RunSample& s : samples) {
    file << s.t << ',' << Name(s.state) << ',' << Name(s.reason) << ',' << s.error_px << ','
         << s.w_v << ',' << s.w_r << ',' << s.w_c << ',' << s.sigma_min << ',' << s.trigger_value
         << ',' << s.threshold << ',' << s.mm_per_px << ',' << (s.camera_moving ? 1 : 0) << ',';
    if (s.true_error_mm) file << *s.true_error_mm;
    file << '\n';
  }
  Close(&file, path);
}

void WriteSummary(const RunSummary& summary, const std::string& path) {
  nlohmann::ordered_json json;
  json["scenario"] = summary.scenario;
  json["camera"] = summary.camera;
  json["converged"] = summary.converged;
  json["end"] = summary.end;
  json["duration_s"] = summary.duration;
  json["time_to_converge_s"] = summary.converged ? Number(summary.time_to_converge) : nullptr;
  json["final_state"] = Name(summary.status.state);
  json["final_reason"] = Name(summary.status.reason);
  json["final_error_px"] = Number(summary.status.error_px);
  json["final_true_error_mm"] = summary.true_error_mm ? Number(*summary.true_error_mm) : nullptr;
  json["final_mm_per_px"] = Number(summary.observability.mm_per_px);
  json["w_v"] = Number(summary.observability.w_v);
  json["w_r"] = Number(summary.observability.w_r);
  json["w_c"] = Number(summary.observability.w_c);
  json["trigger_value"] = Number(summary.observability.trigger_value);
  json["trigger_threshold"] = Number(summary.observability.threshold);
  json["lowest_trigger_value"] = Number(summary.lowest_trigger_value);
  json["camera_moves"] = summary.camera_moves;
  json["stops"] = summary.status.stops;
  for (int i = 1; i < kNumHoldReasons; ++i) {
    json["stops_by_reason"][Name(static_cast<HoldReason>(i))] =
        summary.status.stops_by[static_cast<std::size_t>(i)];
  }
  const CalibrationFound& found = summary.status.calibration;
  json["calibration_found"] = {{"position_m", Number(found.position)},
                               {"rotation_rad", Number(found.rotation)},
                               {"focal_share", Number(found.focal)},
                               {"revolute_rad", Number(found.revolute)},
                               {"prismatic_m", Number(found.prismatic)}};
  json["control_periods"] = summary.status.seq;
  json["deadline_misses"] = summary.status.deadline_misses;
  json["loop_time_p50_us"] = Number(summary.status.loop_time_p50_us);
  json["loop_time_p99_us"] = Number(summary.status.loop_time_p99_us);
  json["loop_time_p999_us"] = Number(summary.status.loop_time_p999_us);
  json["loop_time_max_us"] = Number(summary.status.loop_time_max_us);
  json["lateness_p999_us"] = Number(summary.status.lateness_p999_us);
  json["lateness_max_us"] = Number(summary.status.lateness_max_us);
  json["refused_messages"] = summary.status.refused_messages;
  for (int i = 0; i < kNumInputFaults; ++i) {
    json["refused_by_reason"][Name(static_cast<InputFault>(i))] =
        summary.status.refused_by[static_cast<std::size_t>(i)];
  }
  json["dropped_messages"] = summary.status.dropped_messages;
  json["limit_violations"] = summary.limit_violations;
  std::ofstream file = Open(path);
  file << json.dump(2) << '\n';
  Close(&file, path);
}

void PlotRun(const RunSummary& summary, const std::vector<RunSample>& samples,
             const std::string& folder) {
  if (!Drawable(samples, [](const RunSample& s) { return s.error_px; })) {
    throw Error("nothing was measured that could be drawn");
  }
  const std::string duration = Format("%.1f s", summary.duration);
  const std::string path = folder + "/run.gp";
  std::ofstream script = Open(path);
  script << "set encoding utf8\n"
            "set terminal pngcairo size 1200,1280 font 'DejaVu Sans,11'\n"
            "set output 'run.png'\n"
            "set datafile separator ','\n"
            "set grid linecolor rgb '#e4e4e4'\n"
            "set key top right\n"
            "set multiplot layout 4,1 title "
         << GnuplotString(GnuplotLiteral(summary.scenario + ", camera " + summary.camera + ": " +
                                         summary.end + " after " + duration))
         << "\n";
  WriteBands(samples, &script);
  const bool truth =
      Drawable(samples, [](const RunSample& s) { return s.true_error_mm.value_or(0.0); });
  const bool measures = Drawable(samples, [](const RunSample& s) {
    return std::max({s.w_v, s.w_r, s.w_c});
  });
  const bool bounded = Drawable(samples, [](const RunSample& s) { return s.mm_per_px; });
  const double threshold = samples.back().threshold;
  double ceiling = threshold;
  for (const RunSample& sample : samples) ceiling = std::max(ceiling, sample.trigger_value);
  ceiling = ceiling > 0.0 ? 1.1 * ceiling : 1.0;
  script << "set xrange [0:" << std::max(0.1, samples.back().t)
         << "]\nset lmargin 11\nset rmargin 11\nset logscale y\nset format y '10^{%L}'\n"
            "set ylabel 'image error [px]'\n";
  if (truth)
    script << "set y2label 'true error [mm]'\nset y2tics\nset ytics nomirror\nset logscale y2\nset "
              "format y2 '10^{%L}'\n";
  script << "plot 'samples.csv' using 1:4 every ::1 with lines lw 2 lc rgb '#1f4e9c' title 'image "
            "error (rms)'";
  if (truth) {
    script << ", '' using 1:13 every ::1 axes x1y2 with lines lw 2 lc rgb '#c2410c' title 'true "
              "error of the worst marker'";
  }
  script << "\nunset y2label\nunset y2tics\nset ytics mirror\n"
            "unset logscale y\nset format y '%g'\n"
         << "set key bottom right\nset yrange [0:" << ceiling << "]\n"
         << "set ylabel '" << MeasureLabel(summary.observability.trigger_measure) << "'\n"
         << "plot 'samples.csv' using 1:9 every ::1 with lines lw 2 lc rgb '#15803d' title "
            "'trigger value', "
         << threshold
         << " with lines dashtype 2 lc rgb '#b91c1c' title 'threshold (camera moves below it)'\n"
            "set key center right\nset autoscale y\n"
            "set logscale y\nset format y '10^{%L}'\nset ylabel 'measures'\n"
         << Plot(measures, "all measures are zero")
         << "'samples.csv' using 1:5 every ::1 with lines lw 2 title 'w_v', "
            "'' using 1:6 every ::1 with lines lw 2 title 'w_r', "
            "'' using 1:7 every ::1 with lines lw 2 title 'w_c'\n"
            "set key top right\nset ylabel 'hidden motion [mm/px]'\nset xlabel 'time [s]'\n"
            "unset label 1\n"
         << Plot(bounded, "one pixel may hide any motion, throughout")
         << "'samples.csv' using 1:11 every ::1 with lines lw 2 lc rgb '#7c3aed' title 'one "
            "pixel may hide'\n"
            "unset multiplot\n";
  Close(&script, path);
  script.close();
  RunGnuplot(path);
}

}  // namespace vantage
