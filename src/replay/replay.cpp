#include "vantage/replay/replay.h"

#include <algorithm>
#include <deque>
#include <limits>
#include <map>
#include <set>

#include "message_difference.h"
#include "vantage/config/scenario.h"
#include "vantage/math/error.h"
#include "vantage/messaging/channels.h"
#include "vantage/messaging/event_log.h"
#include "vantage/servo/camera_task.h"
#include "vantage/servo/servo.h"

namespace vantage {
namespace {

// A step of the active camera may look at a snapshot this old: seconds of planning.
constexpr std::size_t kSnapshotsKept = 5000;

// What tells of the machine and not of the servo.
const std::set<std::string> kNotReproduced{
    "loop_time_us",       "loop_time_max_us",     "loop_time_p50_us",  "loop_time_p99_us",
    "loop_time_p999_us",  "lateness_p999_us",     "lateness_max_us",   "deadline_misses",
    "refused_messages",   "dropped_messages",     "refused_malformed", "refused_wrong_size",
    "refused_not_finite", "refused_out_of_range", "refused_reordered", "refused_future"};

const char* const kCompared[] = {kJointCommandChannel, kObservabilityChannel, kServoStatusChannel,
                                 kCameraPoseCommandChannel};

Scenario LoadRecorded(const ServoSetup& setup) {
  Scenario scenario = ReadRecordedScenario(setup.scenario_name, setup.scenario);
  scenario.active.enabled = setup.active_camera;
  return scenario;
}

/// Logged outputs that wait for the replayed ones, by stamp.
class Comparison {
 public:
  Comparison(const char* channel, double tolerance) : tolerance_(tolerance) {
    result_.channel = channel;
  }

  void Logged(std::int64_t utime, const Bytes& bytes) { waiting_[utime] = bytes; }

  /// The difference, when a message of the log belongs to this one and is not the same.
  std::optional<MessageDifference::Field> Replayed(std::int64_t utime, const Bytes& bytes) {
    const auto found = waiting_.find(utime);
    if (found == waiting_.end()) return std::nullopt;
    const MessageDifference difference = Compare(found->second, bytes, tolerance_, kNotReproduced);
    waiting_.erase(found);
    ++result_.compared;
    result_.worst = std::max(result_.worst, difference.worst);
    if (difference.first) ++result_.different;
    return difference.first;
  }

  /// @param first, last  Stamps between which messages of the log count as unmatched.
  [[nodiscard]] ChannelComparison Finish(std::int64_t first, std::int64_t last) const {
    ChannelComparison result = result_;
    result.unmatched = std::distance(waiting_.lower_bound(first), waiting_.upper_bound(last));
    return result;
  }

 private:
  double tolerance_;
  ChannelComparison result_;
  std::map<std::int64_t, Bytes> waiting_;
};

/// Replays one start of a servo.
class Replayer {
 public:
  Replayer(const ServoSetup& setup, double tolerance)
      : scenario_(LoadRecorded(setup)),
        start_(setup.start),
        servo_(scenario_.task, scenario_.servo, scenario_.active.trigger),
        camera_task_(scenario_.task, scenario_.rig, scenario_.q_c_start, scenario_.active) {
    report_.program = setup.program;
    report_.scenario_name = setup.scenario_name;
    report_.active_camera = setup.active_camera;
    for (const char* channel : kCompared)
      comparisons_.emplace(channel, Comparison(channel, tolerance));
  }

  void Logged(const std::string& channel, const Bytes& bytes, std::int64_t utime) {
    const auto found = comparisons_.find(channel);
    if (found != comparisons_.end()) found->second.Logged(utime, bytes);
  }

  void Feed(const ServoRecord& record) {
    if (!report_.cut_short.empty()) return;
    for (const CameraStepRecord& step : record.camera_steps) steps_.push_back(step);
    for (const PeriodRecord& period : record.periods) {
      if (!report_.cut_short.empty()) return;
      Feed(period);
    }
    // What is left are steps whose output no period has taken yet.
    RunCameraSteps(std::numeric_limits<std::int64_t>::max());
  }

  [[nodiscard]] ReplayReport Finish() {
    const std::int64_t first = ToMicroseconds(start_);
    const std::int64_t last = ToMicroseconds(last_);
    for (const char* channel : kCompared) {
      report_.channels.push_back(comparisons_.at(channel).Finish(first, last));
    }
    report_.duration = report_.periods > 0 ? ToSeconds(last_ - start_) : 0.0;
    return report_;
  }

 private:
  void Feed(const PeriodRecord& period) {
    if (period.seq != report_.periods + 1) {
      CutShort(report_.periods == 0
                   ? "the log begins at period " + std::to_string(period.seq) +
                         " of the servo: it holds all only if it was begun before the servo"
                   : "periods " + std::to_string(report_.periods + 1) + " to " +
                         std::to_string(period.seq - 1) + " are missing in the log");
      return;
    }
    PeriodInputs inputs = period.inputs;
    inputs.has_active = period.camera_step > 0;
    if (inputs.has_active) {
      RunCameraSteps(period.camera_step);
      const auto taken = outputs_.find(period.camera_step);
      if (taken == outputs_.end()) {
        CutShort("step " + std::to_string(period.camera_step) +
                 " of the active camera is missing in the log");
        return;
      }
      inputs.active = taken->second;
      // A period takes the newest there is: older ones are of no more use.
      outputs_.erase(outputs_.begin(), taken);
    }
    const ServoOutput& output = RunPeriod(&servo_, inputs);
    ++report_.periods;
    last_ = inputs.now;
    snapshots_.push_back(servo_.snapshot());
    if (snapshots_.size() > kSnapshotsKept) snapshots_.pop_front();
    Replayed(kJointCommandChannel, output.command);
    ObservabilityReport report = output.observability;
    CompleteReport(output.J_v, output.J_r, &report);
    Replayed(kObservabilityChannel, report);
    Replayed(kServoStatusChannel, output.status);
  }

  // Up to step `last`, as far as their snapshots are there.
  void RunCameraSteps(std::int64_t last) {
    while (!steps_.empty() && steps_.front().step <= last) {
      const CameraStepRecord& step = steps_.front();
      const auto snapshot =
          std::lower_bound(snapshots_.begin(), snapshots_.end(), step.snapshot,
                           [](const ServoSnapshot& s, Time time) { return s.active.now < time; });
      if (snapshot == snapshots_.end() || snapshot->active.now != step.snapshot) return;
      if (step.step != report_.camera_steps + 1) return;
      const ActiveOutput& output = outputs_[step.step] = camera_task_.Step(*snapshot);
      ++report_.camera_steps;
      if (step.command != Time{}) {
        Replayed(kCameraPoseCommandChannel, CameraPose{step.command, output.X_WC});
      }
      steps_.pop_front();
    }
  }

  template <typename Value>
  void Replayed(const char* channel, const Value& value) {
    Encode(value, &bytes_);
    const auto difference = comparisons_.at(channel).Replayed(ToMicroseconds(value.stamp), bytes_);
    if (!difference) return;
    const double t = ToSeconds(value.stamp - start_);
    if (report_.first_difference && report_.first_difference->t <= t) return;
    report_.first_difference = {t, channel, difference->name, difference->a, difference->b};
  }

  void CutShort(std::string why) { report_.cut_short = std::move(why); }

  Scenario scenario_;
  Time start_;
  Servo servo_;
  CameraTask camera_task_;
  std::map<std::string, Comparison> comparisons_;
  std::deque<CameraStepRecord> steps_;
  std::deque<ServoSnapshot> snapshots_;
  std::map<std::int64_t, ActiveOutput> outputs_;  // of camera steps
  Time last_{};
  Bytes bytes_;
  ReplayReport report_;
};

/// Channel without the prefix; nullopt when it has another one.
std::optional<std::string> WithoutPrefix(const std::string& channel, const std::string& prefix) {
  if (channel.compare(0, prefix.size(), prefix) != 0) return std::nullopt;
  return channel.substr(prefix.size());
}

// SERVO_SETUP comes again each second: the first of each start.
std::vector<ServoSetup> FindStarts(const std::string& path, const std::string& prefix) {
  std::vector<ServoSetup> starts;
  EventLogReader log(path);
  LoggedEvent event;
  while (log.Next(&event)) {
    if (event.channel != prefix + kServoSetupChannel) continue;
    ServoSetup setup;
    if (Decode(event.data.data(), event.data.size(), &setup) != Refusal::kNone) continue;
    const auto same = [&](const ServoSetup& other) { return other.start == setup.start; };
    if (std::none_of(starts.begin(), starts.end(), same)) starts.push_back(setup);
  }
  return starts;
}

// Of any of the compared types, which all begin with it.
std::optional<std::int64_t> UtimeOf(const Bytes& bytes) {
  constexpr std::size_t kAt = 8;
  if (bytes.size() < kAt + 8) return std::nullopt;
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < 8; ++i) value = value << 8 | bytes[kAt + i];
  return static_cast<std::int64_t>(value);
}

ReplayReport ReplayStart(const std::string& path, const ServoSetup& setup,
                         const ReplayOptions& options) {
  Replayer replayer(setup, options.tolerance);
  EventLogReader log(path);
  LoggedEvent event;
  // One record is held back, so that outputs that were logged a little after it are there.
  std::optional<ServoRecord> held;
  while (log.Next(&event)) {
    const auto channel = WithoutPrefix(event.channel, options.prefix);
    if (!channel) continue;
    if (*channel != kServoInputsChannel) {
      if (const auto utime = UtimeOf(event.data)) replayer.Logged(*channel, event.data, *utime);
      continue;
    }
    ServoRecord record;
    const Refusal refusal = Decode(event.data.data(), event.data.size(), &record);
    if (refusal != Refusal::kNone) {
      throw ConfigError(path, event.channel, std::string("a message is refused: ") + Name(refusal));
    }
    if (record.start != setup.start) continue;
    if (held) replayer.Feed(*held);
    held = std::move(record);
  }
  if (held) replayer.Feed(*held);
  return replayer.Finish();
}

}  // namespace

bool ReplayReport::reproduced() const {
  std::int64_t compared = 0;
  for (const ChannelComparison& channel : channels) compared += channel.compared;
  return cut_short.empty() && compared > 0 && !first_difference;
}

std::vector<ReplayReport> Replay(const std::string& log_path, const ReplayOptions& options) {
  const std::vector<ServoSetup> starts = FindStarts(log_path, options.prefix);
  if (starts.empty()) {
    throw ConfigError(log_path, "",
                      "holds no " + options.prefix + kServoSetupChannel +
                          ": no servo was recorded in it" +
                          (options.prefix.empty() ? ", or its channels have a --prefix" : ""));
  }
  std::vector<ReplayReport> reports;
  for (const ServoSetup& setup : starts) {
    reports.push_back(ReplayStart(log_path, setup, options));
  }
  return reports;
}

}  // namespace vantage
