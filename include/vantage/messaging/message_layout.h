#pragma once

#include <cstddef>
#include <cstdint>

/// @file
/// Layout of an LCM type on the wire as data, so that one walker checks messages of every type. The
/// tables are generated from lcm_types/*.lcm into "vantage_lcm/layouts.h".

namespace vantage {

/// What a field holds.
enum class FieldKind {
  kInt8,
  kInt16,
  kInt32,
  kInt64,
  kByte,
  kBoolean,
  kFloat,
  kDouble,
  kString,
  kNested,
};

/// Bytes of one element on the wire; 0 where that depends on the content.
[[nodiscard]] constexpr std::size_t WireSize(FieldKind kind) noexcept {
  switch (kind) {
    case FieldKind::kInt8:
    case FieldKind::kByte:
    case FieldKind::kBoolean:
      return 1;
    case FieldKind::kInt16:
      return 2;
    case FieldKind::kInt32:
    case FieldKind::kFloat:
      return 4;
    case FieldKind::kInt64:
    case FieldKind::kDouble:
      return 8;
    case FieldKind::kString:
    case FieldKind::kNested:
      break;
  }
  return 0;
}

/// One dimension of an array: the value of an earlier field, or a constant.
struct Dimension {
  int field;         ///< Index of the integer field that holds the size, or -1.
  int constant;      ///< The size when field is -1.
  const char* text;  ///< As the .lcm file has it: part of the fingerprint.
};

struct MessageLayout;
/// Most array dimensions of a field.
inline constexpr int kMaxDimensions = 3;

/// One field of a message type, as the bytes hold it.
struct FieldLayout {
  const char* name;             ///< As the .lcm file has it: part of the fingerprint.
  FieldKind kind;               ///< Of one element.
  const MessageLayout* nested;  ///< Of kNested.
  int num_dimensions;           ///< 0: a single value.
  /// Outermost first; the first num_dimensions have a meaning.
  Dimension dimensions[kMaxDimensions];
};

/// A message type, as the bytes hold it.
struct MessageLayout {
  const char* name;           ///< "package.type".
  const FieldLayout* fields;  ///< Array of num_fields, in the order of the bytes.
  int num_fields;             ///< Length of `fields`.
};

/// Layout of the generated class `Wire`; specialised in "vantage_lcm/layouts.h".
template <typename Wire>
inline constexpr const MessageLayout* kLayoutOf = nullptr;

/// Most fields in the layout or in one nested in it.
[[nodiscard]] constexpr int MostFields(const MessageLayout& layout) noexcept {
  int most = layout.num_fields;
  for (int i = 0; i < layout.num_fields; ++i) {
    if (layout.fields[i].kind == FieldKind::kNested) {
      const int nested = MostFields(*layout.fields[i].nested);
      if (nested > most) most = nested;
    }
  }
  return most;
}

/// Fewest bytes a message of the layout can have, without the fingerprint in front.
[[nodiscard]] constexpr std::size_t SmallestSize(const MessageLayout& layout) noexcept {
  std::size_t size = 0;
  for (int i = 0; i < layout.num_fields; ++i) {
    const FieldLayout& field = layout.fields[i];
    std::size_t elements = 1;
    for (int d = 0; d < field.num_dimensions; ++d) {
      const Dimension& dimension = field.dimensions[d];
      elements *= dimension.field >= 0 ? 0 : static_cast<std::size_t>(dimension.constant);
    }
    // A string has a length of four bytes and a NUL at least.
    std::size_t element = field.kind == FieldKind::kString ? 5 : WireSize(field.kind);
    if (field.kind == FieldKind::kNested) element = SmallestSize(*field.nested);
    size += elements * element;
  }
  return size;
}

/// Fingerprint of the type by LCM's rule: a hash of names, primitive types and dimensions, the nested
/// types' fingerprints added, rotated by one bit.
[[nodiscard]] std::uint64_t Fingerprint(const MessageLayout& layout) noexcept;

}  // namespace vantage
