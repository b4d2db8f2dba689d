#pragma once

#include <string>

/// @file
/// Numbers for people and for files.

namespace vantage {

/// Text as printf() would write it, of any length.
[[nodiscard]] std::string Format(const char* format, ...) __attribute__((format(printf, 1, 2)));

/// A number that reads back as itself.
[[nodiscard]] inline std::string ExactText(double value) {
  return Format("%.17g", value);
}

}  // namespace vantage
