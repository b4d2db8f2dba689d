#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "becomes_true.h"

/// @file
/// A client of an LCM hub that can say anything, written from the protocol and independent of the code
/// under test.

namespace vantage::test {

using RawBytes = std::vector<std::uint8_t>;

inline void Append(std::uint32_t word, RawBytes* bytes) {
  for (int shift = 24; shift >= 0; shift -= 8) {
    bytes->push_back(static_cast<std::uint8_t>(word >> shift));
  }
}

inline void Append(const std::string& text, RawBytes* bytes) {
  bytes->insert(bytes->end(), text.begin(), text.end());
}

inline RawBytes ClientHello() {
  RawBytes bytes;
  Append(0x287617fb, &bytes);
  Append(0x0100, &bytes);
  return bytes;
}

inline RawBytes NameMessage(std::uint32_t type, const std::string& name) {
  RawBytes bytes;
  Append(type, &bytes);
  Append(static_cast<std::uint32_t>(name.size()), &bytes);
  Append(name, &bytes);
  return bytes;
}

inline RawBytes PublishMessage(const std::string& channel, const RawBytes& data) {
  RawBytes bytes = NameMessage(1, channel);
  Append(static_cast<std::uint32_t>(data.size()), &bytes);
  bytes.insert(bytes.end(), data.begin(), data.end());
  return bytes;
}

struct RawMessage {
  std::string channel;
  RawBytes data;
};

class RawClient {
 public:
  /// Connects; says hello unless told not to.
  explicit RawClient(std::uint16_t port, bool hello = true, const char* address = "127.0.0.1") {
    fd_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(port);
    inet_pton(AF_INET, address, &to.sin_addr);
    connected_ = connect(fd_, reinterpret_cast<sockaddr*>(&to), sizeof(to)) == 0;
    if (connected_ && hello) {
      Send(ClientHello());
      connected_ = ReceiveBytes(8).has_value();
    }
  }
  ~RawClient() { close(fd_); }
  RawClient(const RawClient&) = delete;
  RawClient& operator=(const RawClient&) = delete;

  [[nodiscard]] bool connected() const { return connected_; }

  bool Send(const RawBytes& bytes) {
    std::size_t sent = 0;
    while (sent < bytes.size()) {
      const ssize_t n = send(fd_, bytes.data() + sent, bytes.size() - sent, MSG_NOSIGNAL);
      if (n <= 0) return false;
      sent += static_cast<std::size_t>(n);
    }
    return true;
  }
  bool Subscribe(const std::string& pattern) { return Send(NameMessage(2, pattern)); }
  bool Unsubscribe(const std::string& pattern) { return Send(NameMessage(3, pattern)); }
  bool Publish(const std::string& channel, const RawBytes& data) {
    return Send(PublishMessage(channel, data));
  }

  /// The next message; nullopt when the connection ends, or nothing comes for `timeout`.
  std::optional<RawMessage> Receive(std::chrono::milliseconds timeout = kPatience) {
    const auto head = ReceiveBytes(8, timeout);
    if (!head || Word(*head, 0) != 1) return std::nullopt;
    const auto channel = ReceiveBytes(Word(*head, 4), timeout);
    if (!channel) return std::nullopt;
    const auto size = ReceiveBytes(4, timeout);
    if (!size) return std::nullopt;
    const auto data = ReceiveBytes(Word(*size, 0), timeout);
    if (!data) return std::nullopt;
    return RawMessage{std::string(channel->begin(), channel->end()), *data};
  }

  /// Whether the other side closes the connection. Reads what it sent before.
  bool IsClosed() {
    std::uint8_t byte = 0;
    for (;;) {
      pollfd ready{fd_, POLLIN, 0};
      if (poll(&ready, 1, 30'000) <= 0) return false;
      if (recv(fd_, &byte, 1, 0) <= 0) return true;
    }
  }

  /// Subscribes to a channel of its own and waits until the hub has understood: what was sent before is
  /// in force then.
  bool Sync() {
    static int syncs = 0;
    const std::string channel = "SYNC_" + std::to_string(++syncs);
    Subscribe(channel);
    Publish(channel, {});
    const auto echo = Receive();
    return echo && echo->channel == channel;
  }

 private:
  static std::uint32_t Word(const RawBytes& bytes, std::size_t at) {
    return std::uint32_t{bytes[at]} << 24 | std::uint32_t{bytes[at + 1]} << 16 |
           std::uint32_t{bytes[at + 2]} << 8 | std::uint32_t{bytes[at + 3]};
  }

  std::optional<RawBytes> ReceiveBytes(std::size_t size,
                                       std::chrono::milliseconds timeout = kPatience) {
    RawBytes bytes(size);
    std::size_t got = 0;
    while (got < size) {
      pollfd ready{fd_, POLLIN, 0};
      if (poll(&ready, 1, static_cast<int>(timeout.count())) <= 0) return std::nullopt;
      const ssize_t n = recv(fd_, bytes.data() + got, size - got, 0);
      if (n <= 0) return std::nullopt;
      got += static_cast<std::size_t>(n);
    }
    return bytes;
  }

  int fd_{-1};
  bool connected_{false};
};

}  // namespace vantage::test
