#include "socket_util.h"

#include <algorithm>
#include <cerrno>
#include <cstring>

#include <netdb.h>
#include <netinet/tcp.h>
#include <poll.h>

namespace vantage {

bool Resolve(const std::string& host, std::uint16_t port, sockaddr_in* address) {
  addrinfo hints{};
  hints.ai_family = AF_INET;
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (getaddrinfo(host.c_str(), nullptr, &hints, &found) != 0) return false;
  std::memcpy(address, found->ai_addr, sizeof(*address));
  address->sin_port = htons(port);
  freeaddrinfo(found);
  return true;
}

bool WaitReady(int fd, short events, Time deadline) {
  for (;;) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - Clock::now()).count();
    pollfd ready{fd, events, 0};
    const int count = poll(&ready, 1, static_cast<int>(std::max<std::int64_t>(left, 0)));
    if (count > 0) return true;
    if (count < 0 && errno != EINTR) return false;
    if (left <= 0) return false;
  }
}

FileDescriptor ConnectTcp(const sockaddr_in& address, Time deadline) {
  FileDescriptor fd(socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (!fd.valid()) return fd;
  if (connect(fd.get(), reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0) {
    int error = errno;
    if (error == EINPROGRESS && WaitReady(fd.get(), POLLOUT, deadline)) {
      socklen_t size = sizeof(error);
      getsockopt(fd.get(), SOL_SOCKET, SO_ERROR, &error, &size);
    }
    if (error != 0) return FileDescriptor();
  }
  SetOption(fd.get(), IPPROTO_TCP, TCP_NODELAY, 1);
  return fd;
}

void AcknowledgeInPieces(int fd, bool part_is_missing, bool* in_pieces) noexcept {
  *in_pieces = *in_pieces || part_is_missing;
  // The kernel forgets it; renewed each time.
  if (*in_pieces) SetOption(fd, IPPROTO_TCP, TCP_QUICKACK, 1);
}

}  // namespace vantage
