#pragma once

#include <functional>
#include <string>
#include <vector>

/// @file
/// Work in numbered items that any number of machines may share: each item is worked out by itself, so the outcome
/// does not depend on how they were cut or dealt.

namespace vantage {

/// Part `index` of `count`.
struct Shard {
  int index{1};
  int count{1};
};

/// "2/8" as a shard. Throws ConfigError (key "--shard").
[[nodiscard]] Shard ParseShard(const std::string& text);

/// Of items 0 to all - 1 the shard's: index - 1, index - 1 + count, ...
[[nodiscard]] std::vector<int> ItemsOf(const Shard& shard, int all);

/// What the name of a shard's file ends with: "_2_of_8", or nothing where there is one part alone.
[[nodiscard]] std::string SuffixOf(const Shard& shard);

/// How items are shared out among those who work on them: calls `work` for each of `items`, somewhere, and
/// `take` here with what it returned, in any order. `take` is called on one process alone, `work` perhaps from
/// another thread than `take`.
using DealItems = std::function<void(
    const std::vector<int>& items, const std::function<std::string(int item)>& work,
    const std::function<void(int item, const std::string&)>& take)>;

/// All items here, one after the other.
void DealToMyself(const std::vector<int>& items, const std::function<std::string(int)>& work,
                  const std::function<void(int, const std::string&)>& take);

}  // namespace vantage
