#pragma once

#include <cstring>

#include <arpa/inet.h>
#include <net/if.h>
#include <net/route.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

/// @file
/// A network of one's own, with the loopback interface alone: what a machine without multicast looks
/// like, made without touching the real one.

namespace vantage::test {

/// Moves this process, which must have one thread, into a new network. False where that is not allowed.
inline bool EnterEmptyNetwork() {
  if (unshare(CLONE_NEWUSER | CLONE_NEWNET) != 0) return false;
  const int fd = socket(AF_INET, SOCK_DGRAM, 0);
  ifreq request{};
  std::strcpy(request.ifr_name, "lo");
  bool up = ioctl(fd, SIOCGIFFLAGS, &request) == 0;
  request.ifr_flags = static_cast<short>(request.ifr_flags | IFF_UP | IFF_RUNNING);
  up = up && ioctl(fd, SIOCSIFFLAGS, &request) == 0;
  close(fd);
  return up;
}

/// What kMulticastMend does.
inline bool AddRouteForLcm() {
  const int fd = socket(AF_INET, SOCK_DGRAM, 0);
  rtentry route{};
  char device[] = "lo";
  const auto set = [](const char* text, sockaddr* address) {
    auto* in = reinterpret_cast<sockaddr_in*>(address);
    in->sin_family = AF_INET;
    inet_pton(AF_INET, text, &in->sin_addr);
  };
  set("239.255.76.67", &route.rt_dst);
  set("255.255.255.255", &route.rt_genmask);
  route.rt_flags = RTF_UP | RTF_HOST;
  route.rt_dev = device;
  const bool added = ioctl(fd, SIOCADDRT, &route) == 0;
  close(fd);
  return added;
}

}  // namespace vantage::test
