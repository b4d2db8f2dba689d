#include "vantage/messaging/message_fields.h"

#include <cstring>

#include <vantage_lcm/layouts.h>

#include "big_endian.h"
#include "vantage/math/error.h"
#include "vantage/messaging/codec.h"
#include "vantage/messaging/message_guard.h"

namespace vantage {
namespace {

/// Walks bytes that CheckBytes() has passed.
class Walker {
 public:
  explicit Walker(const std::uint8_t* data) : next_(data) {}

  /// With `tables`, arrays of structs go there; without, they are fields with names of their own.
  void Struct(const MessageLayout& layout, const std::string& prefix,
              std::vector<MessageField>* fields, std::vector<MessageTable>* tables) {
    std::vector<std::int64_t> integers(static_cast<std::size_t>(layout.num_fields));
    for (int i = 0; i < layout.num_fields; ++i) {
      const FieldLayout& field = layout.fields[i];
      std::vector<std::int64_t> sizes;
      for (int d = 0; d < field.num_dimensions; ++d) {
        const Dimension& dimension = field.dimensions[d];
        sizes.push_back(dimension.field >= 0 ? integers[static_cast<std::size_t>(dimension.field)]
                                             : dimension.constant);
      }
      const std::string name = prefix + field.name;
      if (tables != nullptr && field.kind == FieldKind::kNested && sizes.size() == 1) {
        Table(field, name, sizes[0], tables);
        continue;
      }
      if (field.kind == FieldKind::kByte && !sizes.empty()) {
        std::int64_t total = 1;
        for (const std::int64_t size : sizes) total *= size;
        next_ += total;
        fields->push_back({name + ".size", total});
        continue;
      }
      Array(field, name, sizes, 0, fields);
      if (field.num_dimensions == 0 && !fields->empty()) {
        const auto* integer = std::get_if<std::int64_t>(&fields->back().value);
        if (integer != nullptr) integers[static_cast<std::size_t>(i)] = *integer;
      }
    }
  }

 private:
  void Table(const FieldLayout& field, const std::string& name, std::int64_t size,
             std::vector<MessageTable>* tables) {
    MessageTable table{name, {}};
    for (std::int64_t i = 0; i < size; ++i) {
      table.rows.emplace_back();
      Struct(*field.nested, "", &table.rows.back(), nullptr);
    }
    tables->push_back(std::move(table));
  }

  void Array(const FieldLayout& field, const std::string& name,
             const std::vector<std::int64_t>& sizes, std::size_t dimension,
             std::vector<MessageField>* fields) {
    if (dimension == sizes.size()) {
      Element(field, name, fields);
      return;
    }
    for (std::int64_t i = 0; i < sizes[dimension]; ++i) {
      Array(field, name + "[" + std::to_string(i) + "]", sizes, dimension + 1, fields);
    }
  }

  void Element(const FieldLayout& field, const std::string& name,
               std::vector<MessageField>* fields) {
    switch (field.kind) {
      case FieldKind::kNested:
        Struct(*field.nested, name + ".", fields, nullptr);
        return;
      case FieldKind::kString: {
        const auto length = static_cast<std::size_t>(Read(4));  // The NUL included.
        fields->push_back({name, std::string(reinterpret_cast<const char*>(next_), length - 1)});
        next_ += length;
        return;
      }
      case FieldKind::kDouble: {
        const std::int64_t bits = Read(8);
        double value = 0.0;
        std::memcpy(&value, &bits, sizeof value);
        fields->push_back({name, value});
        return;
      }
      case FieldKind::kFloat: {
        const auto bits = static_cast<std::int32_t>(Read(4));
        float value = 0.0F;
        std::memcpy(&value, &bits, sizeof value);
        fields->push_back({name, double{value}});
        return;
      }
      case FieldKind::kByte:
      case FieldKind::kBoolean:
        fields->push_back({name, Read(1) & 0xff});  // Not signed.
        return;
      case FieldKind::kInt8:
      case FieldKind::kInt16:
      case FieldKind::kInt32:
      case FieldKind::kInt64:
        fields->push_back({name, Read(WireSize(field.kind))});
        return;
    }
  }

  std::int64_t Read(std::size_t bytes) noexcept {
    const std::int64_t value = ReadInteger(next_, bytes);
    next_ += bytes;
    return value;
  }

  const std::uint8_t* next_;
};

}  // namespace

const MessageLayout* FindLayout(const void* data, std::size_t size) noexcept {
  if (size < kFingerprintSize) return nullptr;
  const auto fingerprint = static_cast<std::uint64_t>(
      ReadInteger(static_cast<const std::uint8_t*>(data), kFingerprintSize));
  for (const MessageLayout* layout : layouts::kAll) {
    if (Fingerprint(*layout) == fingerprint) return layout;
  }
  return nullptr;
}

MessageContent ContentOf(const MessageLayout& layout, const void* data, std::size_t size) {
  const auto fingerprint = static_cast<std::int64_t>(Fingerprint(layout));
  const Refusal refusal = CheckBytes(layout, fingerprint, data, size, kMaxImageBytes);
  if (refusal != Refusal::kNone) {
    throw Error(std::string("not a message of type ") + layout.name + ": " + Name(refusal));
  }
  MessageContent content;
  Walker walker(static_cast<const std::uint8_t*>(data) + kFingerprintSize);
  walker.Struct(layout, "", &content.fields, &content.tables);
  return content;
}

}  // namespace vantage
