#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "vantage/math/time.h"
#include "vantage/messaging/tcp_hub.h"

/// @file
/// Which LCM transport a program uses: what the user says in LCM_DEFAULT_URL; else multicast, if a
/// quick test shows that it works here; else a TCP hub on this machine.

namespace vantage {

/// LCM's usual port.
inline constexpr int kLcmPort = 7667;
/// Multicast on this machine alone (ttl 0), with a receive buffer that holds images: with the system's
/// default most of a VGA stream is lost.
[[nodiscard]] std::string MulticastUrl(int port = kLcmPort);
/// What makes multicast work on a machine that has no route for it.
inline constexpr char kMulticastMend[] = "sudo ip route add 239.255.76.67/32 dev lo";

/// Outcome of the multicast test.
struct MulticastTest {
  bool works{false};   ///< A datagram sent to the group came back.
  std::string reason;  ///< What failed, when it does not work.
};

/// Sends datagrams to LCM's multicast group on a port of its own and waits for them to come back, at
/// most `timeout`. They do not leave the machine (ttl 0).
[[nodiscard]] MulticastTest TestMulticast(Duration timeout = std::chrono::milliseconds(200));

/// How ChooseTransport() chooses.
struct TransportOptions {
  /// A single program joins whoever talks at LCM's usual port, or the hub that answers at its port.
  /// Programs that start others keep to themselves, so that two runs on one machine do not mix: they take
  /// the first multicast port from `multicast_port` on that nobody else has taken or is heard at, or make
  /// a hub of their own.
  bool join_existing{false};
  int multicast_port{kLcmPort};  ///< The port to join, or the first one tried.
  Duration listen_time{
      std::chrono::milliseconds(120)};  ///< How long to listen for others at a port.
  TcpHubOptions hub;  ///< Of a hub to join or to make, where multicast does not work.
  /// Longest wait for a datagram of the multicast test, and for a hub to answer.
  Duration test_timeout{std::chrono::milliseconds(200)};
  /// For tests: the multicast test to use.
  std::function<MulticastTest(Duration)> test_multicast{
      [](Duration timeout) { return TestMulticast(timeout); }};
};

/// A chosen transport.
struct Transport {
  std::string url;  ///< For LcmLink, and for LCM_DEFAULT_URL of child processes.
  std::string
      explanation;  ///< Lines for the user: why this one, and what to do about it; or empty.
  std::unique_ptr<TcpHub> hub;  ///< The hub this program runs, or null. Lives as long as this.
  /// Keeps other runs off the multicast port, while it lives; or null.
  std::shared_ptr<void> claim;

  /// What to type in another terminal to watch: "LCM_DEFAULT_URL='...' tools/spy".
  [[nodiscard]] std::string ReadyLine() const;
};

/// Chooses. Throws ConfigError when LCM_DEFAULT_URL is no URL of LCM's, Error when a hub is needed and cannot
/// be had.
[[nodiscard]] Transport ChooseTransport(const TransportOptions& options = {});

/// The same for a single program: with `join_existing`.
[[nodiscard]] Transport JoinTransport();

}  // namespace vantage
