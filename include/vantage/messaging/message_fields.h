#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "vantage/messaging/message_layout.h"

/// @file
/// Messages as lists of named values, by their layouts: for tables, comparisons and displays that treat
/// all types alike.

namespace vantage {

/// One value of a message.
struct MessageField {
  std::string name;  ///< "w_c", "sigma[2]", "pose[0].X_WC[1][3]".
  /// Whole numbers and booleans as integers, floats as doubles.
  std::variant<std::int64_t, double, std::string> value;
};

/// An array of structs in a message, its elements taken apart.
struct MessageTable {
  std::string name;  ///< Of the array.
  /// One for each element; as many fields as its own arrays need.
  std::vector<std::vector<MessageField>> rows;
};

/// A message in plain values, for tables and monitors.
struct MessageContent {
  std::vector<MessageField> fields;  ///< In the order of the type; without the tables.
  std::vector<MessageTable> tables;  ///< Arrays of structs of the message itself.
};

/// The type whose fingerprint is in front of the bytes; nullptr when it is none of ours.
[[nodiscard]] const MessageLayout* FindLayout(const void* data, std::size_t size) noexcept;

/// All values of a message. Of an array of bytes the length alone: field "data.size".
/// Throws Error when the bytes are not a message of the layout.
[[nodiscard]] MessageContent ContentOf(const MessageLayout& layout, const void* data,
                                       std::size_t size);

}  // namespace vantage
