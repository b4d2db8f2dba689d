#pragma once

#include <string>

#include "vantage/camera/camera_rig.h"

/// @file
/// What vantage-plan hands to vantage-run: where the camera starts.

namespace vantage {

/// The lines of a result file that LoadCameraStart() reads, numbers to their last bit.
[[nodiscard]] std::string CameraStartText(const CameraRig& rig, const RigVector& q_c);

/// Rig coordinates under `camera_start` of a result file; other keys of the file are not looked at.
/// Throws ConfigError when an axis of the rig is missing or the value is outside of its limits.
[[nodiscard]] RigVector LoadCameraStart(const std::string& path, const CameraRig& rig);

}  // namespace vantage
