#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "file_descriptor.h"
#include "input_buffer.h"
#include "vantage/math/time.h"

namespace vantage {

/// One connection to a hub. LCM's own client aborts, waits for ever or prints to the terminal when the
/// hub goes away; this one says so and is thrown away.
///
/// One thread may receive while others send, these one at a time.
class TcpqClient {
 public:
  /// Called with a channel and a message's bytes, which are the caller's only during the call.
  using Handler = std::function<void(std::string_view channel, const void* data, std::size_t size)>;

  /// Connects and exchanges greetings; null when that is not done within `timeout`.
  static std::unique_ptr<TcpqClient> Connect(const std::string& host, std::uint16_t port,
                                             Duration timeout);

  /// Waits for input, at most `timeout`, and calls `handler` for each message that is complete.
  /// Returns > 0 when bytes came, 0 when none did, < 0 when the connection is lost.
  int Receive(Duration timeout, const Handler& handler);

  /// Both wait for a hub that does not read, at most 0.1 s; after that, as after an error, the
  /// connection is lost. False when it is.
  bool Subscribe(const std::string& channel);
  bool Publish(std::string_view channel, const void* data, std::size_t size);

  [[nodiscard]] bool lost() const noexcept { return lost_.load(); }

 private:
  explicit TcpqClient(FileDescriptor fd);
  bool Send(const void* head, std::size_t head_size, const void* data, std::size_t data_size);
  void Lose() noexcept;

  FileDescriptor fd_;
  std::atomic<bool> lost_{false};
  InputBuffer in_;
  bool in_pieces_{false};  // See AcknowledgeInPieces().
};

}  // namespace vantage
