// libFuzzer target: what a client sends to the hub: the stream's messages, and patterns matched
// against channels. Whatever comes, messages stay within the stream and matching within its limits.

#include <cstdint>
#include <cstdlib>

#include "../../../src/messaging/channel_pattern.h"
#include "../../../src/messaging/tcpq_protocol.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace vantage;
  using Kind = tcpq::Message::Kind;
  const std::uint8_t* const end = data + size;
  if (tcpq::ReadHello(data, size, tcpq::kClientMagic).kind == Kind::kHello)
    data += tcpq::kHelloSize;
  std::string channel = "JOINT_STATE";
  while (data < end) {
    const tcpq::Message message =
        tcpq::ReadMessage(data, static_cast<std::size_t>(end - data), 1000);
    if (message.kind == Kind::kIncomplete || message.kind == Kind::kError) break;
    if (message.size < 9 || message.size > static_cast<std::size_t>(end - data)) std::abort();
    if (message.name.empty() || message.name.size() > tcpq::kMaxName) std::abort();
    if (message.kind == Kind::kPublish) {
      if (message.data_size > 1000 || message.data + message.data_size != data + message.size) {
        std::abort();
      }
      channel = std::string(message.name);
    } else if (message.kind == Kind::kSubscribe) {
      const auto pattern = ChannelPattern::Compile(std::string(message.name));
      if (pattern && pattern->Matches(channel) && channel.empty()) std::abort();
    }
    data += message.size;
  }
  return 0;
}
