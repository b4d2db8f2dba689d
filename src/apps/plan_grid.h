#pragma once

#include <string>
#include <vector>

#include "plan_shard.h"
#include "vantage/config/placement_file.h"
#include "vantage/plan/grid_check.h"

/// @file
/// A grid check in shards and by several processes, and the tables that shards leave: their best cameras, from
/// which the gap is stated as if the grid had been searched in one go.

namespace vantage {

/// Searches the shard's blocks of a grid of `cameras`, dealt out by `deal`. What comes back is of worth on the
/// process that takes results alone.
/// @param told  Share of the work and the best value so far.
[[nodiscard]] SearchedGrid SearchGrid(const PlacementModel& model, std::int64_t cameras,
                                      const Shard& shard, const PlanProgress& told = {},
                                      const DealItems& deal = DealToMyself);

/// A shard's table (CSV): a line for each camera that was kept, best first, scores to their last bit.
/// Throws WriteError.
void WriteGridTable(const std::string& path, const PlacementSetup& setup, const Shard& shard,
                    const SearchedGrid& grid);

/// Whether the file's first line is that of such a table. Throws ConfigError when it cannot be opened.
[[nodiscard]] bool IsGridTable(const std::string& path);

/// Joins the tables of all shards of a grid. Throws ConfigError, with file and line, when one is not of this
/// problem, of another grid or cut than the first, damaged or there twice, or when one is missing.
/// @param paths  At least one.
[[nodiscard]] SearchedGrid ReadGridTables(const std::vector<std::string>& paths,
                                          const PlacementSetup& setup);

}  // namespace vantage
