#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "map_recipe.h"
#include "measure_evaluate.h"

namespace vantage {

/// Measures at one point of a map.
struct MapCell {
  double x{0.0}, y{0.0};
  /// Every point was visible. Where one was not, fewer singular values make up the measures, which do
  /// not compare with the others: tables and pictures leave them out.
  bool complete{false};
  double w_v{0.0}, w_r{0.0}, w_c{0.0};
  int rank_c{0};
  double sigma_min_c{0.0}, condition_c{0.0}, geometric_mean_c{0.0};
  double w_v_translation{0.0}, w_r_translation{0.0}, paper_product{0.0};  ///< If asked for.
};

/// A map: cells row by row, x runs fastest.
struct MapTable {
  int columns{0}, rows{0};
  std::vector<MapCell> cells;
};

/// The measures where the two swept parameters are x and y.
[[nodiscard]] MapCell EvaluateCell(const MapRecipe& recipe, double x, double y);

/// All cells, on all cores.
/// @param progress  Told from this thread, now and then, how many rows of how many are done.
[[nodiscard]] MapTable Sweep(const MapRecipe& recipe,
                             const std::function<void(int done, int rows)>& progress = {});

/// The value of a quantity in a cell; nullopt where the cell is not complete or has none.
[[nodiscard]] std::optional<double> ValueOf(const MapCell& cell, MapQuantity quantity) noexcept;

/// Comma-separated table, one line per cell under a header with units; what is not known is empty.
/// Numbers keep all digits. Throws Error when the file cannot be written.
void WriteCsv(const MapRecipe& recipe, const MapTable& table, const std::string& path);

/// Least and greatest value of a quantity, and where: the first of equal ones.
struct MapExtremes {
  double min{0.0}, max{0.0};
  MapCell at_min, at_max;
};
/// nullopt when no cell is complete.
[[nodiscard]] std::optional<MapExtremes> FindExtremes(const MapTable& table,
                                                      MapQuantity quantity) noexcept;

}  // namespace vantage
