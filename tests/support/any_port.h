#pragma once

#include "vantage/messaging/tcp_hub.h"

namespace vantage::test {

/// A hub on a port that the system chooses: tests run beside each other.
[[nodiscard]] inline TcpHubOptions AnyPort() {
  TcpHubOptions options;
  options.port = 0;
  return options;
}

}  // namespace vantage::test
