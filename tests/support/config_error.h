#pragma once

#include <string>

#include "vantage/math/error.h"

namespace vantage::test {

/// The message of the ConfigError that `f` throws; "nothing thrown" when it does not throw.
template <typename F>
[[nodiscard]] std::string ConfigErrorOf(F&& f) {
  try {
    f();
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "nothing thrown";
}

}  // namespace vantage::test
