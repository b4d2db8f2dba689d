#pragma once

#include <string>
#include <vector>

#include "map_sweep.h"

namespace vantage {

/// Pictures of a map by gnuplot: <stem>_<quantity>_surface and _heat, each as .png and .svg, with the
/// script, which holds the data, left beside them as <stem>_<quantity>.gp.
///
/// @param stem  Folder and name that the files begin with.
/// @return the files written.
/// Throws Error when a file cannot be written, gnuplot fails, or there is nothing to show.
std::vector<std::string> PlotMap(const MapRecipe& recipe, const MapTable& table,
                                 MapQuantity quantity, const std::string& stem);

}  // namespace vantage
