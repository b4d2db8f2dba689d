#pragma once

#include <string>
#include <vector>

#include "plan_shard.h"
#include "vantage/config/placement_file.h"

/// @file
/// Many placements of one file, in shards that any number of machines may work on: each item is worked out
/// by itself, so the merged table does not depend on how it was cut.

namespace vantage {

/// What becomes of the lines that an interrupted run of the same sweep has left in its table.
enum class Begin {
  kWhereItStopped,  ///< They stay, and only what is missing is worked out.
  kAnew,
};

/// Solves the shard's items and writes one line for each as it comes, in the items' order in the end: its number
/// and case, where the base stands, whether a camera was found, its value, pose and rig coordinates, numbers to
/// their last bit; no times.
/// @param path  Of the table; empty for a process that only helps another with the items that it deals.
/// @param told  Share of what is missing and the best value so far.
/// @returns how many lines were left from before.
int RunSweep(const PlacementSetup& setup, const Shard& shard, const std::string& path,
             Begin begin = Begin::kWhereItStopped, const PlanProgress& told = {},
             const DealItems& deal = DealToMyself);

/// Joins the tables of all shards. Throws ConfigError when they are not of one problem, or an item is missing
/// or there twice.
void MergeSweeps(const std::vector<std::string>& paths, const std::string& path);

/// The best lines of a table in words.
[[nodiscard]] std::string BestOfSweep(const std::string& path, int most);

}  // namespace vantage
