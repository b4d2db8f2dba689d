#include "run_log.h"

#include <algorithm>
#include <functional>

#include "vantage/math/error.h"
#include "vantage/messaging/channels.h"
#include "vantage/messaging/event_log.h"
#include "vantage/messaging/message_fields.h"

namespace vantage {
namespace {

using Reader = std::function<Refusal(const Bytes&)>;

template <typename Value>
Reader Into(std::vector<Value>* values) {
  return [values](const Bytes& bytes) {
    Value value;
    const Refusal refusal = Decode(bytes.data(), bytes.size(), &value);
    if (refusal == Refusal::kNone) values->push_back(std::move(value));
    return refusal;
  };
}

// Whether it is a message of the type; nothing of it is kept.
template <typename Value>
Refusal Check(const Bytes& bytes) {
  Value value;
  return Decode(bytes.data(), bytes.size(), &value);
}

Refusal ReadSetup(const Bytes& bytes, RunLog* log) {
  ServoSetup setup;
  const Refusal refusal = Decode(bytes.data(), bytes.size(), &setup);
  if (refusal != Refusal::kNone) return refusal;
  // It comes again each second.
  const auto same = [&](const ServoSetup& other) { return other.start == setup.start; };
  if (std::none_of(log->starts.begin(), log->starts.end(), same)) log->starts.push_back(setup);
  return refusal;
}

Refusal ReadRecord(const Bytes& bytes, RunLog* log) {
  ServoRecord record;
  const Refusal refusal = Decode(bytes.data(), bytes.size(), &record);
  if (refusal != Refusal::kNone) return refusal;
  for (const PeriodRecord& period : record.periods) {
    log->periods.push_back({period.lateness, period.execution});
  }
  return refusal;
}

std::map<std::string, Reader> Readers(const std::string& prefix, RunLog* log) {
  return {
      {prefix + kJointStateChannel, Into(&log->joint_states)},
      {prefix + kJointCommandChannel, Into(&log->joint_commands)},
      {prefix + kCameraPoseChannel, Into(&log->camera_poses)},
      {prefix + kCameraPoseCommandChannel, Check<CameraPose>},
      {prefix + kImageFeaturesChannel, Into(&log->features)},
      {prefix + kObservabilityChannel, Into(&log->observability)},
      {prefix + kServoStatusChannel, Into(&log->statuses)},
      {prefix + kSimTruthChannel, Into(&log->truths)},
      {prefix + kServoSetupChannel, [log](const Bytes& bytes) { return ReadSetup(bytes, log); }},
      {prefix + kServoInputsChannel, [log](const Bytes& bytes) { return ReadRecord(bytes, log); }},
      {prefix + kCameraImageChannel,
       [log](const Bytes& bytes) {
         const Refusal refusal = Check<CameraImage>(bytes);
         if (refusal == Refusal::kNone) ++log->images;
         return refusal;
       }},
  };
}

void Count(const LoggedEvent& event, ChannelTraffic* traffic) {
  if (traffic->messages == 0) {
    const MessageLayout* layout = FindLayout(event.data.data(), event.data.size());
    traffic->type = layout == nullptr ? "unknown" : layout->name;
    traffic->first_utime = event.utime;
  } else {
    traffic->longest_gap = std::max(traffic->longest_gap,
                                    1e-6 * static_cast<double>(event.utime - traffic->last_utime));
  }
  traffic->last_utime = event.utime;
  ++traffic->messages;
  traffic->bytes += static_cast<std::int64_t>(event.data.size());
}

// The least or the greatest stamp of all.
template <typename Better>
Time Extreme(const RunLog& log, Time worst, Better better) {
  const auto look = [&](const auto& values) {
    for (const auto& value : values) {
      if (better(value.stamp, worst)) worst = value.stamp;
    }
  };
  look(log.joint_states);
  look(log.joint_commands);
  look(log.camera_poses);
  look(log.features);
  look(log.observability);
  look(log.statuses);
  look(log.truths);
  return worst;
}

void SetTimeAxis(RunLog* log) {
  log->t0 = Extreme(*log, Time::max(), std::less<>());
  log->end = Extreme(*log, Time{}, std::greater<>());
  const auto measured = std::find_if(log->observability.begin(), log->observability.end(),
                                     [](const ObservabilityReport& o) { return o.k > 0; });
  if (measured != log->observability.end()) log->t0 = measured->stamp;
}

}  // namespace

double ChannelTraffic::rate() const {
  const double time = 1e-6 * static_cast<double>(last_utime - first_utime);
  return messages > 1 && time > 0.0 ? static_cast<double>(messages - 1) / time : 0.0;
}

bool RunLog::IsGoalMarker(int id) const {
  if (!scenario) return false;
  const std::vector<int>& ids = scenario->task.goal.marker_ids;
  return std::find(ids.begin(), ids.end(), id) != ids.end();
}

RunLog ReadRunLog(const std::string& path, const std::string& prefix, const std::string& scenario) {
  RunLog log;
  const std::map<std::string, Reader> readers = Readers(prefix, &log);
  EventLogReader events(path);
  bool any = false;
  for (LoggedEvent event; events.Next(&event);) {
    ChannelTraffic& traffic = log.channels[event.channel];
    Count(event, &traffic);
    const auto reader = readers.find(event.channel);
    if (reader == readers.end()) continue;
    const Refusal refusal = reader->second(event.data);
    any = any || refusal == Refusal::kNone;
    if (refusal == Refusal::kNone) continue;
    ++traffic.refused;
    ++log.refused[static_cast<std::size_t>(refusal)];
  }
  log.damaged_bytes = events.damaged_bytes();
  if (!any) {
    throw ConfigError(
        path, "",
        "holds no message of Vantage's" + (prefix.empty() ? "" : " with the prefix " + prefix));
  }
  if (!scenario.empty()) {
    log.scenario = LoadScenario(scenario);
  } else if (!log.starts.empty()) {
    const ServoSetup& setup = log.starts.front();
    log.scenario = ReadRecordedScenario(setup.scenario_name, setup.scenario);
  }
  SetTimeAxis(&log);
  return log;
}

}  // namespace vantage
