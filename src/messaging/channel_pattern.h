#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

// PCRE2's own names; its header wants a macro before it and stays in channel_pattern.cpp.
struct pcre2_real_code_8;
struct pcre2_real_match_data_8;
struct pcre2_real_match_context_8;

namespace vantage {

/// A subscription's regular expression, as LCM means it: the whole channel must match. Bounded in time
/// and memory whatever the pattern, which comes from outside.
class ChannelPattern {
 public:
  /// nullopt when the pattern is not a valid expression.
  static std::optional<ChannelPattern> Compile(const std::string& pattern);

  [[nodiscard]] bool Matches(std::string_view channel) const;
  [[nodiscard]] const std::string& text() const noexcept { return text_; }

 private:
  struct Free {
    void operator()(pcre2_real_code_8* code) const noexcept;
    void operator()(pcre2_real_match_data_8* data) const noexcept;
    void operator()(pcre2_real_match_context_8* context) const noexcept;
  };

  explicit ChannelPattern(std::string text) : text_(std::move(text)) {}

  std::string text_;
  // Empty for a plain name, which needs no engine.
  std::unique_ptr<pcre2_real_code_8, Free> code_;
  std::unique_ptr<pcre2_real_match_data_8, Free> match_;
  std::unique_ptr<pcre2_real_match_context_8, Free> limits_;
};

}  // namespace vantage
