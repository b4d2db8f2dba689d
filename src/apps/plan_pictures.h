#pragma once

#include <string>
#include <vector>

#include "vantage/config/placement_file.h"

namespace vantage {

/// Heat map of the objective over theta and phi of a spherical rig, over the first two free axes of
/// another: <stem>_map.png, .svg, .csv, and .gp (gnuplot). None for a rig with one free axis or none.
/// Returns the files. Throws WriteError when one cannot be written, Error when gnuplot fails.
std::vector<std::string> PlotPlacementMap(const PlacementSetup& setup, const PlacementModel& model,
                                          const PlacementResult& result, const std::string& stem);

/// The arm half-way through its motion, seen from the best and from the worst camera, side by side:
/// <stem>_views.png. Throws WriteError when it cannot be written.
std::vector<std::string> DrawViews(const PlacementSetup& setup, const PlacementResult& result,
                                   const std::string& stem);

}  // namespace vantage
