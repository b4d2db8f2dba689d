#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

#include "vantage/config/scenario.h"
#include "vantage/messaging/codec.h"

namespace vantage {

/// Traffic of one channel as it is now.
struct ChannelNow {
  std::string type;  ///< "joint_state_t"; "?" when it is none of ours.
  std::int64_t messages{0};
  std::int64_t refused{0};
  double rate{0.0};        ///< [messages/s].
  double bytes_rate{0.0};  ///< [byte/s].
  Time last{};             ///< When the newest arrived.
};

/// Something worth a line: the servo's state changed, or the camera began or ended a move.
struct WatchEvent {
  Time stamp{};
  std::string text;
  bool bad{false};
};

/// Values of the last minute, ten a second, oldest first; NaN where there was none.
struct WatchHistory {
  static constexpr std::size_t kLength = 600;
  std::deque<double> error_px, w_v, w_r, w_c, trigger_value, mm_per_px;
};

/// All that vantage-watch shows.
struct WatchState {
  std::optional<ServoStatus> status;
  std::optional<ObservabilityReport> observability;
  std::optional<JointState> joints;
  std::optional<GroundTruth> truth;
  std::optional<ServoSetup> setup;
  std::optional<Scenario> scenario;  ///< Of the setup; absent when it does not load here.
  std::map<std::string, ChannelNow> channels;
  std::deque<WatchEvent> events;  ///< Newest first.
  std::int64_t lost_periods{0};   ///< Of SERVO_INPUTS: sent by the servo and not arrived here.
  WatchHistory history;
};

/// Collects what arrives. One thread gives it messages, another takes states.
class WatchCollector {
 public:
  explicit WatchCollector(std::string prefix) : prefix_(std::move(prefix)) {}

  /// A message from outside, unchecked.
  void OnMessage(std::string_view channel, const void* data, std::size_t size, Time now);

  /// Ten times a second: brings rates and histories up to now.
  void Tick(Time now);

  [[nodiscard]] WatchState Get() const;

 private:
  template <typename Value>
  bool Take(const void* data, std::size_t size, std::optional<Value>* into, Refusal* refusal);
  Refusal Decode(std::string_view channel, const void* data, std::size_t size);
  void NoteStatus(const std::optional<ServoStatus>& before);
  void NoteCamera(const std::optional<ObservabilityReport>& before);
  void NoteSetup(const std::optional<ServoSetup>& before);
  void NotePeriods(const ServoRecord& record);
  void AddEvent(Time stamp, const std::string& text, bool bad);

  const std::string prefix_;
  mutable std::mutex mutex_;
  WatchState state_;
  // By channel, of the last seconds: when, bytes.
  std::map<std::string, std::deque<std::pair<Time, std::size_t>>> arrivals_;
  std::int64_t last_seq_{0};
  Time last_start_{};
};

}  // namespace vantage
