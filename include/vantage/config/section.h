#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "vantage/config/config_text.h"
#include "vantage/config/schema.h"

/// @file
/// Reading of configuration files. Each read states the key's unit, bounds, default and meaning, and
/// each error is one line: "file:line: key: must be in [lo, hi] unit, is value".

namespace vantage {

/// Closed range of a number, both ends finite.
struct Range {
  double lower{0.0};  ///< Least value allowed, in `unit`.
  double upper{0.0};  ///< Greatest value allowed, in `unit`.
  std::string unit;   ///< As printed: "m", "px", "1/s"; empty: none.
};

/// In place of a default: the key must be there.
inline constexpr std::nullopt_t kRequired = std::nullopt;

/// One mapping of a YAML file, which knows its file, line and dotted path, and remembers the keys it
/// was asked for. A cheap handle: copies are the same section.
///
/// All reads throw ConfigError when the key is missing and has no default, has the wrong type, is out
/// of its range or not finite.
class Section {
 public:
  /// What stands behind a key.
  enum class Form { kAbsent, kScalar, kList, kMapping };
  /// What stands there, if anything.
  [[nodiscard]] Form FormOf(const std::string& key) const;

  /// False for an optional child that the file does not have.
  [[nodiscard]] bool present() const;
  /// Folder of the file, for paths relative to it; empty for built-in files.
  [[nodiscard]] const std::string& folder() const;

  /// A number in its range, in the unit that the range names.
  double Number(const std::string& key, const Range& range, std::optional<double> fallback,
                const std::string& help) const;
  /// An angle or its rate: degrees in the file (by convention the key ends in _deg, _deg_s or
  /// _deg_s2, and so do range and fallback), radians returned.
  double Degrees(const std::string& key, const Range& range_deg, std::optional<double> fallback_deg,
                 const std::string& help) const;
  /// A whole number, bounds included.
  std::int64_t Integer(const std::string& key, std::int64_t lower, std::int64_t upper,
                       std::optional<std::int64_t> fallback, const std::string& help) const;
  /// true or false.
  bool Flag(const std::string& key, std::optional<bool> fallback, const std::string& help) const;
  /// Any text that is not empty, of at most 1000 characters without control characters.
  std::string Text(const std::string& key, const std::optional<std::string>& fallback,
                   const std::string& help) const;
  /// A list of min_count to max_count numbers.
  Eigen::VectorXd Numbers(const std::string& key, const Range& range, int min_count, int max_count,
                          const std::string& help) const;
  /// Three numbers, each in the range.
  Eigen::Vector3d Vector3(const std::string& key, const Range& range,
                          const std::optional<Eigen::Vector3d>& fallback,
                          const std::string& help) const;
  /// A list of min_count to max_count integers.
  std::vector<std::int64_t> Integers(const std::string& key, std::int64_t lower, std::int64_t upper,
                                     int min_count, int max_count, const std::string& help) const;

  /// One of the names, as the value that belongs to it.
  template <typename T>
  using Names = std::vector<std::pair<std::string, T>>;
  /// One of the names.
  template <typename T>
  T Choice(const std::string& key, const Names<T>& names, std::optional<T> fallback,
           const std::string& help) const {
    std::vector<std::string> texts;
    std::optional<std::size_t> fallback_index;
    for (std::size_t i = 0; i < names.size(); ++i) {
      texts.push_back(names[i].first);
      if (fallback && names[i].second == *fallback) fallback_index = i;
    }
    return names[ChoiceIndex(key, texts, fallback_index, help)].second;
  }

  /// The mapping under `key`; it must be there.
  [[nodiscard]] Section Child(const std::string& key, const std::string& help) const;
  /// The same, or an empty section (whose reads give their defaults) when the file has none.
  [[nodiscard]] Section OptionalChild(const std::string& key, const std::string& help) const;
  /// The mappings of the list under `key`. An absent list is an empty one when min_count is 0.
  [[nodiscard]] std::vector<Section> Children(const std::string& key, int min_count, int max_count,
                                              const std::string& help) const;

  /// A section with this one's keys and those of `over` (null: none), which take the place of equal ones;
  /// without the keys of `without`. It remembers its reads by itself, and answers for all keys of `over`.
  [[nodiscard]] Section With(const Section* over, const std::vector<std::string>& without) const;

  /// Throws ConfigError for the first key of this section or of one below it that no read asked for.
  /// Call it once on the root, after all reads.
  void RejectUnknownKeys() const;

  /// Throws ConfigError about `key` (empty: about the section as a whole), with its file and line.
  [[noreturn]] void Fail(const std::string& key, const std::string& reason) const;

 private:
  friend Section ParseConfig(const ConfigText& text, SchemaRecorder* recorder);
  struct Impl;
  explicit Section(std::shared_ptr<Impl> impl);
  [[nodiscard]] std::size_t ChoiceIndex(const std::string& key,
                                        const std::vector<std::string>& names,
                                        std::optional<std::size_t> fallback,
                                        const std::string& help) const;

  std::shared_ptr<Impl> impl_;
};

/// The root section of a file.
///
/// @param recorder  Told of each read; may be null; outlives the section and those below it.
/// Throws ConfigError when the text is empty, no valid YAML, more than one document, not a mapping, or
/// holds a key twice.
[[nodiscard]] Section ParseConfig(const ConfigText& text, SchemaRecorder* recorder = nullptr);

}  // namespace vantage
