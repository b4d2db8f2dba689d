#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "vantage/math/time.h"

namespace vantage {

/// Where a hub is when nothing else is said: this machine alone, and LCM's port.
inline constexpr char kDefaultHubAddress[] = "127.0.0.1";
inline constexpr std::uint16_t kDefaultHubPort = 7700;

/// Where a hub listens, and what it keeps for slow clients.
struct TcpHubOptions {
  std::uint16_t port{kDefaultHubPort};  ///< First port tried; 0 lets the system choose.
  int ports_tried{100};                 ///< Ports tried one after another while they are in use.
  /// Address to listen at. The default serves this machine alone; anything else lets every machine
  /// that reaches the port read and write all channels.
  std::string address{kDefaultHubAddress};
  int max_clients{128};  ///< At the same time; further ones are closed as they connect.
  std::size_t max_message{std::size_t{16} << 20};  ///< Largest message taken [byte].
  /// Bytes that may wait for one client beyond what the system buffers; the oldest messages give way.
  std::size_t max_backlog{std::size_t{4} << 20};
  Duration handshake_timeout{std::chrono::seconds(5)};  ///< For a client to say who it is.
};

/// Counters of a hub since its start.
struct TcpHubStats {
  int clients{0};               ///< Connected now.
  std::int64_t connections{0};  ///< Taken since the start.
  std::int64_t turned_away{0};  ///< Connections beyond max_clients.
  std::int64_t protocol_errors{
      0};                     ///< Clients cut off: garbage, too large a message, no handshake.
  std::int64_t received{0};   ///< Messages published to the hub.
  std::int64_t delivered{0};  ///< Messages handed to the system for a subscriber.
  std::int64_t dropped{0};    ///< Messages that a client was too slow to get.
};

/// Server for LCM's tcpq:// transport, for machines where multicast does not work: every message that
/// a client publishes goes to the clients that subscribed to its channel. One thread; no client can
/// slow another: a message is passed on at once to who can take it, and waits, up to a bound, for who
/// cannot. Any LCM program can be a client (lcm-spy, lcm-logger, ...).
class TcpHub {
 public:
  /// Listens and serves. Throws Error when none of the ports can be had, with the system's reason.
  explicit TcpHub(const TcpHubOptions& options = {});
  /// Closes all connections.
  ~TcpHub();
  TcpHub(const TcpHub&) = delete;
  TcpHub& operator=(const TcpHub&) = delete;

  [[nodiscard]] std::uint16_t port() const noexcept;
  /// For LCM_DEFAULT_URL: "tcpq://127.0.0.1:7700".
  [[nodiscard]] std::string url() const;
  [[nodiscard]] TcpHubStats stats() const;

 private:
  class Server;
  std::unique_ptr<Server> server_;
};

/// Whether an LCM hub answers at host:port (IPv4) within `timeout`, name look-up not counted. Connects
/// as a client would and says goodbye.
[[nodiscard]] bool ProbeTcpHub(const std::string& host, std::uint16_t port, Duration timeout);

}  // namespace vantage
