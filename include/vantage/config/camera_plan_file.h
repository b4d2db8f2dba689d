#pragma once

#include <string>

#include "vantage/camera/camera_rig.h"
#include "vantage/config/section.h"

/// @file
/// What vantage-plan hands to vantage-run: where the camera starts.

namespace vantage {

/// The lines of a result file that LoadCameraStart() reads, numbers to their last bit.
[[nodiscard]] std::string CameraStartText(const CameraRig& rig, const RigVector& q_c);

/// Rig coordinates under `camera_start`, by the names of the axes.
/// Throws ConfigError when an axis is missing or its value is outside of its limits.
[[nodiscard]] RigVector ReadCameraStart(const Section& root, const CameraRig& rig);

/// The same of a result file; other keys of the file are not looked at.
[[nodiscard]] RigVector LoadCameraStart(const std::string& path, const CameraRig& rig);

}  // namespace vantage
