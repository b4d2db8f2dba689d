#pragma once

#include <cstddef>
#include <cstdint>

#include "vantage/messaging/message_layout.h"
#include "vantage/messaging/refusal.h"

namespace vantage {

/// Whether lcm-gen's decoder may be let loose on the bytes. It allocates what a count says before it
/// looks how many bytes there are; this walks the layout first and allocates nothing.
///
/// After kNone the decoder consumes exactly `size` bytes, and no array of the message has more
/// elements, in any dimension, than max(size, 64).
///
/// @param fingerprint  Of the type expected.
/// @param max_size     Cap on the whole message [byte].
/// @pre MostFields(layout) <= kMaxFields; no nested type without fields of fixed size.
[[nodiscard]] Refusal CheckBytes(const MessageLayout& layout, std::int64_t fingerprint,
                                 const void* data, std::size_t size, std::size_t max_size) noexcept;

/// Most fields that CheckBytes() can keep track of in one struct.
inline constexpr int kMaxFields = 48;

}  // namespace vantage
