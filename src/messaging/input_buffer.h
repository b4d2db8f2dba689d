#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

#include <sys/socket.h>
#include <sys/types.h>

namespace vantage {

/// Bytes of a stream that have come and are not yet understood. Received in place: a large message is
/// not copied on its way in.
class InputBuffer {
 public:
  /// recv() of whatever there is, without waiting; returns what recv() does. Grows no faster than data
  /// really comes, whatever the other side announces.
  ssize_t Receive(int fd) {
    if (storage_.size() - end_ < kChunk) MakeRoom();
    const ssize_t got = recv(fd, storage_.data() + end_, storage_.size() - end_, MSG_DONTWAIT);
    if (got > 0) end_ += static_cast<std::size_t>(got);
    return got;
  }

  [[nodiscard]] const std::uint8_t* data() const noexcept { return storage_.data() + begin_; }
  [[nodiscard]] std::size_t size() const noexcept { return end_ - begin_; }

  /// Takes `bytes` off the front; data() stays valid until the next Receive().
  void Consume(std::size_t bytes) noexcept {
    begin_ += bytes;
    if (begin_ == end_) begin_ = end_ = 0;
  }

 private:
  static constexpr std::size_t kChunk = 64 * 1024;

  void MakeRoom() {
    if (begin_ > 0) {
      std::memmove(storage_.data(), data(), size());
      end_ -= begin_;
      begin_ = 0;
    }
    if (storage_.size() - end_ < kChunk) {
      storage_.resize(std::max(2 * storage_.size(), end_ + kChunk));
    }
  }

  std::vector<std::uint8_t> storage_;
  std::size_t begin_{0};
  std::size_t end_{0};
};

}  // namespace vantage
