#include "vantage/config/schema.h"

#include <algorithm>

namespace vantage {

void SchemaRecorder::Add(const SchemaEntry& entry) {
  const auto known = std::find_if(entries_.begin(), entries_.end(), [&](const SchemaEntry& other) {
    return other.path == entry.path;
  });
  if (known == entries_.end()) {
    entries_.push_back(entry);
  } else if (known->type.find(entry.type) == std::string::npos) {
    known->type += " or " + entry.type;
  }
}

}  // namespace vantage
