#pragma once

#include <optional>
#include <string>

#include "vantage/config/placement_file.h"
#include "vantage/plan/grid_check.h"

namespace vantage {

/// The result as YAML: `camera_start` is what vantage-run --camera-plan takes, the rest is the
/// certificate. Numbers are written to their last bit.
void WritePlacementResult(const std::string& path, const PlacementSetup& setup,
                          const PlacementModel& model, const PlacementResult& result,
                          double seconds, const std::optional<GridCheck>& check);

/// A camera path as CSV: time, rig coordinates (rad, m), camera position, and the joints of the arm.
void WriteCameraPath(const std::string& path, const PlacementSetup& setup,
                     const CameraPath& camera);

}  // namespace vantage
