#pragma once

#include <optional>
#include <set>
#include <string>

#include "vantage/messaging/codec.h"

namespace vantage {

/// Two messages of one type.
struct MessageDifference {
  double worst{0.0};  ///< Largest |a - b| / max(1, |a|) of their numbers.
  /// The first field that differs by more than the tolerance, or in what is no real number.
  struct Field {
    std::string name, a, b;
  };
  std::optional<Field> first;
};

/// Compares them value by value. Fields named in `ignored` may differ.
/// Throws Error when one is not of a known type.
[[nodiscard]] MessageDifference Compare(const Bytes& a, const Bytes& b, double tolerance,
                                        const std::set<std::string>& ignored);

}  // namespace vantage
