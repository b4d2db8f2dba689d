#include "vantage/messaging/message_guard.h"

#include <algorithm>
#include <array>
#include <cstring>

#include "big_endian.h"

namespace vantage {
namespace {

// Dimensions up to this size pass even when no bytes are left for them: in an array [a][b] with b = 0
// the a rows take no bytes, but the decoder allocates them.
constexpr std::size_t kSmallDimension = 64;

struct Cursor {
  const std::uint8_t* next;
  std::size_t left;

  void Skip(std::size_t bytes) noexcept {
    next += bytes;
    left -= bytes;
  }
};

bool IsInteger(FieldKind kind) noexcept {
  return kind == FieldKind::kInt8 || kind == FieldKind::kInt16 || kind == FieldKind::kInt32 ||
         kind == FieldKind::kInt64;
}

Refusal SkipString(Cursor* cursor) noexcept {
  if (cursor->left < 4) return Refusal::kTruncated;
  const std::int64_t length = ReadInteger(cursor->next, 4);  // The NUL included.
  cursor->Skip(4);
  if (length < 1 || static_cast<std::uint64_t>(length) > cursor->left) return Refusal::kBadString;
  // Ends in a zero, and holds no other: LCM's own encoder would cut it off there.
  if (std::memchr(cursor->next, 0, static_cast<std::size_t>(length)) != cursor->next + length - 1) {
    return Refusal::kBadString;
  }
  cursor->Skip(static_cast<std::size_t>(length));
  return Refusal::kNone;
}

using FieldValues = std::array<std::int64_t, kMaxFields>;

// Number of elements of the field's array, all dimensions multiplied; false when the bytes left cannot
// hold them.
bool CountElements(const FieldLayout& field, const FieldValues& values, std::size_t left,
                   std::size_t* elements) noexcept {
  const std::size_t most = std::max(left, kSmallDimension);
  *elements = 1;
  for (int d = 0; d < field.num_dimensions; ++d) {
    const Dimension& dimension = field.dimensions[d];
    const std::int64_t size = dimension.field >= 0 ? values[dimension.field] : dimension.constant;
    if (size < 0 || static_cast<std::uint64_t>(size) > most) return false;
    *elements *= static_cast<std::size_t>(size);
    if (*elements > most) return false;
  }
  // `elements` is at most the bytes left or 64: no overflow here.
  return *elements * WireSize(field.kind) <= left;
}

// What to call it when a field does not fit: the fault of its count, if it has one.
Refusal DoesNotFit(const FieldLayout& field) noexcept {
  for (int d = 0; d < field.num_dimensions; ++d) {
    if (field.dimensions[d].field >= 0) return Refusal::kBadCount;
  }
  return Refusal::kTruncated;
}

Refusal SkipFields(const MessageLayout& layout, Cursor* cursor) noexcept;

Refusal SkipElements(const FieldLayout& field, std::size_t elements, Cursor* cursor) noexcept {
  Refusal refusal = Refusal::kNone;
  for (std::size_t i = 0; i < elements && refusal == Refusal::kNone; ++i) {
    refusal =
        field.kind == FieldKind::kString ? SkipString(cursor) : SkipFields(*field.nested, cursor);
  }
  return refusal;
}

Refusal SkipFields(const MessageLayout& layout, Cursor* cursor) noexcept {
  FieldValues values{};
  for (int i = 0; i < layout.num_fields; ++i) {
    const FieldLayout& field = layout.fields[i];
    std::size_t elements = 0;
    if (!CountElements(field, values, cursor->left, &elements)) return DoesNotFit(field);
    const std::size_t size = WireSize(field.kind);
    if (size == 0) {
      const Refusal refusal = SkipElements(field, elements, cursor);
      if (refusal != Refusal::kNone) return refusal;
    } else {
      if (field.num_dimensions == 0 && IsInteger(field.kind)) {
        values[i] = ReadInteger(cursor->next, size);
      }
      cursor->Skip(elements * size);
    }
  }
  return Refusal::kNone;
}

}  // namespace

Refusal CheckBytes(const MessageLayout& layout, std::int64_t fingerprint, const void* data,
                   std::size_t size, std::size_t max_size) noexcept {
  if (size > max_size) return Refusal::kTooLarge;
  if (data == nullptr || size < kFingerprintSize) return Refusal::kTruncated;
  Cursor cursor{static_cast<const std::uint8_t*>(data), size};
  if (ReadInteger(cursor.next, kFingerprintSize) != fingerprint) return Refusal::kFingerprint;
  cursor.Skip(kFingerprintSize);
  const Refusal refusal = SkipFields(layout, &cursor);
  if (refusal != Refusal::kNone) return refusal;
  return cursor.left == 0 ? Refusal::kNone : Refusal::kTrailingBytes;
}

}  // namespace vantage
