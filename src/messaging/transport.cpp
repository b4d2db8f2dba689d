#include "vantage/messaging/transport.h"

#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <random>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>

#include "file_descriptor.h"

namespace vantage {
namespace {

constexpr char kGroup[] = "239.255.76.67";
constexpr int kDatagrams = 3;  // One may be lost without harm.

std::string Because(const char* what) {
  return std::string(what) + ": " + std::strerror(errno);
}

// Joins the group on a port that the system chooses; "" or what failed.
std::string Join(int fd, sockaddr_in* address) {
  address->sin_family = AF_INET;
  address->sin_port = 0;
  inet_pton(AF_INET, kGroup, &address->sin_addr);
  socklen_t size = sizeof(*address);
  if (bind(fd, reinterpret_cast<sockaddr*>(address), size) != 0) return Because("bind");
  if (getsockname(fd, reinterpret_cast<sockaddr*>(address), &size) != 0) {
    return Because("getsockname");
  }
  ip_mreq membership{};
  membership.imr_multiaddr = address->sin_addr;
  membership.imr_interface.s_addr = htonl(INADDR_ANY);
  if (setsockopt(fd, IPPROTO_IP, IP_ADD_MEMBERSHIP, &membership, sizeof(membership)) != 0) {
    return Because("joining the group");
  }
  const unsigned char ttl = 0;
  const unsigned char loop = 1;
  if (setsockopt(fd, IPPROTO_IP, IP_MULTICAST_TTL, &ttl, sizeof(ttl)) != 0 ||
      setsockopt(fd, IPPROTO_IP, IP_MULTICAST_LOOP, &loop, sizeof(loop)) != 0) {
    return Because("setsockopt");
  }
  return "";
}

// Waits for a datagram with this content. Others may be about: anybody can send to the group.
bool Returns(int fd, std::uint64_t token, Time deadline) {
  for (;;) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - Clock::now()).count();
    if (left <= 0) return false;
    pollfd ready{fd, POLLIN, 0};
    if (poll(&ready, 1, static_cast<int>(left)) <= 0) continue;
    std::uint64_t got = 0;
    if (recv(fd, &got, sizeof(got), MSG_DONTWAIT) == sizeof(got) && got == token) return true;
  }
}

}  // namespace

MulticastTest TestMulticast(Duration timeout) {
  const Time deadline = Clock::now() + timeout;
  const FileDescriptor fd(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  if (!fd.valid()) return {false, Because("socket")};
  sockaddr_in address{};
  const std::string failure = Join(fd.get(), &address);
  if (!failure.empty()) return {false, failure};
  std::random_device random;
  const std::uint64_t token = std::uint64_t{random()} << 32 | random();
  for (int i = 0; i < kDatagrams; ++i) {
    if (sendto(fd.get(), &token, sizeof(token), 0, reinterpret_cast<const sockaddr*>(&address),
               sizeof(address)) != sizeof(token)) {
      return {false, Because("sending to the group")};
    }
  }
  if (!Returns(fd.get(), token, deadline))
    return {false, "what is sent to the group does not return"};
  return {true, ""};
}

std::string Transport::ReadyLine() const {
  return "LCM_DEFAULT_URL='" + url + "' tools/spy";
}

Transport ChooseTransport(const TransportOptions& options) {
  Transport transport;
  const char* chosen_by_user = std::getenv("LCM_DEFAULT_URL");
  if (chosen_by_user != nullptr && *chosen_by_user != '\0') {
    transport.url = chosen_by_user;
    return transport;
  }
  const MulticastTest multicast = options.test_multicast(options.test_timeout);
  if (multicast.works) {
    transport.url = kMulticastUrl;
    return transport;
  }
  transport.explanation = "LCM: multicast does not work here (" + multicast.reason +
                          ").\n     To mend it: " + kMulticastMend + "\n";
  const TcpHubOptions& hub = options.hub;
  if (options.join_existing_hub && hub.port != 0 &&
      ProbeTcpHub(hub.address, hub.port, options.test_timeout)) {
    transport.url = "tcpq://" + hub.address + ":" + std::to_string(hub.port);
    transport.explanation += "     Using the TCP hub that runs at " + transport.url + " instead.";
    return transport;
  }
  transport.hub = std::make_unique<TcpHub>(hub);
  transport.url = transport.hub->url();
  transport.explanation += "     Using a TCP hub of our own at " + transport.url + " instead.";
  return transport;
}

}  // namespace vantage
