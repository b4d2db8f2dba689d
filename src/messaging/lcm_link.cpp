#include "vantage/messaging/lcm_link.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <condition_variable>
#include <csignal>
#include <deque>
#include <mutex>
#include <numeric>
#include <optional>
#include <thread>

#include <lcm/lcm-cpp.hpp>

#include "tcpq_client.h"
#include "vantage/math/error.h"
#include "vantage/messaging/tcp_hub.h"

#if defined(__SANITIZE_THREAD__)
// LCM and GLib come without instrumentation, and GLib's locks are system calls that ThreadSanitizer
// does not see: all that one LCM thread hands to another looks like a race.
extern "C" const char* __tsan_default_suppressions();
extern "C" const char* __tsan_default_suppressions() {
  return "race:liblcm.so\nrace:libglib-2.0.so\n";
}
#endif

namespace vantage {
namespace {

using std::chrono::milliseconds;

constexpr std::size_t kMaxPrefix = 32;
constexpr std::size_t kMaxChannel = 63;           // LCM's.
constexpr Duration kWait = milliseconds(20);      // For a message: how late a stop is noticed.
constexpr Duration kDrainTime = milliseconds(5);  // A flood must not hold up delivery for ever.
constexpr Duration kConnectTime = milliseconds(200);
constexpr int kQueueCapacity = 200;  // Messages of one channel.
constexpr char kAnyChannel[] = ".*";
constexpr int kAnyQueueCapacity = 5000;  // Messages of all channels.
constexpr Duration kFirstRetry = milliseconds(10);
constexpr Duration kLastRetry = milliseconds(500);

// tcpq://host:port, both of which may be left out.
struct TcpAddress {
  std::string host{kDefaultHubAddress};
  std::uint16_t port{kDefaultHubPort};
};

std::optional<TcpAddress> ParseTcpUrl(const std::string& url) {
  const std::string scheme = "tcpq://";
  if (url.compare(0, scheme.size(), scheme) != 0) return std::nullopt;
  TcpAddress address;
  std::string rest = url.substr(scheme.size());
  rest = rest.substr(0, rest.find('?'));
  const std::size_t colon = rest.find(':');
  if (colon != 0 && !rest.empty()) address.host = rest.substr(0, colon);
  if (colon != std::string::npos) {
    const std::string digits = rest.substr(colon + 1);
    const bool number = !digits.empty() && digits.size() <= 5 &&
                        digits.find_first_not_of("0123456789") == std::string::npos;
    if (!number || std::stoi(digits) < 1 || std::stoi(digits) > 65535) {
      throw ConfigError("", "lcm.url", "must be tcpq://HOST:PORT, is " + url);
    }
    address.port = static_cast<std::uint16_t>(std::stoi(digits));
  }
  return address;
}

void CheckName(const std::string& name, std::size_t max_size, const char* key) {
  // Anything else could mean something in the regular expression that a channel is subscribed by.
  const bool good = name.size() <= max_size && std::all_of(name.begin(), name.end(), [](char c) {
                      return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') ||
                             (c >= '0' && c <= '9') || c == '_' || c == '-';
                    });
  if (good) return;
  throw ConfigError(
      "", key,
      "must be at most " + std::to_string(max_size) + " of A-Z a-z 0-9 _ -, is '" + name + "'");
}

}  // namespace

void CheckLcmUrl(const std::string& url) {
  for (const char* scheme : {"udpm://", "tcpq://", "memq://"}) {
    if (url.compare(0, 7, scheme) == 0) return;
  }
  throw ConfigError(
      "", "lcm.url",
      "must begin with udpm://, tcpq:// or memq:// (is LCM_DEFAULT_URL set?), is '" + url + "'");
}

std::int64_t LinkStats::total_refused() const noexcept {
  return std::accumulate(refused.begin(), refused.end(), std::int64_t{0});
}

class LcmLink::Impl {
 public:
  explicit Impl(const LcmLinkOptions& options) : options_(options) {
    CheckLcmUrl(options.url);
    CheckName(options.prefix, kMaxPrefix, "lcm.prefix");
    tcp_ = ParseTcpUrl(options.url);
  }

  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  ~Impl() {
    {
      const std::lock_guard<std::mutex> lock(stop_mutex_);
      stop_ = true;
    }
    stop_changed_.notify_all();
    if (thread_.joinable()) thread_.join();
  }

  void AddHandler(const std::string& channel, Delivery delivery, Handler handler) {
    CheckName(options_.prefix + channel, kMaxChannel, "channel");
    subscriptions_.push_back(
        {this, options_.prefix + channel, delivery, std::move(handler), false});
  }

  void SubscribeAll(RawHandler on_message) { on_any_ = std::move(on_message); }

  void Start() {
    // The first try here: with somebody at the URL, what is published next goes out.
    Connect();
    thread_ = std::thread([this] { Run(); });
  }

  bool PublishBytes(const std::string& channel, const Bytes& bytes) {
    const std::string name = options_.prefix + channel;
    const std::lock_guard<std::mutex> lock(publish_mutex_);
    bool sent = false;
    if (hub_) {
      sent = hub_->Publish(name, bytes.data(), bytes.size());
    } else if (lcm_) {
      sent = lcm_->publish(name, bytes.data(), static_cast<unsigned>(bytes.size())) == 0;
    }
    ++(sent ? published_ : unsent_);
    return sent;
  }

  [[nodiscard]] LinkStats stats() const {
    LinkStats stats;
    stats.received = received_.load();
    stats.delivered = delivered_.load();
    stats.dropped = dropped_.load();
    for (int i = 0; i < kNumRefusals; ++i) stats.refused[i] = refused_[i].load();
    stats.callback_errors = callback_errors_.load();
    stats.published = published_.load();
    stats.unsent = unsent_.load();
    stats.connects = connects_.load();
    stats.connected = connected_.load();
    return stats;
  }

 private:
  struct Subscription {
    Impl* impl;
    std::string channel;
    Delivery delivery;
    Handler handler;
    bool pending;  // Something was accepted and not yet delivered.
  };

  bool Connect() {
    const bool connected = tcp_ ? ConnectHub() : ConnectLcm();
    connected_.store(connected);
    if (connected) ++connects_;
    return connected;
  }

  bool ConnectHub() {
    std::unique_ptr<TcpqClient> hub = TcpqClient::Connect(tcp_->host, tcp_->port, kConnectTime);
    if (!hub) return false;
    for (const Subscription& subscription : subscriptions_) {
      if (!hub->Subscribe(subscription.channel)) return false;
    }
    if (on_any_ && !hub->Subscribe(kAnyChannel)) return false;
    const std::lock_guard<std::mutex> lock(publish_mutex_);
    hub_ = std::move(hub);
    return true;
  }

  bool ConnectLcm() {
    auto lcm = std::make_unique<lcm::LCM>(options_.url);
    if (!lcm->good()) return false;
    for (Subscription& subscription : subscriptions_) {
      lcm::Subscription* added =
          lcm->subscribeFunction(subscription.channel, &Impl::OnLcmMessage, &subscription);
      // LCM's queue drops what is newest when it is full: make it hold a burst.
      if (added != nullptr) added->setQueueCapacity(kQueueCapacity);
    }
    if (on_any_) {
      lcm::Subscription* added = lcm->subscribeFunction(kAnyChannel, &Impl::OnAnyMessage, this);
      if (added != nullptr) added->setQueueCapacity(kAnyQueueCapacity);
    }
    const std::lock_guard<std::mutex> lock(publish_mutex_);
    lcm_ = std::move(lcm);
    return true;
  }

  void Disconnect() {
    connected_.store(false);
    const std::lock_guard<std::mutex> lock(publish_mutex_);
    hub_.reset();
    lcm_.reset();
  }

  void Run() {
    // Signals are for the program's own threads; and one here would end LCM's select().
    sigset_t all;
    sigfillset(&all);
    pthread_sigmask(SIG_BLOCK, &all, nullptr);

    Duration retry = kFirstRetry;
    while (!Stopping()) {
      if (connected_.load() || Connect()) {
        retry = kFirstRetry;
        Receive();
      } else {
        WaitForStop(retry);
        retry = std::min(2 * retry, kLastRetry);
      }
    }
  }

  // Waits for a message, takes all that wait, then delivers the newest of each channel.
  void Receive() {
    int status = Handle(kWait);
    const Time until = Clock::now() + kDrainTime;
    while (status > 0 && Clock::now() < until) status = Handle(Duration::zero());
    for (Subscription& subscription : subscriptions_) Deliver(&subscription);
    if (status < 0) Disconnect();
  }

  // > 0 when something came, 0 when nothing did, < 0 when the connection is lost. No lock: only this
  // thread replaces hub_ and lcm_.
  int Handle(Duration timeout) {
    if (hub_) return hub_->Receive(timeout, on_hub_message_);
    if (lcm_->getFileno() < 0) return -1;
    return lcm_->handleTimeout(static_cast<int>(timeout / milliseconds(1)));
  }

  void OnHubMessage(std::string_view channel, const void* data, std::size_t size) noexcept {
    GiveRaw(channel, data, size);
    for (Subscription& subscription : subscriptions_) {
      if (subscription.channel == channel) Accept(&subscription, data, size);
    }
  }

  // Called through C code: nothing may be thrown.
  static void OnLcmMessage(const lcm::ReceiveBuffer* buffer, const std::string& /*channel*/,
                           Subscription* subscription) noexcept {
    subscription->impl->Accept(subscription, buffer->data, buffer->data_size);
  }

  static void OnAnyMessage(const lcm::ReceiveBuffer* buffer, const std::string& channel,
                           Impl* impl) noexcept {
    impl->GiveRaw(channel, buffer->data, buffer->data_size);
  }

  void GiveRaw(std::string_view channel, const void* data, std::size_t size) noexcept {
    if (!on_any_) return;
    try {
      on_any_(channel, data, size);
    } catch (...) {
      ++callback_errors_;
    }
  }

  void Accept(Subscription* subscription, const void* data, std::size_t size) noexcept {
    ++received_;
    const Refusal refusal = subscription->handler.accept(data, size, Clock::now());
    if (refusal != Refusal::kNone) {
      ++refused_[static_cast<int>(refusal)];
      return;
    }
    if (subscription->pending) ++dropped_;
    subscription->pending = true;
    if (subscription->delivery == Delivery::kEvery) Deliver(subscription);
  }

  void Deliver(Subscription* subscription) noexcept {
    if (!subscription->pending) return;
    subscription->pending = false;
    try {
      subscription->handler.deliver();
      ++delivered_;
    } catch (...) {
      ++callback_errors_;
    }
  }

  bool Stopping() {
    const std::lock_guard<std::mutex> lock(stop_mutex_);
    return stop_;
  }

  void WaitForStop(Duration timeout) {
    std::unique_lock<std::mutex> lock(stop_mutex_);
    stop_changed_.wait_for(lock, timeout, [this] { return stop_; });
  }

  const LcmLinkOptions options_;
  std::optional<TcpAddress> tcp_;
  std::deque<Subscription> subscriptions_;  // LCM keeps pointers to them.
  RawHandler on_any_;
  const TcpqClient::Handler on_hub_message_{
      [this](std::string_view channel, const void* data, std::size_t size) {
        OnHubMessage(channel, data, size);
      }};

  // One of the two. Held while publishing and while they are replaced; receiving goes on meanwhile.
  std::mutex publish_mutex_;
  std::unique_ptr<TcpqClient> hub_;
  std::unique_ptr<lcm::LCM> lcm_;

  std::thread thread_;
  std::mutex stop_mutex_;
  std::condition_variable stop_changed_;
  bool stop_{false};

  std::atomic<std::int64_t> received_{0};
  std::atomic<std::int64_t> delivered_{0};
  std::atomic<std::int64_t> dropped_{0};
  std::array<std::atomic<std::int64_t>, kNumRefusals> refused_{};
  std::atomic<std::int64_t> callback_errors_{0};
  std::atomic<std::int64_t> published_{0};
  std::atomic<std::int64_t> unsent_{0};
  std::atomic<std::int64_t> connects_{0};
  std::atomic<bool> connected_{false};
};

LcmLink::LcmLink(const LcmLinkOptions& options) : impl_(std::make_unique<Impl>(options)) {}
LcmLink::~LcmLink() = default;

void LcmLink::AddHandler(const std::string& channel, Delivery delivery, Handler handler) {
  impl_->AddHandler(channel, delivery, std::move(handler));
}

void LcmLink::SubscribeAll(RawHandler on_message) {
  impl_->SubscribeAll(std::move(on_message));
}

void LcmLink::Start() {
  impl_->Start();
}

bool LcmLink::PublishBytes(const std::string& channel, const Bytes& bytes) {
  return impl_->PublishBytes(channel, bytes);
}

LinkStats LcmLink::stats() const {
  return impl_->stats();
}

}  // namespace vantage
