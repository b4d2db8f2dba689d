#include "vantage/config/camera_plan_file.h"

#include <algorithm>
#include <cmath>

#include "vantage/math/angles.h"
#include "vantage/math/format.h"

namespace vantage {
namespace {

std::string KeyOf(const CameraRig& rig, int axis) {
  return rig.axes[axis].name + (AxisTurns(rig, axis) ? "_deg" : "");
}

}  // namespace

std::string CameraStartText(const CameraRig& rig, const RigVector& q_c) {
  std::string text = "camera_start: {";
  for (int i = 0; i < rig.size(); ++i) {
    text += (i > 0 ? ", " : "") + KeyOf(rig, i) + ": " +
            ExactText(q_c(i) * (AxisTurns(rig, i) ? kDegreesPerRadian : 1.0));
  }
  return text + "}\n";
}

RigVector ReadCameraStart(const Section& root, const CameraRig& rig) {
  const Section start = root.Child(
      "camera_start", "Where the camera starts, by axis, instead of the axes' own starts.");
  RigVector q_c(rig.size());
  for (int i = 0; i < rig.size(); ++i) {
    const RigAxis& axis = rig.axes[i];
    const double unit = AxisTurns(rig, i) ? kDegreesPerRadian : 1.0;
    const std::string help = "Coordinate at the start.";
    // What was written for this rig may leave a limit by a rounding.
    const double slack = 1e-9 * std::max(1.0, std::abs(axis.upper) + std::abs(axis.lower));
    const Range range{(axis.lower - slack) * unit, (axis.upper + slack) * unit,
                      AxisTurns(rig, i) ? "deg" : "m"};
    q_c(i) = start.Number(KeyOf(rig, i), range, kRequired, help) / unit;
  }
  return ClampToLimits(rig, q_c);
}

RigVector LoadCameraStart(const std::string& path, const CameraRig& rig) {
  return ReadCameraStart(ParseConfig(ReadConfigFile(path)), rig);
}

}  // namespace vantage
