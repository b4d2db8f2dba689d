#include "watch_view.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "vantage/math/angles.h"
#include "vantage/math/format.h"

namespace vantage {
namespace {

constexpr Duration kStale = std::chrono::milliseconds(500);
constexpr int kLabel = 14;
constexpr int kNumber = 12;

std::string Number(double value) {
  if (std::isnan(value)) return "-";
  if (std::isinf(value)) return value > 0.0 ? "inf" : "-inf";
  const double size = std::abs(value);
  if (value != 0.0 && (size >= 1e6 || size < 1e-3)) return Format("%.2e", value);
  return Format(size < 10.0 ? "%.3f" : "%.1f", value);
}

std::string Padded(const std::string& text, int cells, bool right = false) {
  const int missing = std::max(0, cells - CellsOf(text));
  const std::string blanks(static_cast<std::size_t>(missing), ' ');
  return right ? blanks + text : text + blanks;
}

std::string Repeated(const char* text, int times) {
  std::string all;
  for (int i = 0; i < times; ++i) all += text;
  return all;
}

// The first `cells` characters.
std::string Cut(const std::string& text, int cells) {
  std::size_t at = 0;
  for (int seen = 0; at < text.size(); ++at) {
    const bool begins = (static_cast<unsigned char>(text[at]) & 0xC0U) != 0x80U;
    if (begins && seen++ == cells) break;
  }
  return text.substr(0, at);
}

TextLine CutLine(const TextLine& line, int columns) {
  TextLine cut;
  for (const TextSpan& span : line) {
    const int cells = CellsOf(span.text);
    cut.push_back({cells > columns ? Cut(span.text, columns) : span.text, span.style});
    columns -= std::min(cells, columns);
    if (columns == 0) break;
  }
  return cut;
}

// Text from outside is shown without what could steer the terminal.
std::string Printable(const std::string& text) {
  std::string plain;
  for (const char c : text) plain += c >= ' ' && c <= '~' ? c : '?';
  return plain;
}

TextStyle StyleOf(ServoState state) {
  switch (state) {
    case ServoState::kServoing:
    case ServoState::kConverged:
      return TextStyle::kGood;
    case ServoState::kHolding:
    case ServoState::kFault:
      return TextStyle::kBad;
    case ServoState::kIdle:
    case ServoState::kAcquiring:
    case ServoState::kRepositioning:
      return TextStyle::kWarning;
  }
  return TextStyle::kPlain;
}

/// Builds the lines from top to bottom.
class Page {
 public:
  Page(const WatchState& state, const WatchHeader& header, Time now, int columns, int rows)
      : state_(state), header_(header), now_(now), columns_(columns), rows_(rows) {}

  std::vector<TextLine> Render() {
    Top();
    State();
    if (state_.observability) Measures();
    if (state_.joints) Joints();
    if (state_.status) Loop();
    Channels();
    Events();
    std::vector<TextLine> fitting;
    for (const TextLine& line : lines_) {
      if (static_cast<int>(fitting.size()) == rows_) break;
      fitting.push_back(CutLine(line, columns_));
    }
    return fitting;
  }

 private:
  void Add(TextLine line) { lines_.push_back(std::move(line)); }

  void Title(const std::string& text) {
    const int rest = std::max(0, columns_ - CellsOf(text) - 4);
    Add({{"── " + text + " " + Repeated("─", rest), TextStyle::kTitle}});
  }

  void Top() {
    TextLine line{{"vantage-watch", TextStyle::kTitle}, {"  ", TextStyle::kPlain}};
    if (state_.setup) {
      line.push_back({Printable(state_.setup->scenario_name) + "  ", TextStyle::kValue});
      const double age = ToSeconds(now_ - state_.setup->start);
      line.push_back({"up " + Format("%.0f s  ", age), TextStyle::kDim});
    }
    line.push_back({header_.url + "  ", TextStyle::kDim});
    if (!header_.connected) line.push_back({"NOT CONNECTED  ", TextStyle::kBad});
    if (header_.paused) line.push_back({"PAUSED  ", TextStyle::kWarning});
    line.push_back({"q quit, p pause", TextStyle::kDim});
    Add(line);
  }

  void State() {
    if (!state_.status) {
      Add({{"no servo heard yet on SERVO_STATUS", TextStyle::kWarning}});
      return;
    }
    const ServoStatus& status = *state_.status;
    const bool silent = now_ - status.stamp > kStale;
    TextLine line{{Padded(Name(status.state), kLabel), StyleOf(status.state)}};
    if (status.reason != HoldReason::kNone) {
      line.push_back({std::string(Name(status.reason)) + "  ", TextStyle::kBad});
    }
    line.push_back(
        {"markers " + std::to_string(status.markers_seen) + "/" +
             std::to_string(status.markers_needed) + "  ",
         status.markers_seen < status.markers_needed ? TextStyle::kWarning : TextStyle::kPlain});
    if (state_.observability) {
      const ObservabilityReport& o = *state_.observability;
      const bool moving = o.active_state == ActiveState::kMoving;
      line.push_back({std::string("camera ") + Name(o.active_state) +
                          (moving ? std::string(" ") + Name(o.active_reason) : "") + ", " +
                          std::to_string(o.camera_moves) + " moves  ",
                      moving ? TextStyle::kWarning : TextStyle::kPlain});
      if (o.cause != LowCause::kNone) {
        line.push_back({std::string("low: ") + Name(o.cause) + "  ", TextStyle::kWarning});
      }
    }
    if (state_.truth) {
      line.push_back(
          {"true error " + Number(1e3 * state_.truth->worst_error) + " mm", TextStyle::kDim});
    }
    if (silent) {
      line.push_back(
          {"  SILENT for " + Format("%.1f s", ToSeconds(now_ - status.stamp)), TextStyle::kBad});
    }
    Add(line);
  }

  void Curve(const std::string& label, double value, const std::deque<double>& history,
             bool logarithmic, TextStyle style, const std::string& unit = "") {
    const std::string number = Padded(Number(value), kNumber, true);
    const int width = std::clamp(columns_ - kLabel - kNumber - 12, 10, 300);
    Add({{Padded(label, kLabel), TextStyle::kPlain},
         {number + " ", style},
         {Padded(unit, 9), TextStyle::kDim},
         {" " + Sparkline(history, width, logarithmic), TextStyle::kCurve}});
  }

  void Measures() {
    const ObservabilityReport& o = *state_.observability;
    const WatchHistory& h = state_.history;
    Title("Observability, the last minute");
    const bool low = o.trigger_value < o.threshold;
    Curve(Name(o.trigger_measure), o.trigger_value, h.trigger_value, false,
          low ? TextStyle::kBad : TextStyle::kGood, "/ " + Number(o.threshold));
    Curve("error", state_.status ? state_.status->error_px : std::nan(""), h.error_px, true,
          TextStyle::kValue, "px");
    Curve("hidden motion", o.mm_per_px, h.mm_per_px, true, TextStyle::kValue, "mm/px");
    Curve("w_v (view)", o.w_v, h.w_v, true, TextStyle::kValue);
    Curve("w_r (arm)", o.w_r, h.w_r, true, TextStyle::kValue);
    Curve("w_c (both)", o.w_c, h.w_c, true, TextStyle::kValue);
    std::string sigma;
    for (int i = 0; i < o.composite.size(); ++i) sigma += Number(o.composite.sigma(i)) + "  ";
    Add({{Padded("sigma of J_c", kLabel), TextStyle::kPlain},
         {sigma, TextStyle::kValue},
         {"px/rad  rank " + std::to_string(o.composite.rank) + "/" +
              std::to_string(o.composite.size()) + "  condition " + Number(o.composite.condition),
          TextStyle::kDim}});
  }

  void Joints() {
    const JointState& joints = *state_.joints;
    const int n = static_cast<int>(joints.q.size());
    const bool modelled = state_.scenario && state_.scenario->task.view.arm.size() == n;
    Title("Joints");
    for (int i = 0; i < n; ++i) {
      if (!modelled) {
        Add({{Padded("joint " + std::to_string(i + 1), kLabel), TextStyle::kPlain},
             {Padded(Number(joints.q(i)), kNumber, true), TextStyle::kValue},
             {" rad or m   " + Padded(Number(joints.qdot(i)), 8, true) + " per s",
              TextStyle::kDim}});
        continue;
      }
      const ArmModel& arm = state_.scenario->task.view.arm;
      const JointLimits& limit = arm.limits()[static_cast<std::size_t>(i)];
      const bool turns = arm.joint_kinds()[static_cast<std::size_t>(i)] == JointKind::kRevolute;
      const double unit = turns ? kDegreesPerRadian : 1e3;
      const double share = (joints.q(i) - limit.lower) / (limit.upper - limit.lower);
      const double speed = std::abs(joints.qdot(i)) / limit.velocity;
      const bool near = share < 0.03 || share > 0.97;
      Add({{Padded(Printable(arm.joint_names()[static_cast<std::size_t>(i)]), kLabel),
            TextStyle::kPlain},
           {Padded(Format("%.2f", unit * joints.q(i)), kNumber, true) + " ",
            near ? TextStyle::kBad : TextStyle::kValue},
           {Padded(turns ? "deg" : "mm", 5), TextStyle::kDim},
           {Ruler(share, 31), near ? TextStyle::kBad : TextStyle::kCurve},
           {Padded(Format("%.2f", unit * joints.qdot(i)), 9, true),
            speed > 0.98 ? TextStyle::kWarning : TextStyle::kValue},
           {(turns ? " deg/s  " : " mm/s  ") + Format("%3.0f", 100.0 * speed) + " % of its limit",
            TextStyle::kDim}});
    }
  }

  // Where a value stands between its limits.
  static std::string Ruler(double share, int width) {
    const int at = static_cast<int>(
        std::lround(std::clamp(std::isfinite(share) ? share : 0.0, 0.0, 1.0) * (width - 1)));
    return "├" + Repeated("─", at) + "●" + Repeated("─", width - 1 - at) + "┤";
  }

  void Loop() {
    const ServoStatus& s = *state_.status;
    Title("Loop and messages");
    const auto count = [](std::int64_t value) {
      return value > 0 ? TextStyle::kWarning : TextStyle::kValue;
    };
    Add({{"period ", TextStyle::kPlain},
         {std::to_string(s.seq), TextStyle::kValue},
         {"  took ", TextStyle::kPlain},
         {Format("%.1f", s.loop_time_us), TextStyle::kValue},
         {" us, at most ", TextStyle::kPlain},
         {Format("%.1f", s.loop_time_max_us), TextStyle::kValue},
         {"  late ", TextStyle::kPlain},
         {std::to_string(s.deadline_misses), count(s.deadline_misses)},
         {"  stops ", TextStyle::kPlain},
         {s.stops == 0 ? "0" : DescribeStops(s), count(s.stops)},
         {"  refused ", TextStyle::kPlain},
         {s.refused_messages == 0 ? "0" : DescribeRefused(s), count(s.refused_messages)},
         {"  overwritten ", TextStyle::kPlain},
         {std::to_string(s.dropped_messages), TextStyle::kValue},
         {"  lost on the way here ", TextStyle::kPlain},
         {std::to_string(state_.lost_periods), count(state_.lost_periods)}});
    if (!s.calibration.none()) {
      Add({{"calibration found: ", TextStyle::kPlain},
           {Describe(s.calibration), TextStyle::kValue}});
    }
  }

  void Channels() {
    Title("Channels");
    if (state_.channels.empty()) {
      Add({{"nothing heard", TextStyle::kWarning}});
      return;
    }
    Add({{Padded("channel", 24) + Padded("type", 22) + Padded("per s", 8, true) +
              Padded("KiB/s", 9, true) + Padded("age ms", 9, true) + Padded("messages", 11, true) +
              Padded("refused", 9, true),
          TextStyle::kDim}});
    for (const auto& [name, channel] : state_.channels) {
      const double age = 1e3 * ToSeconds(now_ - channel.last);
      const bool silent = age > 3000.0;
      Add({{Padded(Cut(Printable(name), 23), 24), silent ? TextStyle::kDim : TextStyle::kPlain},
           {Padded(channel.type, 22), TextStyle::kDim},
           {Padded(Format("%.1f", channel.rate), 8, true), TextStyle::kValue},
           {Padded(Format("%.1f", channel.bytes_rate / 1024.0), 9, true), TextStyle::kValue},
           {Padded(silent ? "silent" : Format("%.0f", std::max(0.0, age)), 9, true),
            silent ? TextStyle::kWarning : TextStyle::kValue},
           {Padded(std::to_string(channel.messages), 11, true), TextStyle::kDim},
           {Padded(std::to_string(channel.refused), 9, true),
            channel.refused > 0 ? TextStyle::kBad : TextStyle::kDim}});
    }
  }

  void Events() {
    if (state_.events.empty()) return;
    Title("What happened, newest first");
    for (const WatchEvent& event : state_.events) {
      Add({{Format("%8.1f s ago  ", ToSeconds(now_ - event.stamp)), TextStyle::kDim},
           {event.text, event.bad ? TextStyle::kBad : TextStyle::kPlain}});
    }
  }

  const WatchState& state_;
  const WatchHeader& header_;
  Time now_;
  int columns_, rows_;
  std::vector<TextLine> lines_;
};

}  // namespace

int CellsOf(const std::string& text) {
  int cells = 0;
  for (const char c : text) cells += (static_cast<unsigned char>(c) & 0xC0U) != 0x80U ? 1 : 0;
  return cells;
}

std::string Sparkline(const std::deque<double>& values, int width, bool logarithmic) {
  constexpr const char* kBars[] = {"▁", "▂", "▃", "▄", "▅", "▆", "▇", "█"};
  const auto shown = static_cast<std::size_t>(std::max(0, width));
  const std::size_t first = values.size() > shown ? values.size() - shown : 0;
  const auto height = [&](double value) {
    if (!logarithmic) return value;
    return value > 0.0 ? std::log(value) : std::nan("");
  };
  double least = std::numeric_limits<double>::infinity();
  double greatest = -least;
  for (std::size_t i = first; i < values.size(); ++i) {
    const double h = height(values[i]);
    if (!std::isfinite(h)) continue;
    least = std::min(least, h);
    greatest = std::max(greatest, h);
  }
  std::string line(shown - (values.size() - first), ' ');
  for (std::size_t i = first; i < values.size(); ++i) {
    const double h = height(values[i]);
    if (!std::isfinite(h)) {
      line += ' ';
      continue;
    }
    // What varies by less than a hundredth is flat: noise is no mountain range.
    const double flat = logarithmic ? 0.01 : 0.01 * std::max(std::abs(least), std::abs(greatest));
    const double share = greatest - least > flat ? (h - least) / (greatest - least) : 0.3;
    line += kBars[static_cast<int>(std::lround(7.0 * share))];
  }
  return line;
}

std::vector<TextLine> RenderWatch(const WatchState& state, const WatchHeader& header, Time now,
                                  int columns, int rows) {
  return Page(state, header, now, columns, rows).Render();
}

}  // namespace vantage
