#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "vantage/math/time.h"
#include "vantage/messaging/channels.h"
#include "vantage/messaging/codec.h"
#include "vantage/messaging/refusal.h"
#include "vantage/messaging/stamp_gate.h"

namespace vantage {

/// Where a link leads, and how its channels are called.
struct LcmLinkOptions {
  std::string url;     ///< As ChooseTransport() gives it.
  std::string prefix;  ///< Put before every channel name: several arms on one network.
};

/// Which of the messages that wait on a channel a callback is given.
enum class Delivery {
  kNewest,  ///< The newest alone; the others are counted as dropped. For states.
  kEvery,   ///< All that arrive, in order. For recorders and tests.
};

/// How a channel is listened to.
struct SubscribeOptions {
  /// Which of the waiting messages are given to the callback.
  Delivery delivery{Delivery::kNewest};
  StampGateOptions stamps;  ///< Which stamps are refused.
};

/// Counters of one link since its start.
struct LinkStats {
  std::int64_t received{0};         ///< Messages that came in on subscribed channels.
  std::int64_t delivered{0};        ///< Given to callbacks.
  std::int64_t dropped{0};          ///< Replaced by a newer one before delivery.
  RefusalCounts refused{};          ///< By reason.
  std::int64_t callback_errors{0};  ///< Exceptions out of callbacks.
  std::int64_t published{0};        ///< Messages handed to the transport.
  std::int64_t unsent{0};           ///< Could not be published: no connection.
  std::int64_t connects{0};         ///< Times the transport was connected: 1 at the start.
  bool connected{false};            ///< Now.

  [[nodiscard]] std::int64_t total_refused() const noexcept;
};

/// Throws ConfigError (key "lcm.url") when LCM does not know the kind of URL. Whether anybody answers there is
/// not asked.
void CheckLcmUrl(const std::string& url);

/// A program's connection to LCM: one thread that receives, checks and delivers, and a way to publish
/// from any thread. It outlives the loss of the TCP hub and reconnects by itself.
///
/// Callbacks run in the link's thread, one at a time. What they throw is caught and counted.
class LcmLink {
 public:
  /// Throws ConfigError (key "lcm.prefix" or "lcm.url") when the prefix is longer than 32 letters or
  /// has others than A-Z a-z 0-9 _ -, or LCM does not know the kind of URL. That nobody answers at the
  /// URL is no error: the link goes on trying.
  explicit LcmLink(const LcmLinkOptions& options);
  ~LcmLink();
  LcmLink(const LcmLink&) = delete;
  LcmLink& operator=(const LcmLink&) = delete;

  /// Values of type T (see codec.h) that arrive on prefix + channel go to `on_value`. Before Start().
  /// With kNewest it is the newest that passed all checks: garbage does not push out good values.
  template <typename T>
  void Subscribe(const std::string& channel, std::function<void(const T&)> on_value,
                 const SubscribeOptions& options = {}) {
    struct State {
      std::function<void(const T&)> on_value;
      StampGate gate;
      T incoming{};  // Values that own memory keep it between messages.
      T accepted{};
    };
    // Shared by the two functions.
    auto state =
        std::make_shared<State>(State{std::move(on_value), StampGate(options.stamps), {}, {}});
    Handler handler;
    handler.accept = [state](const void* data, std::size_t size, Time now) {
      Refusal refusal = Decode(data, size, &state->incoming);
      if (refusal == Refusal::kNone) refusal = state->gate.Check(state->incoming.stamp, now);
      if (refusal == Refusal::kNone) std::swap(state->incoming, state->accepted);
      return refusal;
    };
    handler.deliver = [state] { state->on_value(state->accepted); };
    AddHandler(channel, options.delivery, std::move(handler));
  }

  /// Every message on every channel, whatever the prefix, unchecked and in order: for recorders and
  /// monitors. Beside other subscriptions, once, before Start().
  using RawHandler =
      std::function<void(std::string_view channel, const void* data, std::size_t size)>;
  /// See RawHandler.
  void SubscribeAll(RawHandler on_message);

  /// Starts receiving. Once.
  void Start();

  /// Publishes on prefix + channel. Any thread; waits for other publishers, and at most 0.1 s for a hub
  /// that does not read. False when there is no connection. Not real-time safe.
  template <typename T>
  bool Publish(const std::string& channel, const T& value) {
    thread_local Bytes bytes;
    Encode(value, &bytes);
    return PublishBytes(channel, bytes);
  }

  /// The same for bytes that are a message already.
  bool PublishBytes(const std::string& channel, const Bytes& bytes);

  [[nodiscard]] LinkStats stats() const;

 private:
  /// Both run in the link's thread.
  struct Handler {
    std::function<Refusal(const void* data, std::size_t size, Time now)> accept;
    std::function<void()> deliver;  ///< What was accepted last.
  };
  void AddHandler(const std::string& channel, Delivery delivery, Handler handler);

  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace vantage
