#pragma once

#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "vantage/camera/camera_model.h"
#include "vantage/camera/camera_rig.h"
#include "vantage/config/section.h"
#include "vantage/features/feature_set.h"
#include "vantage/features/marker.h"
#include "vantage/robot/arm_model.h"

/// @file
/// From sections of a file to the values of the other modules. Files hold SI units and pixels, but for
/// keys that end in _deg, _deg_s or _deg_s2. All throw ConfigError with file, line and key.

namespace vantage {

/// Rigid motion under `key`: {position: [x, y, z], rpy_deg: [roll, pitch, yaw]} with
/// R = Rz(yaw) Ry(pitch) Rx(roll) as URDF has it, or quaternion: [w, x, y, z] instead of rpy_deg.
/// An absent key is the identity unless `required`.
[[nodiscard]] Eigen::Isometry3d LoadPose(const Section& parent, const std::string& key,
                                         bool required, const std::string& help);

/// The pose of a camera: as LoadPose(), required, or {position, look_at: [x, y, z], roll_deg}.
[[nodiscard]] Eigen::Isometry3d LoadCameraPose(const Section& parent, const std::string& key,
                                               const std::string& help);

/// What is to be said of an arm from a URDF file (see UrdfArm).
struct RobotRemarks {
  std::vector<std::string> warnings;  ///< What is missing in the file and was replaced.
  std::vector<std::string> notes;     ///< What the file leaves open and was chosen.
};

/// An arm, from the root of a robot file or from a mapping within another file: DH rows, or the path of
/// a URDF file under `urdf`.
/// @param remarks  Added to; may be null.
[[nodiscard]] ArmModel LoadRobot(const Section& section, RobotRemarks* remarks = nullptr);

/// The arm of a robot file, YAML or URDF (by its ending): see FindConfigText() for `name_or_path` and
/// `folder`.
[[nodiscard]] ArmModel FindRobot(const std::string& name_or_path, const std::string& folder = "",
                                 SchemaRecorder* recorder = nullptr,
                                 RobotRemarks* remarks = nullptr);

/// The arm under `key`: the name or path of a robot file, or a mapping as LoadRobot() reads it.
[[nodiscard]] ArmModel LoadRobotUnder(const Section& parent, const std::string& key,
                                      RobotRemarks* remarks = nullptr);

/// Joint values of `arm` under `key`_deg (all in degrees; arms without prismatic joints only) or under
/// `key` (rad and m): one of them, within the arm's limits.
[[nodiscard]] JointVector LoadJoints(const Section& parent, const std::string& key,
                                     const ArmModel& arm, const std::string& help);

/// Intrinsics.
[[nodiscard]] CameraModel LoadCamera(const Section& section);

/// A rig and where it starts.
struct RigSetup {
  CameraRig rig;        ///< Limits in metres and radians.
  RigVector q_c_start;  ///< Within the axes' limits.
};
/// Reads a `camera_rig` section.
[[nodiscard]] RigSetup LoadRig(const Section& section);

/// The list of markers under `key`, ids unique.
[[nodiscard]] std::vector<Marker> LoadMarkers(const Section& parent, const std::string& key,
                                              int min_count, int max_count,
                                              const std::string& help);

/// The features under `key`, over points numbered 0 to num_points - 1: the word all_points, or a list
/// of {kind, points}.
[[nodiscard]] std::vector<Feature> LoadFeatures(const Section& parent, const std::string& key,
                                                int num_points);

}  // namespace vantage
