// One message from a publisher to a subscriber on this machine: through the built-in hub, by multicast
// and, as bounds, through plain sockets. Latency is from the call that publishes to the call that
// delivers; `Burst` sends many at once and counts what arrives.
//
// The program moves to a network of its own where that is allowed, so that multicast works in it and
// nobody else's traffic disturbs.

#include <algorithm>
#include <atomic>
#include <cstring>
#include <functional>
#include <memory>
#include <thread>
#include <vector>

#include <benchmark/benchmark.h>
#include <lcm/lcm-cpp.hpp>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include "network_namespace.h"
#include "raw_client.h"
#include "samples.h"
#include "vantage/math/error.h"
#include "vantage/messaging/lcm_link.h"
#include "vantage/messaging/tcp_hub.h"
#include "vantage/messaging/transport.h"
#include "vantage/runtime/child_process.h"

namespace vantage {
namespace {

using std::chrono::milliseconds;

constexpr Duration kLost = std::chrono::seconds(1);

// Where a receiver thread notes arrivals and the benchmark's thread waits for them.
class Arrivals {
 public:
  Arrivals() : event_(eventfd(0, EFD_CLOEXEC)) {}
  ~Arrivals() { close(event_); }
  Arrivals(const Arrivals&) = delete;
  Arrivals& operator=(const Arrivals&) = delete;

  void Note() {
    last_.store(Clock::now().time_since_epoch().count());
    ++count_;
    const std::uint64_t one = 1;
    if (write(event_, &one, sizeof(one)) < 0) std::abort();
  }
  // False when nothing comes.
  bool Wait(Duration timeout) {
    pollfd ready{event_, POLLIN, 0};
    if (poll(&ready, 1, static_cast<int>(timeout / milliseconds(1))) <= 0) return false;
    std::uint64_t count = 0;
    return read(event_, &count, sizeof(count)) == sizeof(count);
  }
  [[nodiscard]] Time last() const { return Time(Duration(last_.load())); }
  [[nodiscard]] std::int64_t count() const { return count_.load(); }

 private:
  int event_;
  std::atomic<std::int64_t> last_{0};
  std::atomic<std::int64_t> count_{0};
};

// A way from a publisher to a subscriber.
class Path {
 public:
  virtual ~Path() = default;
  virtual void Send() = 0;
  Arrivals arrivals;
};

// --- Ours: encode, publish, receive, check, decode, call back ------------------------------------

class LinkPath : public Path {
 public:
  LinkPath(const std::string& url, std::size_t size)
      : image_(size > 1000), publisher_({url, "B_"}), subscriber_({url, "B_"}) {
    SubscribeOptions options;
    options.delivery = Delivery::kEvery;
    options.stamps.in_order = false;
    subscriber_.Subscribe<JointState>(
        "STATE", [this](const JointState&) { arrivals.Note(); }, options);
    subscriber_.Subscribe<CameraImage>(
        "IMAGE", [this](const CameraImage&) { arrivals.Note(); }, options);
    picture_.width = 640;
    picture_.height = 480;
    picture_.row_stride = 640;
    picture_.data.resize(640 * 480);
    state_ = test::SampleJointState();
    subscriber_.Start();
    publisher_.Start();
  }
  void Send() override {
    if (image_) {
      picture_.stamp = Clock::now();
      publisher_.Publish("IMAGE", picture_);
    } else {
      state_.stamp = Clock::now();
      publisher_.Publish("STATE", state_);
    }
  }

 private:
  bool image_;
  JointState state_;
  CameraImage picture_;
  LcmLink publisher_;
  LcmLink subscriber_;
};

// --- LCM's own library: bytes in, bytes out ------------------------------------------------------

class StockPath : public Path {
 public:
  StockPath(const std::string& url, std::size_t size)
      : bytes_(size), publisher_(url), subscriber_(url) {
    if (!publisher_.good() || !subscriber_.good()) throw Error("LCM: no " + url);
    using Handler = void (*)(const lcm::ReceiveBuffer*, const std::string&, StockPath*);
    const Handler handler = [](const lcm::ReceiveBuffer*, const std::string&, StockPath* self) {
      self->arrivals.Note();
    };
    subscriber_.subscribeFunction("BENCH", handler, this)->setQueueCapacity(1000);
    thread_ = std::thread([this] {
      while (!stop_ && subscriber_.getFileno() >= 0) subscriber_.handleTimeout(20);
    });
  }
  ~StockPath() override {
    stop_ = true;
    thread_.join();
  }
  void Send() override {
    publisher_.publish("BENCH", bytes_.data(), static_cast<unsigned>(bytes_.size()));
  }

 private:
  Bytes bytes_;
  lcm::LCM publisher_;
  lcm::LCM subscriber_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

// --- Bounds: plain sockets -----------------------------------------------------------------------

// Two ends of a connection on this machine.
struct SocketPair {
  int out{-1}, in{-1};
};

SocketPair MakePair(int type) {
  const int server = socket(AF_INET, type, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t length = sizeof(address);
  bind(server, reinterpret_cast<sockaddr*>(&address), length);
  getsockname(server, reinterpret_cast<sockaddr*>(&address), &length);
  if (type == SOCK_STREAM) listen(server, 1);
  SocketPair pair;
  pair.out = socket(AF_INET, type, 0);
  connect(pair.out, reinterpret_cast<sockaddr*>(&address), length);
  pair.in = type == SOCK_STREAM ? accept(server, nullptr, nullptr) : server;
  if (type == SOCK_STREAM) close(server);
  const int one = 1;
  setsockopt(pair.out, IPPROTO_TCP, TCP_NODELAY, &one, sizeof(one));
  const int buffer = 2 * 1024 * 1024;
  setsockopt(pair.in, SOL_SOCKET, SO_RCVBUF, &buffer, sizeof(buffer));
  const timeval timeout{0, 20'000};
  setsockopt(pair.in, SOL_SOCKET, SO_RCVTIMEO, &timeout, sizeof(timeout));
  return pair;
}

// Passes on whatever comes, as it comes: the least that a hub does.
class Relay {
 public:
  Relay(int from, int to) : from_(from), to_(to), thread_([this] { Run(); }) {}
  ~Relay() {
    stop_ = true;
    thread_.join();
    close(from_);
    close(to_);
  }

 private:
  void Run() {
    Bytes buffer(1 << 20);
    while (!stop_) {
      const ssize_t got = recv(from_, buffer.data(), buffer.size(), 0);
      if (got > 0 && send(to_, buffer.data(), static_cast<std::size_t>(got), MSG_NOSIGNAL) < 0)
        return;
    }
  }

  int from_, to_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

class SocketPath : public Path {
 public:
  SocketPath(int type, std::size_t size, bool relayed)
      : bytes_(size), stream_(type == SOCK_STREAM) {
    const SocketPair pair = MakePair(type);
    out_ = pair.out;
    in_ = pair.in;
    if (relayed) {
      const SocketPair onward = MakePair(type);
      relay_ = std::make_unique<Relay>(pair.in, onward.out);
      in_ = onward.in;
    }
    thread_ = std::thread([this] { Receive(); });
  }
  ~SocketPath() override {
    stop_ = true;
    thread_.join();
    close(in_);
    close(out_);
  }
  void Send() override {
    // A datagram holds 64 KiB: larger messages go in pieces, as LCM sends them.
    const std::size_t most = stream_ ? bytes_.size() : 60'000;
    for (std::size_t at = 0; at < bytes_.size(); at += most) {
      const std::size_t size = std::min(most, bytes_.size() - at);
      if (send(out_, bytes_.data() + at, size, MSG_NOSIGNAL) < 0) return;
    }
  }

 private:
  void Receive() {
    Bytes buffer(bytes_.size() + 65'536);
    std::size_t have = 0;
    while (!stop_) {
      const ssize_t got = recv(in_, buffer.data(), buffer.size(), 0);
      if (got <= 0) continue;
      have += static_cast<std::size_t>(got);
      for (; have >= bytes_.size(); have -= bytes_.size()) arrivals.Note();
    }
  }

  Bytes bytes_;
  bool stream_;
  int in_{-1};
  int out_{-1};
  std::unique_ptr<Relay> relay_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

// --- Transports ----------------------------------------------------------------------------------

// LCM's own hub, for comparison.
class JavaHub {
 public:
  explicit JavaHub(std::uint16_t port) : process_(Options(port)) {
    const Time until = Clock::now() + std::chrono::seconds(20);
    while (!ProbeTcpHub("127.0.0.1", port, milliseconds(100))) {
      if (Clock::now() > until || process_.Poll()) throw Error("no Java hub");
      std::this_thread::sleep_for(milliseconds(50));
    }
  }

 private:
  static ChildOptions Options(std::uint16_t port) {
    ChildOptions options;
    options.arguments = {"java", "-cp", "/usr/share/java/lcm.jar", "lcm.lcm.TCPService",
                         std::to_string(port)};
    options.output = "/dev/null";
    return options;
  }
  ChildProcess process_;
};

enum class Kind {
  kHubOurs,
  kHubOursStopped,
  kHubStock,
  kJavaHubStock,
  kMulticastOurs,
  kMulticastStock,
  kTcp,
  kTcpRelay,
  kUdp
};

// Subscribes to everything, reads nothing, as a program that is stopped in a debugger; returns when the hub
// has begun to drop messages for it.
std::unique_ptr<test::RawClient> MakeStoppedClient(const TcpHub& hub) {
  auto client = std::make_unique<test::RawClient>(hub.port());
  if (!client->Subscribe(".*") || !client->Sync()) throw Error("no stopped client");
  LcmLink filler({hub.url(), ""});
  filler.Start();
  const Bytes megabyte(1 << 20);
  const Time until = Clock::now() + std::chrono::seconds(5);
  while (hub.stats().dropped == 0) {
    filler.PublishBytes("FILL", megabyte);
    if (Clock::now() > until) throw Error("the stopped client takes everything");
  }
  return client;
}

struct Setup {
  std::unique_ptr<TcpHub> hub;
  std::unique_ptr<test::RawClient> stopped_client;
  std::unique_ptr<JavaHub> java_hub;
  std::unique_ptr<Path> path;
};

Setup MakeSetup(Kind kind, std::size_t size) {
  Setup setup;
  switch (kind) {
    case Kind::kHubOurs:
    case Kind::kHubOursStopped:
    case Kind::kHubStock: {
      TcpHubOptions options;
      options.port = 0;
      setup.hub = std::make_unique<TcpHub>(options);
      if (kind == Kind::kHubOursStopped) setup.stopped_client = MakeStoppedClient(*setup.hub);
      break;
    }
    case Kind::kJavaHubStock:
      setup.java_hub = std::make_unique<JavaHub>(7790);
      break;
    case Kind::kMulticastOurs:
    case Kind::kMulticastStock:
      if (!TestMulticast().works) throw Error("multicast does not work here");
      break;
    case Kind::kTcp:
    case Kind::kTcpRelay:
    case Kind::kUdp:
      break;
  }
  switch (kind) {
    case Kind::kHubOurs:
    case Kind::kHubOursStopped:
      setup.path = std::make_unique<LinkPath>(setup.hub->url(), size);
      break;
    case Kind::kHubStock:
      setup.path = std::make_unique<StockPath>(setup.hub->url(), size);
      break;
    case Kind::kJavaHubStock:
      setup.path = std::make_unique<StockPath>("tcpq://127.0.0.1:7790", size);
      break;
    case Kind::kMulticastOurs:
      setup.path = std::make_unique<LinkPath>(MulticastUrl(), size);
      break;
    case Kind::kMulticastStock:
      setup.path = std::make_unique<StockPath>(MulticastUrl(), size);
      break;
    case Kind::kTcp:
      setup.path = std::make_unique<SocketPath>(SOCK_STREAM, size, false);
      break;
    case Kind::kTcpRelay:
      setup.path = std::make_unique<SocketPath>(SOCK_STREAM, size, true);
      break;
    case Kind::kUdp:
      setup.path = std::make_unique<SocketPath>(SOCK_DGRAM, size, false);
      break;
  }
  // Subscriptions travel: go on until one message is through, and nothing is left on the way.
  const Time until = Clock::now() + std::chrono::seconds(5);
  do {
    setup.path->Send();
  } while (!setup.path->arrivals.Wait(milliseconds(50)) && Clock::now() < until);
  while (setup.path->arrivals.Wait(milliseconds(50))) {
  }
  return setup;
}

double Microseconds(Duration d) {
  return 1e-3 * static_cast<double>(d.count());
}

void Latency(benchmark::State& state, Kind kind, std::size_t size, Duration pause) {
  try {
    Setup setup = MakeSetup(kind, size);
    std::vector<Duration> samples;
    std::int64_t lost = 0;
    for (auto _ : state) {
      // At the pace of real traffic: a path that is used without pause stays warm.
      std::this_thread::sleep_for(pause);
      const Time sent = Clock::now();
      setup.path->Send();
      const bool arrived = setup.path->arrivals.Wait(kLost);
      lost += arrived ? 0 : 1;
      samples.push_back(arrived ? setup.path->arrivals.last() - sent : kLost);
      state.SetIterationTime(ToSeconds(samples.back()));
    }
    std::sort(samples.begin(), samples.end());
    const auto percentile = [&](double fraction) {
      const auto rank =
          static_cast<std::size_t>(fraction * static_cast<double>(samples.size() - 1));
      return Microseconds(samples[rank]);
    };
    state.counters["p50_us"] = percentile(0.5);
    state.counters["p99_us"] = percentile(0.99);
    state.counters["lost"] = static_cast<double>(lost);
  } catch (const Error& error) {
    state.SkipWithError(error.what());
  }
}

void Burst(benchmark::State& state, Kind kind, std::size_t size) {
  try {
    Setup setup = MakeSetup(kind, size);
    constexpr std::int64_t kMessages = 200;
    std::int64_t sent = 0;
    const std::int64_t before = setup.path->arrivals.count();
    for (auto _ : state) {
      const std::int64_t base = setup.path->arrivals.count();
      const Time begin = Clock::now();
      for (std::int64_t i = 0; i < kMessages; ++i) setup.path->Send();
      sent += kMessages;
      while (setup.path->arrivals.count() < base + kMessages) {
        if (!setup.path->arrivals.Wait(milliseconds(100))) break;  // The rest is lost.
      }
      state.SetIterationTime(std::max(1e-9, ToSeconds(setup.path->arrivals.last() - begin)));
    }
    const std::int64_t arrived = setup.path->arrivals.count() - before;
    state.counters["per_s"] =
        benchmark::Counter(static_cast<double>(arrived), benchmark::Counter::kIsRate);
    state.counters["lost_percent"] =
        100.0 * static_cast<double>(sent - arrived) / static_cast<double>(sent);
  } catch (const Error& error) {
    state.SkipWithError(error.what());
  }
}

void RegisterAll() {
  struct Named {
    const char* name;
    Kind kind;
  };
  constexpr Named kKinds[] = {{"hub", Kind::kHubOurs},
                              {"hub_beside_a_stopped_client", Kind::kHubOursStopped},
                              {"hub_stock_client", Kind::kHubStock},
                              {"java_hub_stock_client", Kind::kJavaHubStock},
                              {"multicast", Kind::kMulticastOurs},
                              {"multicast_stock_client", Kind::kMulticastStock},
                              {"raw_tcp", Kind::kTcp},
                              {"raw_tcp_relay", Kind::kTcpRelay},
                              {"raw_udp", Kind::kUdp}};
  struct Size {
    const char* name;
    std::size_t bytes;
    int messages;
    Duration pause;
    int bursts;
  };
  constexpr Size kSizes[] = {{"state", 124, 1000, milliseconds(2), 20},
                             {"vga", 640 * 480, 100, milliseconds(20), 3}};
  for (const Size& size : kSizes) {
    for (const Named& kind : kKinds) {
      const bool slow = kind.kind == Kind::kJavaHubStock;
      const std::string suffix = std::string("/") + kind.name + "/" + size.name;
      benchmark::RegisterBenchmark(("Latency" + suffix).c_str(), Latency, kind.kind, size.bytes,
                                   size.pause)
          ->UseManualTime()
          ->Unit(benchmark::kMicrosecond)
          ->Iterations(slow ? size.messages / 20 : size.messages);
      benchmark::RegisterBenchmark(("Burst" + suffix).c_str(), Burst, kind.kind, size.bytes)
          ->UseManualTime()
          ->Unit(benchmark::kMillisecond)
          ->Iterations(slow ? 1 : size.bursts);
    }
  }
}

}  // namespace
}  // namespace vantage

int main(int argc, char** argv) {
  // Before any thread.
  if (vantage::test::EnterEmptyNetwork()) vantage::test::AddRouteForLcm();
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  vantage::RegisterAll();
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
