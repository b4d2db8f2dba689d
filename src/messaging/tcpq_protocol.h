#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

/// @file
/// The wire protocol of LCM's tcpq:// transport. All integers are 32 bit, big-endian.
///
///   both sides, once:   magic, version
///   client, any time:   PUBLISH      channel length, channel, data length, data
///                       SUBSCRIBE    pattern length, pattern
///                       UNSUBSCRIBE  pattern length, pattern
///   server, any time:   PUBLISH      as above
///
/// A pattern is a regular expression that must match the whole channel.

namespace vantage::tcpq {

inline constexpr std::uint32_t kServerMagic = 0x287617fa;
inline constexpr std::uint32_t kClientMagic = 0x287617fb;
inline constexpr std::uint32_t kVersion = 0x0100;
inline constexpr std::size_t kHelloSize = 8;
inline constexpr std::size_t kMaxName = 255;  ///< Of a channel or a pattern [byte].

enum MessageType : std::uint32_t { kPublish = 1, kSubscribe = 2, kUnsubscribe = 3 };

using Hello = std::array<std::uint8_t, kHelloSize>;
[[nodiscard]] Hello MakeHello(std::uint32_t magic) noexcept;

/// What the first bytes of a stream are.
struct Message {
  enum class Kind { kIncomplete, kError, kHello, kPublish, kSubscribe, kUnsubscribe };
  Kind kind{Kind::kIncomplete};
  std::string_view name;              ///< Channel or pattern: printable ASCII, 1 to kMaxName bytes.
  const std::uint8_t* data{nullptr};  ///< Of kPublish.
  std::size_t data_size{0};
  std::size_t size{0};  ///< Of the whole message [byte].
};

/// The greeting of the other side, which must begin with `magic`.
[[nodiscard]] Message ReadHello(const std::uint8_t* data, std::size_t size,
                                std::uint32_t magic) noexcept;

/// A message after the greeting; kError when it is none or announces more than `max_data` bytes.
[[nodiscard]] Message ReadMessage(const std::uint8_t* data, std::size_t size,
                                  std::size_t max_data) noexcept;

inline std::uint32_t ReadWord(const std::uint8_t* data) noexcept {
  return std::uint32_t{data[0]} << 24 | std::uint32_t{data[1]} << 16 | std::uint32_t{data[2]} << 8 |
         std::uint32_t{data[3]};
}

inline void WriteWord(std::uint32_t word, std::uint8_t* data) noexcept {
  for (int i = 0; i < 4; ++i) data[i] = static_cast<std::uint8_t>(word >> (24 - 8 * i));
}

}  // namespace vantage::tcpq
