#include "vantage/messaging/transport.h"

#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <random>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>

#include "file_descriptor.h"
#include "socket_util.h"
#include "vantage/messaging/lcm_link.h"

namespace vantage {
namespace {

constexpr char kGroup[] = "239.255.76.67";
constexpr int kPortsTried = 32;
constexpr int kDatagrams = 3;  // One may be lost without harm.

std::string Because(const char* what) {
  return std::string(what) + ": " + std::strerror(errno);
}

// Joins the group on the port in *address (0: one that the system chooses); "" or what failed.
std::string Join(int fd, sockaddr_in* address) {
  address->sin_family = AF_INET;
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

// Takes a multicast port for this run, as other runs see it: by the name of a local socket, which goes with the
// process whatever way it ends. Null: another run has it.
std::shared_ptr<void> ClaimPort(int port) {
  auto fd = std::make_shared<FileDescriptor>(socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  const std::string name = "vantage-lcm-" + std::to_string(port);
  name.copy(address.sun_path + 1, sizeof(address.sun_path) - 1);  // a leading 0: no file
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + name.size());
  if (!fd->valid() || bind(fd->get(), reinterpret_cast<const sockaddr*>(&address), size) != 0)
    return nullptr;
  return fd;
}

// Whether anybody sends to the group at this port within the time: a robot's own programs, for instance.
bool Heard(int port, Duration time) {
  const Time deadline = Clock::now() + time;
  const FileDescriptor fd(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  const int share = 1;
  sockaddr_in address{};
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  return fd.valid() && setsockopt(fd.get(), SOL_SOCKET, SO_REUSEADDR, &share, sizeof(share)) == 0 &&
         Join(fd.get(), &address).empty() && WaitReady(fd.get(), POLLIN, deadline);
}

// Waits for a datagram with this content. Others may be about: anybody can send to the group.
bool Returns(int fd, std::uint64_t token, Time deadline) {
  while (Clock::now() < deadline && WaitReady(fd, POLLIN, deadline)) {
    std::uint64_t got = 0;
    if (recv(fd, &got, sizeof(got), MSG_DONTWAIT) == sizeof(got) && got == token) return true;
  }
  return false;
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

std::string MulticastUrl(int port) {
  return std::string("udpm://") + kGroup + ":" + std::to_string(port) +
         "?ttl=0&recv_buf_size=2097152";
}

std::string Transport::ReadyLine() const {
  return "LCM_DEFAULT_URL='" + url + "' tools/spy";
}

Transport ChooseTransport(const TransportOptions& options) {
  Transport transport;
  const char* chosen_by_user = std::getenv("LCM_DEFAULT_URL");
  if (chosen_by_user != nullptr && *chosen_by_user != '\0') {
    transport.url = chosen_by_user;
    CheckLcmUrl(transport.url);
    return transport;
  }
  const MulticastTest multicast = options.test_multicast(options.test_timeout);
  if (multicast.works) {
    if (options.join_existing) {
      transport.url = MulticastUrl(options.multicast_port);
      return transport;
    }
    const int last = options.multicast_port + kPortsTried - 1;
    for (int port = options.multicast_port; port <= last; ++port) {
      transport.claim = ClaimPort(port);
      if (!transport.claim || Heard(port, options.listen_time)) continue;
      transport.url = MulticastUrl(port);
      if (port != options.multicast_port) {
        transport.explanation = "LCM: others talk at port " +
                                std::to_string(options.multicast_port) +
                                "; this run keeps to itself at port " + std::to_string(port) + ".";
      }
      return transport;
    }
    transport.claim = nullptr;
    transport.explanation = "LCM: others talk at every port from " +
                            std::to_string(options.multicast_port) + " to " + std::to_string(last) +
                            ".\n";
  } else {
    transport.explanation = "LCM: multicast does not work here (" + multicast.reason +
                            ").\n     To mend it: " + kMulticastMend + "\n";
  }
  const TcpHubOptions& hub = options.hub;
  if (options.join_existing && hub.port != 0 &&
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

Transport JoinTransport() {
  TransportOptions options;
  options.join_existing = true;
  return ChooseTransport(options);
}

}  // namespace vantage
