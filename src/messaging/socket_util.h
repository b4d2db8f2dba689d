#pragma once

#include <cstdint>
#include <string>

#include <netinet/in.h>
#include <sys/socket.h>

#include "file_descriptor.h"
#include "vantage/math/time.h"

namespace vantage {

/// Sets an option. Refused options cost speed, not correctness: no error.
template <typename T>
void SetOption(int fd, int level, int option, const T& value) noexcept {
  setsockopt(fd, level, option, &value, sizeof(value));
}

/// Address of host (a number or a name) and port; IPv4, as LCM's own programs. False: no such host.
bool Resolve(const std::string& host, std::uint16_t port, sockaddr_in* address);

/// Waits until fd is ready for `events` of poll(2), at most until `deadline`.
bool WaitReady(int fd, short events, Time deadline);

/// Connects within the time, nodelay set, non-blocking; not valid when that fails.
FileDescriptor ConnectTcp(const sockaddr_in& address, Time deadline);

/// Call it after each read. LCM's own hub and clients send a message in small pieces with Nagle's algorithm on,
/// and the second piece waits until the first is acknowledged: that must be at once, from the first part of a
/// message that comes alone on. For peers that send whole messages the option is a system call and a packet for
/// nothing.
/// @param part_is_missing  The last read ended inside a message.
/// @param in_pieces        Kept by the caller for each connection, false at first.
void AcknowledgeInPieces(int fd, bool part_is_missing, bool* in_pieces) noexcept;

}  // namespace vantage
