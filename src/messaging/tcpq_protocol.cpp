#include "tcpq_protocol.h"

#include <algorithm>

namespace vantage::tcpq {
namespace {

constexpr std::size_t kWord = 4;

bool IsPrintable(std::string_view text) noexcept {
  return std::all_of(text.begin(), text.end(), [](char c) { return c >= 0x20 && c < 0x7f; });
}

Message::Kind KindOf(std::uint32_t type) noexcept {
  switch (type) {
    case kPublish:
      return Message::Kind::kPublish;
    case kSubscribe:
      return Message::Kind::kSubscribe;
    case kUnsubscribe:
      return Message::Kind::kUnsubscribe;
    default:
      return Message::Kind::kError;
  }
}

Message Of(Message::Kind kind) noexcept {
  Message message;
  message.kind = kind;
  return message;
}

}  // namespace

Hello MakeHello(std::uint32_t magic) noexcept {
  Hello hello{};
  WriteWord(magic, hello.data());
  WriteWord(kVersion, hello.data() + kWord);
  return hello;
}

Message ReadHello(const std::uint8_t* data, std::size_t size, std::uint32_t magic) noexcept {
  if (size < kHelloSize) return Of(Message::Kind::kIncomplete);
  // The version is not held against anybody: LCM's own programs do not look at it either.
  if (ReadWord(data) != magic) return Of(Message::Kind::kError);
  Message message = Of(Message::Kind::kHello);
  message.size = kHelloSize;
  return message;
}

Message ReadMessage(const std::uint8_t* data, std::size_t size, std::size_t max_data) noexcept {
  if (size < 2 * kWord) return Of(Message::Kind::kIncomplete);
  const Message::Kind kind = KindOf(ReadWord(data));
  const std::size_t name_size = ReadWord(data + kWord);
  if (kind == Message::Kind::kError || name_size < 1 || name_size > kMaxName) {
    return Of(Message::Kind::kError);
  }
  const bool has_data = kind == Message::Kind::kPublish;
  Message message;
  message.size = 2 * kWord + name_size + (has_data ? kWord : 0);
  if (size < message.size) return Of(Message::Kind::kIncomplete);
  message.name = {reinterpret_cast<const char*>(data) + 2 * kWord, name_size};
  // Receivers hand the name to C and to a regular expression engine.
  if (!IsPrintable(message.name)) return Of(Message::Kind::kError);
  if (has_data) {
    message.data = data + message.size;
    message.data_size = ReadWord(message.data - kWord);
    if (message.data_size > max_data) return Of(Message::Kind::kError);
    message.size += message.data_size;
    if (size < message.size) return Of(Message::Kind::kIncomplete);
  }
  message.kind = kind;
  return message;
}

}  // namespace vantage::tcpq
