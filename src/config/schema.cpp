#include "vantage/config/schema.h"

#include <algorithm>

namespace vantage {
namespace {

// Whether `types`, parted by " or ", has `type` as one of its parts ("number" is none of "list of 3 numbers").
bool HasType(const std::string& types, const std::string& type) {
  return (" or " + types + " or ").find(" or " + type + " or ") != std::string::npos;
}

}  // namespace

void SchemaRecorder::Add(const SchemaEntry& entry) {
  const auto known = std::find_if(entries_.begin(), entries_.end(), [&](const SchemaEntry& other) {
    return other.path == entry.path;
  });
  if (known == entries_.end()) {
    entries_.push_back(entry);
  } else if (!HasType(known->type, entry.type)) {
    known->type += " or " + entry.type;
  }
}

}  // namespace vantage
