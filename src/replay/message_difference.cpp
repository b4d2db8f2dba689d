#include "message_difference.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "vantage/math/error.h"
#include "vantage/math/format.h"
#include "vantage/messaging/message_fields.h"

namespace vantage {
namespace {

std::vector<MessageField> FieldsOf(const Bytes& bytes) {
  const MessageLayout* layout = FindLayout(bytes.data(), bytes.size());
  if (layout == nullptr) throw Error("a message of an unknown type");
  return ContentOf(*layout, bytes.data(), bytes.size()).fields;
}

std::string ToText(const MessageField& field) {
  if (const auto* integer = std::get_if<std::int64_t>(&field.value)) {
    return std::to_string(*integer);
  }
  if (const auto* text = std::get_if<std::string>(&field.value)) return "'" + *text + "'";
  return ExactText(std::get<double>(field.value));
}

// |a - b| / max(1, |a|), infinite when just one of them is no number.
double Distance(double a, double b) {
  if (a == b || (std::isnan(a) && std::isnan(b))) return 0.0;
  const double distance = std::abs(a - b) / std::max(1.0, std::abs(a));
  return std::isnan(distance) ? std::numeric_limits<double>::infinity() : distance;
}

}  // namespace

MessageDifference Compare(const Bytes& a, const Bytes& b, double tolerance,
                          const std::set<std::string>& ignored) {
  const std::vector<MessageField> left = FieldsOf(a);
  const std::vector<MessageField> right = FieldsOf(b);
  MessageDifference difference;
  for (std::size_t i = 0; i < std::min(left.size(), right.size()); ++i) {
    const MessageField& x = left[i];
    const MessageField& y = right[i];
    if (x.name == y.name && ignored.count(x.name) != 0) continue;
    bool same = x.name == y.name && x.value == y.value;
    const auto* number = std::get_if<double>(&x.value);
    const auto* other = std::get_if<double>(&y.value);
    if (x.name == y.name && number != nullptr && other != nullptr) {
      const double distance = Distance(*number, *other);
      difference.worst = std::max(difference.worst, distance);
      same = distance <= tolerance;
    }
    if (!same && !difference.first) difference.first = {x.name, ToText(x), ToText(y)};
  }
  if (left.size() != right.size() && !difference.first) {
    difference.first = {"number of values", std::to_string(left.size()),
                        std::to_string(right.size())};
  }
  return difference;
}

}  // namespace vantage
