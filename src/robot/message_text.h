#pragma once

#include <initializer_list>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

/// @file
/// Private to the module: values as messages write them.

namespace vantage {

/// The numbers with a blank between them.
[[nodiscard]] inline std::string Text(std::initializer_list<double> numbers) {
  std::ostringstream text;
  for (const double number : numbers) text << (text.tellp() > 0 ? " " : "") << number;
  return text.str();
}

/// The names in quotes, the first `most` of them, and how many more there are.
[[nodiscard]] inline std::string Listed(
    const std::vector<std::string>& names,
    std::size_t most = std::numeric_limits<std::size_t>::max()) {
  std::string text;
  for (std::size_t i = 0; i < names.size() && i < most; ++i) {
    text += (i == 0 ? "'" : ", '") + names[i] + "'";
  }
  if (names.size() > most) text += " and " + std::to_string(names.size() - most) + " more";
  return text;
}

}  // namespace vantage
