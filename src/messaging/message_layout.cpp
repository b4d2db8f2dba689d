#include "vantage/messaging/message_layout.h"

#include <cstring>

namespace vantage {
namespace {

// LCM's hash works on a signed 64 bit value with an arithmetic right shift and adds signed chars.
std::int64_t HashByte(std::int64_t hash, char c) noexcept {
  const auto shifted = static_cast<std::uint64_t>(hash) << 8;
  const auto folded = shifted ^ static_cast<std::uint64_t>(hash >> 55);
  return static_cast<std::int64_t>(folded + static_cast<std::uint64_t>(std::int64_t{c}));
}

std::int64_t HashText(std::int64_t hash, const char* text) noexcept {
  hash = HashByte(hash, static_cast<char>(std::strlen(text)));
  for (; *text != '\0'; ++text) hash = HashByte(hash, *text);
  return hash;
}

const char* LcmName(FieldKind kind) noexcept {
  switch (kind) {
    case FieldKind::kInt8:
      return "int8_t";
    case FieldKind::kInt16:
      return "int16_t";
    case FieldKind::kInt32:
      return "int32_t";
    case FieldKind::kInt64:
      return "int64_t";
    case FieldKind::kByte:
      return "byte";
    case FieldKind::kBoolean:
      return "boolean";
    case FieldKind::kFloat:
      return "float";
    case FieldKind::kDouble:
      return "double";
    case FieldKind::kString:
      return "string";
    case FieldKind::kNested:
      break;
  }
  return "";
}

}  // namespace

std::uint64_t Fingerprint(const MessageLayout& layout) noexcept {
  constexpr std::int64_t kSeed = 0x12345678;
  std::int64_t hash = kSeed;
  std::uint64_t nested = 0;
  for (int i = 0; i < layout.num_fields; ++i) {
    const FieldLayout& field = layout.fields[i];
    hash = HashText(hash, field.name);
    if (field.kind == FieldKind::kNested) {
      nested += Fingerprint(*field.nested);
    } else {
      hash = HashText(hash, LcmName(field.kind));
    }
    hash = HashByte(hash, static_cast<char>(field.num_dimensions));
    for (int d = 0; d < field.num_dimensions; ++d) {
      hash = HashByte(hash, field.dimensions[d].field >= 0 ? 1 : 0);
      hash = HashText(hash, field.dimensions[d].text);
    }
  }
  const std::uint64_t sum = static_cast<std::uint64_t>(hash) + nested;
  return (sum << 1) + (sum >> 63);
}

}  // namespace vantage
