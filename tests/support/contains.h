#pragma once

#include <string>

namespace vantage::test {

[[nodiscard]] inline bool Contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

}  // namespace vantage::test
