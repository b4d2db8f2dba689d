#include "watch_state.h"

#include <cmath>

#include "vantage/math/error.h"
#include "vantage/messaging/channels.h"
#include "vantage/messaging/message_fields.h"

namespace vantage {
namespace {

constexpr Duration kWindow = std::chrono::seconds(2);  // That rates are over.
constexpr Duration kFresh = std::chrono::milliseconds(500);
constexpr std::size_t kMostChannels = 200;  // Names come from outside.
constexpr std::size_t kMostEvents = 50;

std::string ShortType(const void* data, std::size_t size) {
  const MessageLayout* layout = FindLayout(data, size);
  if (layout == nullptr) return "?";
  const std::string name = layout->name;
  return name.substr(name.find('.') + 1);
}

void Push(std::deque<double>* values, double value) {
  values->push_back(value);
  if (values->size() > WatchHistory::kLength) values->pop_front();
}

}  // namespace

template <typename Value>
bool WatchCollector::Take(const void* data, std::size_t size, std::optional<Value>* into,
                          Refusal* refusal) {
  Value value;
  *refusal = vantage::Decode(data, size, &value);
  if (*refusal != Refusal::kNone) return false;
  *into = std::move(value);
  return true;
}

void WatchCollector::AddEvent(Time stamp, const std::string& text, bool bad) {
  state_.events.push_front({stamp, text, bad});
  if (state_.events.size() > kMostEvents) state_.events.pop_back();
}

void WatchCollector::NoteStatus(const std::optional<ServoStatus>& before) {
  const ServoStatus& now = *state_.status;
  if (before && before->state == now.state && before->reason == now.reason) return;
  const bool bad = now.state == ServoState::kHolding || now.state == ServoState::kFault;
  AddEvent(
      now.stamp,
      Name(now.state) +
          (now.reason == HoldReason::kNone ? std::string() : std::string(" ") + Name(now.reason)),
      bad);
}

void WatchCollector::NoteCamera(const std::optional<ObservabilityReport>& before) {
  const ObservabilityReport& now = *state_.observability;
  if (!before || before->active_state == now.active_state) return;
  AddEvent(
      now.stamp,
      std::string("camera ") + Name(now.active_state) +
          (now.active_state == ActiveState::kMoving ? std::string(" ") + Name(now.active_reason)
                                                    : std::string()),
      false);
}

// The scenario is read anew only when the servo was started anew.
void WatchCollector::NoteSetup(const std::optional<ServoSetup>& before) {
  const ServoSetup& now = *state_.setup;
  if (before && before->start == now.start) return;
  state_.scenario.reset();
  try {
    state_.scenario = ReadRecordedScenario(now.scenario_name, now.scenario);
  } catch (const Error&) {
    // A robot file of another machine: the view does without limits.
  }
}

void WatchCollector::NotePeriods(const ServoRecord& record) {
  if (record.start != last_start_) {
    last_start_ = record.start;
    last_seq_ = 0;
    state_.lost_periods = 0;
  }
  for (const PeriodRecord& period : record.periods) {
    if (last_seq_ > 0 && period.seq > last_seq_ + 1) {
      state_.lost_periods += period.seq - last_seq_ - 1;
    }
    last_seq_ = period.seq;
  }
}

Refusal WatchCollector::Decode(std::string_view channel, const void* data, std::size_t size) {
  Refusal refusal = Refusal::kNone;
  if (channel == kServoStatusChannel) {
    const auto before = state_.status;
    if (Take(data, size, &state_.status, &refusal)) NoteStatus(before);
  } else if (channel == kObservabilityChannel) {
    const auto before = state_.observability;
    if (Take(data, size, &state_.observability, &refusal)) NoteCamera(before);
  } else if (channel == kJointStateChannel) {
    Take(data, size, &state_.joints, &refusal);
  } else if (channel == kJointCommandChannel) {
    std::optional<JointCommand> command;
    Take(data, size, &command, &refusal);
  } else if (channel == kSimTruthChannel) {
    Take(data, size, &state_.truth, &refusal);
  } else if (channel == kServoSetupChannel) {
    const auto before = state_.setup;
    if (Take(data, size, &state_.setup, &refusal)) NoteSetup(before);
  } else if (channel == kServoInputsChannel) {
    std::optional<ServoRecord> record;
    if (Take(data, size, &record, &refusal)) NotePeriods(*record);
  } else if (channel == kImageFeaturesChannel) {
    std::optional<ImageFeatures> features;
    Take(data, size, &features, &refusal);
  } else if (channel == kCameraPoseChannel || channel == kCameraPoseCommandChannel) {
    std::optional<CameraPose> pose;
    Take(data, size, &pose, &refusal);
  }
  return refusal;
}

void WatchCollector::OnMessage(std::string_view channel, const void* data, std::size_t size,
                               Time now) {
  const std::lock_guard lock(mutex_);
  const std::string name(channel);
  if (state_.channels.count(name) == 0 && state_.channels.size() >= kMostChannels) return;
  ChannelNow& traffic = state_.channels[name];
  if (traffic.messages == 0) traffic.type = ShortType(data, size);
  ++traffic.messages;
  traffic.last = now;
  arrivals_[name].emplace_back(now, size);
  if (name.compare(0, prefix_.size(), prefix_) != 0) return;
  if (Decode(channel.substr(prefix_.size()), data, size) != Refusal::kNone) ++traffic.refused;
}

void WatchCollector::Tick(Time now) {
  const std::lock_guard lock(mutex_);
  for (auto& [name, arrivals] : arrivals_) {
    while (!arrivals.empty() && arrivals.front().first < now - kWindow) arrivals.pop_front();
    std::size_t bytes = 0;
    for (const auto& arrival : arrivals) bytes += arrival.second;
    ChannelNow& traffic = state_.channels[name];
    traffic.rate = static_cast<double>(arrivals.size()) / ToSeconds(kWindow);
    traffic.bytes_rate = static_cast<double>(bytes) / ToSeconds(kWindow);
  }
  const auto& status = state_.status;
  const auto& report = state_.observability;
  const bool status_fresh = status && now - status->stamp < kFresh;
  const bool measured = report && report->k > 0 && now - report->stamp < kFresh;
  WatchHistory& history = state_.history;
  const auto push = [&](std::deque<double>* values, bool there, double value) {
    Push(values, there ? value : std::nan(""));
  };
  push(&history.error_px, status_fresh, status ? status->error_px : 0.0);
  push(&history.w_v, measured, report ? report->w_v : 0.0);
  push(&history.w_r, measured, report ? report->w_r : 0.0);
  push(&history.w_c, measured, report ? report->w_c : 0.0);
  push(&history.trigger_value, measured, report ? report->trigger_value : 0.0);
  push(&history.mm_per_px, measured, report ? report->mm_per_px : 0.0);
}

WatchState WatchCollector::Get() const {
  const std::lock_guard lock(mutex_);
  return state_;
}

}  // namespace vantage
