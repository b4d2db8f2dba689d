#include "vantage/config/section.h"

#include <algorithm>
#include <charconv>
#include <limits>
#include <set>
#include <sstream>
#include <system_error>

#include <yaml-cpp/yaml.h>

#include "vantage/math/angles.h"
#include "vantage/math/error.h"

namespace vantage {
namespace {

// What all sections of one file share.
struct File {
  std::string source;
  std::string folder;
  SchemaRecorder* recorder;
};

std::string Shown(double value) {
  std::ostringstream text;
  text.precision(10);
  text << value;
  return text.str();
}

// Text from a file as an error line shows it: short, and on one line.
std::string Quoted(const std::string& text) {
  constexpr std::size_t kLongest = 60;
  std::string shown = "'";
  for (const char c : text.substr(0, kLongest)) {
    const auto code = static_cast<unsigned char>(c);
    shown += code < 0x20 || code == 0x7f ? '?' : c;
  }
  return shown + (text.size() > kLongest ? "...'" : "'");
}

std::string Described(const YAML::Node& node) {
  switch (node.Type()) {
    case YAML::NodeType::Null:
      return "empty";
    case YAML::NodeType::Scalar:
      return node.Scalar().empty() ? "empty" : Quoted(node.Scalar());
    case YAML::NodeType::Sequence:
      return "a list";
    case YAML::NodeType::Map:
      return "a mapping";
    case YAML::NodeType::Undefined:
      break;
  }
  return "missing";
}

std::string Where(const File& file, const YAML::Mark& mark) {
  if (mark.is_null()) return file.source;
  return file.source + ":" + std::to_string(mark.line + 1);
}

// Quoted scalars are text whatever they hold.
bool IsPlain(const YAML::Node& node) {
  return node.IsScalar() && node.Tag() != "!";
}

// The whole scalar as a number, apart from the locale; nullopt when it is none. Infinities and NaN
// in YAML's spelling count as numbers, so that a range can refuse them by value.
std::optional<double> ToDouble(const YAML::Node& node) {
  if (!IsPlain(node)) return std::nullopt;
  const std::string& text = node.Scalar();
  if (text == ".nan" || text == ".NaN" || text == ".NAN") {
    return std::numeric_limits<double>::quiet_NaN();
  }
  const char* begin = text.data();
  const char* end = begin + text.size();
  if (begin != end && *begin == '+') ++begin;
  const bool negative = begin != end && *begin == '-';
  const std::string magnitude(begin + (negative ? 1 : 0), end);
  if (magnitude == ".inf" || magnitude == ".Inf" || magnitude == ".INF") {
    const double infinity = std::numeric_limits<double>::infinity();
    return negative ? -infinity : infinity;
  }
  // from_chars would take "inf" and "nan"; to YAML these are text.
  if (magnitude.empty() ||
      !(std::isdigit(static_cast<unsigned char>(magnitude[0])) || magnitude[0] == '.')) {
    return std::nullopt;
  }
  double value = 0.0;
  const auto [rest, error] = std::from_chars(begin, end, value);
  if (error != std::errc() || rest != end) return std::nullopt;
  return value;
}

std::optional<std::int64_t> ToInteger(const YAML::Node& node) {
  if (!IsPlain(node)) return std::nullopt;
  const std::string& text = node.Scalar();
  const char* begin = text.data();
  const char* end = begin + text.size();
  if (begin != end && *begin == '+') ++begin;
  std::int64_t value = 0;
  const auto [rest, error] = std::from_chars(begin, end, value);
  if (error != std::errc() || rest != end) return std::nullopt;
  return value;
}

std::string Interval(double lower, double upper) {
  return "[" + Shown(lower) + ", " + Shown(upper) + "]";
}

std::string Interval(std::int64_t lower, std::int64_t upper) {
  return "[" + std::to_string(lower) + ", " + std::to_string(upper) + "]";
}

std::string Spaced(const std::string& unit) {
  return unit.empty() ? "" : " " + unit;
}

std::string CountText(int min_count, int max_count, const char* what) {
  std::string text = std::to_string(min_count);
  if (max_count != min_count) text += " to " + std::to_string(max_count);
  return text + " " + what;
}

std::string Joined(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

// yaml-cpp does not say that a tab is what it dislikes.
std::string TabHint(const std::string& text, const YAML::Mark& mark) {
  if (mark.is_null()) return "";
  std::size_t begin = 0;
  for (int line = 0; line < mark.line && begin != std::string::npos; ++line) {
    begin = text.find('\n', begin);
    if (begin != std::string::npos) ++begin;
  }
  if (begin == std::string::npos) return "";
  const std::size_t end = text.find_first_not_of(" \t", begin);
  const bool has_tab = text.substr(begin, end - begin).find('\t') != std::string::npos;
  return has_tab ? " (the line is indented by a tab: use spaces)" : "";
}

// Edits (insert, delete, replace) that turn a into b.
std::size_t EditDistance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, replaced});
    }
  }
  return row[b.size()];
}

}  // namespace

struct Section::Impl {
  std::shared_ptr<const File> file;
  YAML::Node node;          // A mapping, or undefined for an absent section.
  YAML::Mark mark;          // Of the mapping, or of the nearest one around it.
  std::string path;         // "joints[2]"; empty for the root.
  std::string schema_path;  // "joints[]"
  std::set<std::string> asked;
  std::vector<std::shared_ptr<Impl>> children;

  [[nodiscard]] std::string PathOf(const std::string& key) const {
    return path.empty() || key.empty() ? path + key : path + "." + key;
  }

  // The node under `key`; undefined when there is none. Notes that the key was asked for.
  [[nodiscard]] YAML::Node Get(const std::string& key) {
    asked.insert(key);
    return Peek(key);
  }

  [[nodiscard]] YAML::Node Peek(const std::string& key) const {
    if (!node.IsDefined()) return YAML::Node(YAML::NodeType::Undefined);
    for (const auto& entry : node) {
      if (entry.first.Scalar() == key) return entry.second;
    }
    return YAML::Node(YAML::NodeType::Undefined);
  }

  // The section at `path` below this one; the same one each time, so that it remembers all reads.
  [[nodiscard]] std::shared_ptr<Impl> ChildAt(const std::string& child_path,
                                              const std::string& schema_key,
                                              const YAML::Node& value) {
    for (const auto& child : children) {
      if (child->path == child_path) return child;
    }
    auto child = std::make_shared<Impl>();
    child->file = file;
    child->path = child_path;
    child->schema_path = SchemaPathOf(schema_key);
    child->node.reset(value);
    child->mark = value.IsDefined() ? value.Mark() : mark;
    children.push_back(child);
    return child;
  }

  [[nodiscard]] std::string SchemaPathOf(const std::string& key) const {
    return schema_path.empty() ? key : schema_path + "." + key;
  }

  void Record(const std::string& key, SchemaEntry entry) const {
    if (file->recorder == nullptr) return;
    entry.path = SchemaPathOf(key);
    file->recorder->Add(entry);
  }

  [[noreturn]] void Fail(const YAML::Mark& at, const std::string& full_path,
                         const std::string& reason) const {
    throw ConfigError(Where(*file, at.is_null() ? mark : at), full_path, reason);
  }

  [[noreturn]] void FailMissing(const std::string& key) const {
    Fail(mark, PathOf(key), "missing");
  }

  // A list of scalars of the right length.
  [[nodiscard]] YAML::Node List(const std::string& key, int min_count, int max_count,
                                const char* what) {
    const YAML::Node list = Get(key);
    if (!list.IsDefined()) FailMissing(key);
    const std::string wanted = "must be a list of " + CountText(min_count, max_count, what);
    if (!list.IsSequence()) Fail(list.Mark(), PathOf(key), wanted + ", is " + Described(list));
    const int count = static_cast<int>(list.size());
    if (count < min_count || count > max_count) {
      Fail(list.Mark(), PathOf(key), wanted + ", has " + std::to_string(count));
    }
    return list;
  }

  [[nodiscard]] double CheckedNumber(const YAML::Node& value, const std::string& full_path,
                                     const Range& range) const {
    const std::optional<double> number = ToDouble(value);
    if (!number) Fail(value.Mark(), full_path, "must be a number, is " + Described(value));
    if (!(*number >= range.lower && *number <= range.upper)) {
      Fail(value.Mark(), full_path,
           "must be in " + Interval(range.lower, range.upper) + Spaced(range.unit) + ", is " +
               value.Scalar());
    }
    return *number;
  }

  [[nodiscard]] std::int64_t CheckedInteger(const YAML::Node& value, const std::string& full_path,
                                            std::int64_t lower, std::int64_t upper) const {
    const std::optional<std::int64_t> number = ToInteger(value);
    if (!number) Fail(value.Mark(), full_path, "must be an integer, is " + Described(value));
    if (*number < lower || *number > upper) {
      Fail(value.Mark(), full_path,
           "must be in " + Interval(lower, upper) + ", is " + value.Scalar());
    }
    return *number;
  }
};

namespace {

// Keys must be text and unique: yaml-cpp itself keeps both of two equal keys and finds the first.
void RequireKeys(const File& file, const YAML::Node& mapping, const std::string& path) {
  std::set<std::string> seen;
  for (const auto& entry : mapping) {
    const YAML::Node& key = entry.first;
    if (!key.IsScalar()) {
      throw ConfigError(Where(file, key.Mark()), path,
                        "keys must be text, one is " + Described(key));
    }
    if (!seen.insert(key.Scalar()).second) {
      throw ConfigError(Where(file, key.Mark()),
                        path.empty() ? key.Scalar() : path + "." + key.Scalar(), "is given twice");
    }
  }
}

}  // namespace

Section::Section(std::shared_ptr<Impl> impl) : impl_(std::move(impl)) {}

Section::Form Section::FormOf(const std::string& key) const {
  const YAML::Node value = impl_->Peek(key);
  if (!value.IsDefined()) return Form::kAbsent;
  if (value.IsMap()) return Form::kMapping;
  return value.IsSequence() ? Form::kList : Form::kScalar;
}

bool Section::present() const {
  return impl_->node.IsDefined();
}

const std::string& Section::folder() const {
  return impl_->file->folder;
}

double Section::Number(const std::string& key, const Range& range, std::optional<double> fallback,
                       const std::string& help) const {
  impl_->Record(key, {"", "number", range.unit, Interval(range.lower, range.upper),
                      fallback ? Shown(*fallback) : "", help});
  const YAML::Node value = impl_->Get(key);
  if (value.IsDefined()) return impl_->CheckedNumber(value, impl_->PathOf(key), range);
  if (!fallback) impl_->FailMissing(key);
  return *fallback;
}

double Section::Degrees(const std::string& key, const Range& range_deg,
                        std::optional<double> fallback_deg, const std::string& help) const {
  return Number(key, range_deg, fallback_deg, help) * kDegree;
}

std::int64_t Section::Integer(const std::string& key, std::int64_t lower, std::int64_t upper,
                              std::optional<std::int64_t> fallback, const std::string& help) const {
  impl_->Record(key, {"", "integer", "", Interval(lower, upper),
                      fallback ? std::to_string(*fallback) : "", help});
  const YAML::Node value = impl_->Get(key);
  if (value.IsDefined()) return impl_->CheckedInteger(value, impl_->PathOf(key), lower, upper);
  if (!fallback) impl_->FailMissing(key);
  return *fallback;
}

bool Section::Flag(const std::string& key, std::optional<bool> fallback,
                   const std::string& help) const {
  impl_->Record(
      key, {"", "true or false", "", "", fallback ? (*fallback ? "true" : "false") : "", help});
  const YAML::Node value = impl_->Get(key);
  if (!value.IsDefined()) {
    if (!fallback) impl_->FailMissing(key);
    return *fallback;
  }
  if (IsPlain(value) && value.Scalar() == "true") return true;
  if (IsPlain(value) && value.Scalar() == "false") return false;
  impl_->Fail(value.Mark(), impl_->PathOf(key), "must be true or false, is " + Described(value));
}

std::string Section::Text(const std::string& key, const std::optional<std::string>& fallback,
                          const std::string& help) const {
  constexpr std::size_t kLongest = 1000;
  impl_->Record(key, {"", "text", "", "", fallback ? *fallback : "", help});
  const YAML::Node value = impl_->Get(key);
  if (!value.IsDefined()) {
    if (!fallback) impl_->FailMissing(key);
    return *fallback;
  }
  const std::string full_path = impl_->PathOf(key);
  if (!value.IsScalar() || value.Scalar().empty()) {
    impl_->Fail(value.Mark(), full_path, "must be text, is " + Described(value));
  }
  const std::string& text = value.Scalar();
  if (text.size() > kLongest) {
    impl_->Fail(value.Mark(), full_path,
                "must be at most " + std::to_string(kLongest) + " characters, is " +
                    std::to_string(text.size()));
  }
  const bool has_control = std::any_of(text.begin(), text.end(), [](char c) {
    const auto code = static_cast<unsigned char>(c);
    return code < 0x20 || code == 0x7f;
  });
  if (has_control) {
    impl_->Fail(value.Mark(), full_path,
                "must be one line without control characters, is " + Quoted(text));
  }
  return text;
}

Eigen::VectorXd Section::Numbers(const std::string& key, const Range& range, int min_count,
                                 int max_count, const std::string& help) const {
  impl_->Record(key, {"", "list of " + CountText(min_count, max_count, "numbers"), range.unit,
                      Interval(range.lower, range.upper), "", help});
  const YAML::Node list = impl_->List(key, min_count, max_count, "numbers");
  Eigen::VectorXd values(list.size());
  for (std::size_t i = 0; i < list.size(); ++i) {
    values(i) =
        impl_->CheckedNumber(list[i], impl_->PathOf(key) + "[" + std::to_string(i) + "]", range);
  }
  return values;
}

Eigen::Vector3d Section::Vector3(const std::string& key, const Range& range,
                                 const std::optional<Eigen::Vector3d>& fallback,
                                 const std::string& help) const {
  if (fallback) {
    const std::string shown = "[" + Shown(fallback->x()) + ", " + Shown(fallback->y()) + ", " +
                              Shown(fallback->z()) + "]";
    impl_->Record(key, {"", "list of 3 numbers", range.unit, Interval(range.lower, range.upper),
                        shown, help});
    if (!impl_->Get(key).IsDefined()) return *fallback;
  }
  return Numbers(key, range, 3, 3, help);
}

std::vector<std::int64_t> Section::Integers(const std::string& key, std::int64_t lower,
                                            std::int64_t upper, int min_count, int max_count,
                                            const std::string& help) const {
  impl_->Record(key, {"", "list of " + CountText(min_count, max_count, "integers"), "",
                      Interval(lower, upper), "", help});
  const YAML::Node list = impl_->List(key, min_count, max_count, "integers");
  std::vector<std::int64_t> values;
  for (std::size_t i = 0; i < list.size(); ++i) {
    values.push_back(impl_->CheckedInteger(
        list[i], impl_->PathOf(key) + "[" + std::to_string(i) + "]", lower, upper));
  }
  return values;
}

std::size_t Section::ChoiceIndex(const std::string& key, const std::vector<std::string>& names,
                                 std::optional<std::size_t> fallback,
                                 const std::string& help) const {
  impl_->Record(key,
                {"", "one of " + Joined(names), "", "", fallback ? names[*fallback] : "", help});
  const YAML::Node value = impl_->Get(key);
  if (!value.IsDefined()) {
    if (!fallback) impl_->FailMissing(key);
    return *fallback;
  }
  if (value.IsScalar()) {
    const auto found = std::find(names.begin(), names.end(), value.Scalar());
    if (found != names.end()) return static_cast<std::size_t>(found - names.begin());
  }
  impl_->Fail(value.Mark(), impl_->PathOf(key),
              "must be one of " + Joined(names) + ", is " + Described(value));
}

Section Section::Child(const std::string& key, const std::string& help) const {
  impl_->Record(key, {"", "section", "", "", "", help});
  if (!impl_->Get(key).IsDefined()) impl_->FailMissing(key);
  return OptionalChild(key, help);
}

Section Section::OptionalChild(const std::string& key, const std::string& help) const {
  impl_->Record(key, {"", "section", "", "", "{}", help});
  const YAML::Node value = impl_->Get(key);
  if (!value.IsDefined()) return Section(impl_->ChildAt(impl_->PathOf(key), key, value));
  if (!value.IsMap()) {
    impl_->Fail(value.Mark(), impl_->PathOf(key), "must be a mapping, is " + Described(value));
  }
  RequireKeys(*impl_->file, value, impl_->PathOf(key));
  return Section(impl_->ChildAt(impl_->PathOf(key), key, value));
}

std::vector<Section> Section::Children(const std::string& key, int min_count, int max_count,
                                       const std::string& help) const {
  impl_->Record(key, {"", "list of " + CountText(min_count, max_count, "sections"), "", "",
                      min_count == 0 ? "[]" : "", help});
  if (min_count == 0 && !impl_->Get(key).IsDefined()) return {};
  const YAML::Node list = impl_->List(key, min_count, max_count, "mappings");
  std::vector<Section> children;
  for (std::size_t i = 0; i < list.size(); ++i) {
    const std::string path = impl_->PathOf(key) + "[" + std::to_string(i) + "]";
    if (!list[i].IsMap()) {
      impl_->Fail(list[i].Mark(), path, "must be a mapping, is " + Described(list[i]));
    }
    RequireKeys(*impl_->file, list[i], path);
    children.push_back(Section(impl_->ChildAt(path, key + "[]", list[i])));
  }
  return children;
}

Section Section::With(const Section* over, const std::vector<std::string>& without) const {
  YAML::Node merged(YAML::NodeType::Map);
  const auto add = [&](const Impl& from, const Impl* hidden_by) {
    if (!from.node.IsDefined()) return;
    for (const auto& entry : from.node) {
      const std::string& key = entry.first.Scalar();
      if (std::find(without.begin(), without.end(), key) != without.end()) continue;
      if (hidden_by != nullptr && hidden_by->Peek(key).IsDefined()) continue;
      merged.force_insert(entry.first, entry.second);  // keeps the marks of both
    }
  };
  add(*impl_, over == nullptr ? nullptr : over->impl_.get());
  if (over != nullptr) {
    add(*over->impl_, nullptr);
    for (const auto& entry : over->impl_->node) over->impl_->asked.insert(entry.first.Scalar());
  }
  auto impl = std::make_shared<Impl>();
  impl->file = impl_->file;
  impl->path = impl_->path;
  impl->schema_path = impl_->schema_path;
  impl->node.reset(merged);
  impl->mark = over == nullptr ? impl_->mark : over->impl_->mark;
  return Section(impl);
}

void Section::RejectUnknownKeys() const {
  if (impl_->node.IsDefined()) {
    for (const auto& entry : impl_->node) {
      const std::string& key = entry.first.Scalar();
      if (impl_->asked.count(key) != 0) continue;
      std::string nearest;
      std::size_t distance = 3;  // Further away is no misspelling.
      for (const std::string& known : impl_->asked) {
        const std::size_t edits = EditDistance(key, known);
        if (edits < distance) {
          distance = edits;
          nearest = known;
        }
      }
      const std::vector<std::string> known(impl_->asked.begin(), impl_->asked.end());
      impl_->Fail(entry.first.Mark(), impl_->PathOf(Quoted(key).substr(1, Quoted(key).size() - 2)),
                  "unknown key" + (nearest.empty() ? "; known here: " + Joined(known)
                                                   : "; did you mean '" + nearest + "'?"));
    }
  }
  for (const auto& child : impl_->children) Section(child).RejectUnknownKeys();
}

void Section::Fail(const std::string& key, const std::string& reason) const {
  const YAML::Node value = impl_->Peek(key);
  impl_->Fail(value.IsDefined() ? value.Mark() : impl_->mark, impl_->PathOf(key), reason);
}

Section ParseConfig(const ConfigText& text, SchemaRecorder* recorder) {
  const auto file = std::make_shared<const File>(File{text.source, text.folder, recorder});
  if (text.text.find('\0') != std::string::npos) {
    throw ConfigError(text.source, "", "is not a text file");
  }
  std::vector<YAML::Node> documents;
  try {
    documents = YAML::LoadAll(text.text);
  } catch (const YAML::Exception& error) {
    throw ConfigError(Where(*file, error.mark), "",
                      "not valid YAML: " + error.msg + TabHint(text.text, error.mark));
  }
  if (documents.empty() || (documents.size() == 1 && documents[0].IsNull())) {
    throw ConfigError(text.source, "", "is empty");
  }
  if (documents.size() > 1) {
    throw ConfigError(text.source, "",
                      "must be one YAML document, holds " + std::to_string(documents.size()));
  }
  const YAML::Node& root = documents[0];
  if (!root.IsMap()) {
    throw ConfigError(Where(*file, root.Mark()), "", "must be a mapping, is " + Described(root));
  }
  RequireKeys(*file, root, "");
  auto impl = std::make_shared<Section::Impl>();
  impl->file = file;
  impl->node.reset(root);
  impl->mark = root.Mark();
  return Section(impl);
}

}  // namespace vantage
