#include "vantage/messaging/tcp_hub.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <deque>
#include <string_view>
#include <thread>
#include <unordered_map>
#include <vector>

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/tcp.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <sys/uio.h>

#include "channel_pattern.h"
#include "file_descriptor.h"
#include "input_buffer.h"
#include "socket_util.h"
#include "tcpq_client.h"
#include "tcpq_protocol.h"
#include "vantage/math/error.h"

namespace vantage {
namespace {

using Bytes = std::vector<std::uint8_t>;
using Frame = std::shared_ptr<const Bytes>;
using tcpq::Message;

constexpr std::size_t kMaxSubscriptions = 1024;  // Of one client.
constexpr std::size_t kMaxRoutes = 4096;         // Channels whose subscribers are remembered.
constexpr int kSendBuffer =
    512 * 1024;                 // Asked of the system: what a slow client can lag, at least.
constexpr int kMaxPieces = 64;  // Frames in one sendmsg.

struct Client {
  FileDescriptor fd;
  Time since{};
  bool greeted{false};
  bool dead{false};
  bool flush{false};  // Has got something in this round.
  bool waits_to_write{false};
  bool in_pieces{false};  // See AcknowledgeInPieces().
  InputBuffer in;
  std::vector<ChannelPattern> subscriptions;
  std::deque<Frame> out;
  std::size_t out_begin{0};  // Bytes of out.front() that are sent.
  std::size_t out_bytes{0};  // Of all in `out`, sent ones included.
};

sockaddr_in SocketAddress(const std::string& address, std::uint16_t port) {
  sockaddr_in result{};
  result.sin_family = AF_INET;
  result.sin_port = htons(port);
  if (inet_pton(AF_INET, address.c_str(), &result.sin_addr) != 1) {
    throw Error(address + ": not an IPv4 address in numbers");
  }
  return result;
}

FileDescriptor Listen(const TcpHubOptions& options, std::uint16_t* port) {
  int error = EADDRINUSE;
  for (int i = 0; i < std::max(1, options.ports_tried) && error == EADDRINUSE; ++i) {
    const int candidate = options.port == 0 ? 0 : options.port + i;
    if (candidate > 65535) break;
    sockaddr_in address = SocketAddress(options.address, static_cast<std::uint16_t>(candidate));
    FileDescriptor fd(socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
    if (!fd.valid()) {
      error = errno;
      break;
    }
    // A hub that restarts shall not wait for the connections of the one before to fade out.
    SetOption(fd.get(), SOL_SOCKET, SO_REUSEADDR, 1);
    socklen_t size = sizeof(address);
    if (bind(fd.get(), reinterpret_cast<sockaddr*>(&address), size) == 0 &&
        listen(fd.get(), SOMAXCONN) == 0 &&
        getsockname(fd.get(), reinterpret_cast<sockaddr*>(&address), &size) == 0) {
      *port = ntohs(address.sin_port);
      return fd;
    }
    error = errno;
  }
  throw Error("LCM hub: no port to listen at from " + options.address + ":" +
              std::to_string(options.port) + " on: " + std::strerror(error));
}

}  // namespace

class TcpHub::Server {
 public:
  explicit Server(const TcpHubOptions& options)
      : options_(options),
        listener_(Listen(options, &port_)),
        epoll_(epoll_create1(EPOLL_CLOEXEC)),
        wake_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)),
        spare_(open("/dev/null", O_RDONLY | O_CLOEXEC)) {
    if (!epoll_.valid() || !wake_.valid()) {
      throw Error(std::string("LCM hub: ") + std::strerror(errno));
    }
    Watch(listener_.get(), EPOLLIN, EPOLL_CTL_ADD);
    Watch(wake_.get(), EPOLLIN, EPOLL_CTL_ADD);
    thread_ = std::thread([this] { Run(); });
  }

  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  ~Server() {
    stop_.store(true);
    const std::uint64_t one = 1;
    // Cannot fail: the counter starts at zero and is written once.
    [[maybe_unused]] const auto written = write(wake_.get(), &one, sizeof(one));
    thread_.join();
  }

  [[nodiscard]] std::uint16_t port() const noexcept { return port_; }
  [[nodiscard]] std::string url() const {
    const std::string host = options_.address == "0.0.0.0" ? kDefaultHubAddress : options_.address;
    return "tcpq://" + host + ":" + std::to_string(port_);
  }

  [[nodiscard]] TcpHubStats stats() const {
    TcpHubStats stats;
    stats.clients = num_clients_.load();
    stats.connections = connections_.load();
    stats.turned_away = turned_away_.load();
    stats.protocol_errors = protocol_errors_.load();
    stats.received = received_.load();
    stats.delivered = delivered_.load();
    stats.dropped = dropped_.load();
    return stats;
  }

 private:
  void Watch(int fd, std::uint32_t events, int operation) {
    epoll_event event{};
    event.events = events;
    event.data.fd = fd;
    epoll_ctl(epoll_.get(), operation, fd, &event);
  }

  void Run() {
    // Signals are for the program's own threads.
    sigset_t all;
    sigfillset(&all);
    pthread_sigmask(SIG_BLOCK, &all, nullptr);

    std::array<epoll_event, 64> events{};
    while (!stop_.load()) {
      const int count = epoll_wait(epoll_.get(), events.data(), static_cast<int>(events.size()),
                                   strangers_ > 0 ? 200 : -1);
      for (int i = 0; i < count; ++i) {
        const int fd = events[i].data.fd;
        if (fd == listener_.get()) {
          Accept();
        } else if (const auto client = clients_.find(fd); client != clients_.end()) {
          Serve(client->second.get(), events[i].events);
        }
      }
      if (strangers_ > 0) CutOffStrangers();
      RemoveDead();
    }
  }

  void Accept() {
    FileDescriptor fd(accept4(listener_.get(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
    if (!fd.valid() && (errno == EMFILE || errno == ENFILE)) {
      // Without a free descriptor the connection would stay in the queue and wake us for ever: take it
      // with the one kept for this, and turn it away.
      spare_.Reset();
      fd = FileDescriptor(accept4(listener_.get(), nullptr, nullptr, SOCK_CLOEXEC));
      fd.Reset();
      spare_ = FileDescriptor(open("/dev/null", O_RDONLY | O_CLOEXEC));
      ++turned_away_;
      return;
    }
    if (!fd.valid()) return;
    if (static_cast<int>(clients_.size()) >= options_.max_clients) {
      ++turned_away_;
      return;
    }
    SetOption(fd.get(), IPPROTO_TCP, TCP_NODELAY, 1);
    SetOption(fd.get(), IPPROTO_TCP, TCP_QUICKACK, 1);
    // A machine that went away without a word is noticed within half a minute.
    SetOption(fd.get(), SOL_SOCKET, SO_KEEPALIVE, 1);
    SetOption(fd.get(), IPPROTO_TCP, TCP_KEEPIDLE, 10);
    SetOption(fd.get(), IPPROTO_TCP, TCP_KEEPINTVL, 5);
    SetOption(fd.get(), IPPROTO_TCP, TCP_KEEPCNT, 4);
    SetOption(fd.get(), SOL_SOCKET, SO_SNDBUF, kSendBuffer);
    const tcpq::Hello hello = tcpq::MakeHello(tcpq::kServerMagic);
    // Into an empty buffer: all of it, or the client is gone.
    if (send(fd.get(), hello.data(), hello.size(), MSG_NOSIGNAL) !=
        static_cast<ssize_t>(hello.size()))
      return;

    const int key = fd.get();
    auto client = std::make_unique<Client>();
    client->fd = std::move(fd);
    client->since = Clock::now();
    clients_.emplace(key, std::move(client));
    Watch(key, EPOLLIN, EPOLL_CTL_ADD);
    ++strangers_;
    ++connections_;
    num_clients_.store(static_cast<int>(clients_.size()));
  }

  void Serve(Client* client, std::uint32_t events) {
    try {
      if ((events & EPOLLOUT) != 0 && !client->dead) Send(client);
      if ((events & (EPOLLIN | EPOLLHUP | EPOLLERR)) != 0 && !client->dead) Receive(client);
    } catch (const std::bad_alloc&) {
      Kill(client);
    }
    SendToTouched();
  }

  void Receive(Client* client) {
    const ssize_t got = client->in.Receive(client->fd.get());
    if (got < 0 && (errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR)) return;
    if (got <= 0) return Kill(client);
    while (!client->dead) {
      const std::uint8_t* data = client->in.data();
      const std::size_t size = client->in.size();
      const Message message = client->greeted ? tcpq::ReadMessage(data, size, options_.max_message)
                                              : tcpq::ReadHello(data, size, tcpq::kClientMagic);
      if (message.kind == Message::Kind::kIncomplete) break;
      Handle(client, message, data);
      client->in.Consume(message.size);
    }
    AcknowledgeInPieces(client->fd.get(), client->in.size() > 0, &client->in_pieces);
  }

  // Once for all that one client's input brought: one sendmsg for each subscriber.
  void SendToTouched() {
    for (Client* client : touched_) {
      client->flush = false;
      if (!client->dead && !client->waits_to_write) Send(client);
    }
    touched_.clear();
  }

  void Handle(Client* client, const Message& message, const std::uint8_t* data) {
    switch (message.kind) {
      case Message::Kind::kHello:
        client->greeted = true;
        --strangers_;
        break;
      case Message::Kind::kPublish:
        Relay(message, data);
        break;
      case Message::Kind::kSubscribe:
        Subscribe(client, std::string(message.name));
        break;
      case Message::Kind::kUnsubscribe:
        Unsubscribe(client, message.name);
        break;
      case Message::Kind::kError:
        ++protocol_errors_;
        Kill(client);
        break;
      case Message::Kind::kIncomplete:
        break;
    }
  }

  void Subscribe(Client* client, const std::string& pattern) {
    auto compiled = ChannelPattern::Compile(pattern);
    if (!compiled || client->subscriptions.size() >= kMaxSubscriptions) {
      ++protocol_errors_;
      return Kill(client);
    }
    client->subscriptions.push_back(std::move(*compiled));
    routes_.clear();
  }

  void Unsubscribe(Client* client, std::string_view pattern) {
    auto& subscriptions = client->subscriptions;
    const auto found = std::find_if(subscriptions.begin(), subscriptions.end(),
                                    [&](const auto& s) { return s.text() == pattern; });
    if (found == subscriptions.end()) return;
    subscriptions.erase(found);
    routes_.clear();
  }

  // The clients that subscribed to a channel, remembered until a subscription changes.
  const std::vector<Client*>& Route(std::string_view channel) {
    const std::string key(channel);
    if (const auto known = routes_.find(key); known != routes_.end()) return known->second;
    // Somebody makes up channel names: forget them all rather than fill the memory.
    if (routes_.size() >= kMaxRoutes) routes_.clear();
    std::vector<Client*>& route = routes_[key];
    for (const auto& [fd, client] : clients_) {
      const auto& subscriptions = client->subscriptions;
      if (!client->dead && std::any_of(subscriptions.begin(), subscriptions.end(),
                                       [&](const auto& s) { return s.Matches(channel); })) {
        route.push_back(client.get());
      }
    }
    return route;
  }

  void Relay(const Message& message, const std::uint8_t* data) {
    ++received_;
    const std::vector<Client*>& route = Route(message.name);
    if (route.empty()) return;
    // What goes out has the form of what came in.
    const auto frame = std::make_shared<const Bytes>(data, data + message.size);
    for (Client* client : route) {
      if (!client->dead) Enqueue(client, frame);
    }
  }

  void Enqueue(Client* client, const Frame& frame) {
    auto& out = client->out;
    // The oldest give way, but not one that is half sent.
    const std::ptrdiff_t first = client->out_begin > 0 ? 1 : 0;
    while (client->out_bytes + frame->size() > options_.max_backlog &&
           static_cast<std::ptrdiff_t>(out.size()) > first) {
      client->out_bytes -= out[static_cast<std::size_t>(first)]->size();
      out.erase(out.begin() + first);
      ++dropped_;
    }
    out.push_back(frame);
    client->out_bytes += frame->size();
    if (!client->flush) {
      client->flush = true;
      touched_.push_back(client);
    }
  }

  void Send(Client* client) {
    while (!client->out.empty()) {
      std::array<iovec, kMaxPieces> pieces{};
      const std::size_t count = std::min<std::size_t>(client->out.size(), pieces.size());
      for (std::size_t i = 0; i < count; ++i) {
        const Bytes& bytes = *client->out[i];
        const std::size_t skip = i == 0 ? client->out_begin : 0;
        // sendmsg does not write through its pointers.
        pieces[i] = {const_cast<std::uint8_t*>(bytes.data()) + skip, bytes.size() - skip};
      }
      msghdr header{};
      header.msg_iov = pieces.data();
      header.msg_iovlen = count;
      const ssize_t sent = sendmsg(client->fd.get(), &header, MSG_NOSIGNAL | MSG_DONTWAIT);
      if (sent < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) break;
      if (sent < 0 && errno == EINTR) continue;
      if (sent < 0) return Kill(client);
      Forget(client, static_cast<std::size_t>(sent));
    }
    const bool waits = !client->out.empty();
    if (waits != client->waits_to_write) {
      client->waits_to_write = waits;
      Watch(client->fd.get(), waits ? EPOLLIN | EPOLLOUT : EPOLLIN, EPOLL_CTL_MOD);
    }
  }

  // Takes `sent` bytes off the front of what waits for the client.
  void Forget(Client* client, std::size_t sent) {
    client->out_begin += sent;
    while (!client->out.empty() && client->out_begin >= client->out.front()->size()) {
      client->out_begin -= client->out.front()->size();
      client->out_bytes -= client->out.front()->size();
      client->out.pop_front();
      ++delivered_;
    }
  }

  void CutOffStrangers() {
    const Time now = Clock::now();
    for (const auto& [fd, client] : clients_) {
      if (!client->greeted && !client->dead && now - client->since > options_.handshake_timeout) {
        ++protocol_errors_;
        Kill(client.get());
      }
    }
  }

  // Marks only: others may hold the pointer until the end of the round.
  void Kill(Client* client) {
    if (client->dead) return;
    client->dead = true;
    any_dead_ = true;
    if (!client->greeted) --strangers_;
    routes_.clear();
  }

  void RemoveDead() {
    if (!any_dead_) return;
    any_dead_ = false;
    for (auto it = clients_.begin(); it != clients_.end();) {
      it = it->second->dead ? clients_.erase(it) : std::next(it);
    }
    num_clients_.store(static_cast<int>(clients_.size()));
  }

  const TcpHubOptions options_;
  std::uint16_t port_{0};
  FileDescriptor listener_;
  FileDescriptor epoll_;
  FileDescriptor wake_;
  FileDescriptor spare_;
  std::thread thread_;
  std::atomic<bool> stop_{false};

  // The server thread's alone.
  std::unordered_map<int, std::unique_ptr<Client>> clients_;
  std::unordered_map<std::string, std::vector<Client*>> routes_;
  std::vector<Client*> touched_;
  int strangers_{0};  // Clients that have not said hello.
  bool any_dead_{false};

  std::atomic<int> num_clients_{0};
  std::atomic<std::int64_t> connections_{0};
  std::atomic<std::int64_t> turned_away_{0};
  std::atomic<std::int64_t> protocol_errors_{0};
  std::atomic<std::int64_t> received_{0};
  std::atomic<std::int64_t> delivered_{0};
  std::atomic<std::int64_t> dropped_{0};
};

TcpHub::TcpHub(const TcpHubOptions& options) : server_(std::make_unique<Server>(options)) {}
TcpHub::~TcpHub() = default;

std::uint16_t TcpHub::port() const noexcept {
  return server_->port();
}
std::string TcpHub::url() const {
  return server_->url();
}
TcpHubStats TcpHub::stats() const {
  return server_->stats();
}

bool ProbeTcpHub(const std::string& host, std::uint16_t port, Duration timeout) {
  return TcpqClient::Connect(host, port, timeout) != nullptr;
}

}  // namespace vantage
