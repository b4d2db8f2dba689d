#include "plan_shard.h"

#include <cstdio>

#include "vantage/math/error.h"

namespace vantage {

Shard ParseShard(const std::string& text) {
  Shard shard;
  int used = 0;
  if (std::sscanf(text.c_str(), "%d/%d%n", &shard.index, &shard.count, &used) != 2 ||
      used != static_cast<int>(text.size()) || shard.count < 1 || shard.index < 1 ||
      shard.index > shard.count) {
    throw ConfigError("", "--shard", "must be i/N with 1 <= i <= N, is '" + text + "'");
  }
  return shard;
}

std::vector<int> ItemsOf(const Shard& shard, int all) {
  std::vector<int> items;
  for (int item = shard.index - 1; item < all; item += shard.count) items.push_back(item);
  return items;
}

std::string SuffixOf(const Shard& shard) {
  if (shard.count == 1) return "";
  return "_" + std::to_string(shard.index) + "_of_" + std::to_string(shard.count);
}

void DealToMyself(const std::vector<int>& items, const std::function<std::string(int)>& work,
                  const std::function<void(int, const std::string&)>& take) {
  for (const int item : items) take(item, work(item));
}

}  // namespace vantage
