#include <cmath>

#include "vantage/config/config_text.h"
#include "vantage/config/loaders.h"
#include "vantage/math/error.h"
#include "vantage/vision/calibration_file.h"

namespace vantage {
namespace {

const Range kLens{-10.0, 10.0, ""};

Distortion LoadDistortion(const Section& section) {
  Distortion lens;
  lens.k1 = section.Number("k1", kLens, 0.0, "Radial coefficient of r^2.");
  lens.k2 = section.Number("k2", kLens, 0.0, "Radial coefficient of r^4.");
  lens.p1 = section.Number("p1", kLens, 0.0, "Tangential coefficient.");
  lens.p2 = section.Number("p2", kLens, 0.0, "Tangential coefficient.");
  lens.k3 = section.Number("k3", kLens, 0.0, "Radial coefficient of r^6.");
  return lens;
}

// Intrinsics from a calibration program's file; a size in the section must be the file's.
CameraModel LoadCalibration(const Section& section) {
  const std::string path = section.Text(
      "calibration", kRequired,
      "Calibration file in place of the numbers: OpenCV's YAML or XML, ROS's YAML, ViSP's XML.");
  const std::string name =
      section.Text("name", std::string("-"), "Which camera of a ViSP file that holds several.");
  const auto size = [&](const char* key) {
    return section.FormOf(key) == Section::Form::kAbsent
               ? 0
               : static_cast<int>(section.Integer(key, 16, 8192, kRequired, "Image size."));
  };
  try {
    return ReadCalibration(PathBeside(section.folder(), path), size("width"), size("height"),
                           name == "-" ? "" : name);
  } catch (const ConfigError& error) {
    section.Fail("calibration", error.what());
  }
}

}  // namespace

CameraModel LoadCamera(const Section& section) {
  if (section.FormOf("calibration") != Section::Form::kAbsent) return LoadCalibration(section);
  CameraModel camera;
  camera.width =
      static_cast<int>(section.Integer("width", 16, 8192, 640, "Image width in pixels."));
  camera.height =
      static_cast<int>(section.Integer("height", 16, 8192, 480, "Image height in pixels."));
  const Range focal{1.0, 1e5, "px"};
  camera.fx = section.Number("fx", focal, 600.0, "Focal length along the rows.");
  camera.fy =
      section.Number("fy", focal, camera.fx, "Focal length along the columns; default: fx.");
  const Range centre{-1e4, 2e4, "px"};
  camera.u0 = section.Number("u0", centre, 0.5 * (camera.width - 1),
                             "Principal point, column; default: the image's centre.");
  camera.v0 = section.Number("v0", centre, 0.5 * (camera.height - 1),
                             "Principal point, row; default: the image's centre.");
  camera.skew = section.Number("skew", {-1e4, 1e4, "px"}, 0.0, "Skew of the pixel axes.");
  camera.distortion = LoadDistortion(section.OptionalChild(
      "distortion", "Lens distortion, radial and tangential, as OpenCV defines it."));
  return camera;
}

}  // namespace vantage
