#pragma once

#include <string>

#include "vantage/camera/camera_model.h"

namespace vantage {

/// Reads the intrinsics of a camera from a calibration file:
/// - OpenCV's YAML, XML or JSON: camera_matrix and distortion_coefficients, or the other names that
///   calibration programs use (cameraMatrix, K, M1; dist_coeffs, D, D1, ...);
/// - ROS's camera_info YAML: the same with {rows, cols, data};
/// - ViSP's camera XML (vpXmlParserCamera). `name` chooses one of several cameras; of the models of a
///   camera the one with distortion is taken (kud), else the one without.
///
/// The size comes from the file, or is the given one where the file has none.
///
/// @param width, height  Image size in use [px]; 0: the file's. A file for another size is refused.
/// Throws ConfigError with the file, the key and what is wrong: a file that cannot be read, a matrix
/// that is not a calibration, a size that does not fit, lens models other than radial-tangential with up
/// to five coefficients (rational, thin prism, fisheye).
[[nodiscard]] CameraModel ReadCalibration(const std::string& path, int width = 0, int height = 0,
                                          const std::string& name = "");

}  // namespace vantage
