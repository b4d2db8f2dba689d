#define PCRE2_CODE_UNIT_WIDTH 8
#include "channel_pattern.h"

#include <algorithm>
#include <cstdint>

#include <pcre2.h>

namespace vantage {
namespace {

// A pattern on a name of at most 255 letters that needs more steps than this is not meant well.
constexpr std::uint32_t kMaxSteps = 20'000;
constexpr std::uint32_t kMaxHeapKilobytes = 256;

bool IsPlain(const std::string& pattern) {
  return std::all_of(pattern.begin(), pattern.end(), [](char c) {
    return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_' ||
           c == '-' || c == '/' || c == ':';
  });
}

}  // namespace

void ChannelPattern::Free::operator()(pcre2_code* code) const noexcept {
  pcre2_code_free(code);
}
void ChannelPattern::Free::operator()(pcre2_match_data* data) const noexcept {
  pcre2_match_data_free(data);
}
void ChannelPattern::Free::operator()(pcre2_match_context* context) const noexcept {
  pcre2_match_context_free(context);
}

std::optional<ChannelPattern> ChannelPattern::Compile(const std::string& pattern) {
  ChannelPattern result(pattern);
  if (IsPlain(pattern)) return result;
  int error = 0;
  PCRE2_SIZE error_at = 0;
  result.code_.reset(pcre2_compile(reinterpret_cast<PCRE2_SPTR>(pattern.data()), pattern.size(),
                                   PCRE2_ANCHORED | PCRE2_ENDANCHORED | PCRE2_NEVER_BACKSLASH_C,
                                   &error, &error_at, nullptr));
  if (!result.code_) return std::nullopt;
  result.match_.reset(pcre2_match_data_create(1, nullptr));
  result.limits_.reset(pcre2_match_context_create(nullptr));
  if (!result.match_ || !result.limits_) return std::nullopt;
  pcre2_set_match_limit(result.limits_.get(), kMaxSteps);
  pcre2_set_depth_limit(result.limits_.get(), kMaxSteps);
  pcre2_set_heap_limit(result.limits_.get(), kMaxHeapKilobytes);
  return result;
}

bool ChannelPattern::Matches(std::string_view channel) const {
  if (!code_) return channel == text_;
  // 0: matched, but the one pair of offsets asked for did not hold all groups. Errors, the limits among
  // them, are negative: no match.
  return pcre2_match(code_.get(), reinterpret_cast<PCRE2_SPTR>(channel.data()), channel.size(), 0,
                     0, match_.get(), limits_.get()) >= 0;
}

}  // namespace vantage
