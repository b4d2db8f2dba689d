#include "tcpq_client.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/uio.h>

#include "socket_util.h"
#include "tcpq_protocol.h"

namespace vantage {
namespace {

// More than any hub passes on; a length beyond it is garbage.
constexpr std::size_t kMaxData = std::size_t{64} << 20;
constexpr Duration kSendTimeout = std::chrono::milliseconds(100);

bool SendAll(int fd, iovec* pieces, std::size_t count, Time deadline) {
  while (count > 0) {
    msghdr header{};
    header.msg_iov = pieces;
    header.msg_iovlen = count;
    const ssize_t sent = sendmsg(fd, &header, MSG_NOSIGNAL | MSG_DONTWAIT);
    if (sent < 0 && errno == EINTR) continue;
    if (sent < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) {
      if (!WaitReady(fd, POLLOUT, deadline)) return false;
      continue;
    }
    if (sent < 0) return false;
    auto left = static_cast<std::size_t>(sent);
    while (count > 0 && left >= pieces->iov_len) {
      left -= pieces->iov_len;
      ++pieces;
      --count;
    }
    if (count > 0) {
      pieces->iov_base = static_cast<std::uint8_t*>(pieces->iov_base) + left;
      pieces->iov_len -= left;
    }
  }
  return true;
}

bool ReceiveAll(int fd, std::uint8_t* data, std::size_t size, Time deadline) {
  while (size > 0) {
    if (!WaitReady(fd, POLLIN, deadline)) return false;
    const ssize_t got = recv(fd, data, size, MSG_DONTWAIT);
    if (got < 0 && (errno == EAGAIN || errno == EINTR)) continue;
    if (got <= 0) return false;
    data += got;
    size -= static_cast<std::size_t>(got);
  }
  return true;
}

}  // namespace

TcpqClient::TcpqClient(FileDescriptor fd) : fd_(std::move(fd)) {}

std::unique_ptr<TcpqClient> TcpqClient::Connect(const std::string& host, std::uint16_t port,
                                                Duration timeout) {
  sockaddr_in address{};
  if (!Resolve(host, port, &address)) return nullptr;
  const Time deadline = Clock::now() + timeout;
  FileDescriptor fd = ConnectTcp(address, deadline);
  if (!fd.valid()) return nullptr;
  tcpq::Hello ours = tcpq::MakeHello(tcpq::kClientMagic);
  iovec piece{ours.data(), ours.size()};
  tcpq::Hello theirs{};
  if (!SendAll(fd.get(), &piece, 1, deadline) ||
      !ReceiveAll(fd.get(), theirs.data(), theirs.size(), deadline)) {
    return nullptr;
  }
  const auto hello = tcpq::ReadHello(theirs.data(), theirs.size(), tcpq::kServerMagic);
  if (hello.kind != tcpq::Message::Kind::kHello) return nullptr;
  return std::unique_ptr<TcpqClient>(new TcpqClient(std::move(fd)));
}

int TcpqClient::Receive(Duration timeout, const Handler& handler) {
  if (lost()) return -1;
  if (timeout > Duration::zero() && !WaitReady(fd_.get(), POLLIN, Clock::now() + timeout)) return 0;
  const ssize_t got = in_.Receive(fd_.get());
  if (got < 0 && (errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR)) return 0;
  if (got <= 0) {
    Lose();
    return -1;
  }
  for (;;) {
    const tcpq::Message message = tcpq::ReadMessage(in_.data(), in_.size(), kMaxData);
    if (message.kind == tcpq::Message::Kind::kIncomplete) break;
    if (message.kind != tcpq::Message::Kind::kPublish) {
      Lose();
      return -1;
    }
    handler(message.name, message.data, message.data_size);
    in_.Consume(message.size);
  }
  AcknowledgeInPieces(fd_.get(), in_.size() > 0, &in_pieces_);
  return 1;
}

bool TcpqClient::Subscribe(const std::string& channel) {
  std::array<std::uint8_t, 8> head{};
  tcpq::WriteWord(tcpq::kSubscribe, head.data());
  tcpq::WriteWord(static_cast<std::uint32_t>(channel.size()), head.data() + 4);
  return Send(head.data(), head.size(), channel.data(), channel.size());
}

bool TcpqClient::Publish(std::string_view channel, const void* data, std::size_t size) {
  std::array<std::uint8_t, 12 + tcpq::kMaxName> head{};
  const std::size_t name = std::min(channel.size(), tcpq::kMaxName);
  tcpq::WriteWord(tcpq::kPublish, head.data());
  tcpq::WriteWord(static_cast<std::uint32_t>(name), head.data() + 4);
  std::memcpy(head.data() + 8, channel.data(), name);
  tcpq::WriteWord(static_cast<std::uint32_t>(size), head.data() + 8 + name);
  return Send(head.data(), 12 + name, data, size);
}

bool TcpqClient::Send(const void* head, std::size_t head_size, const void* data,
                      std::size_t data_size) {
  if (lost()) return false;
  // sendmsg does not write through its pointers.
  std::array<iovec, 2> pieces{
      {{const_cast<void*>(head), head_size}, {const_cast<void*>(data), data_size}}};
  if (SendAll(fd_.get(), pieces.data(), pieces.size(), Clock::now() + kSendTimeout)) return true;
  // Half a message may be out: nothing after it would be understood.
  Lose();
  return false;
}

void TcpqClient::Lose() noexcept {
  lost_.store(true);
  // Wakes a thread that waits to receive. Closing is the destructor's: others may use the number.
  shutdown(fd_.get(), SHUT_RDWR);
}

}  // namespace vantage
