#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <nlohmann/json_fwd.hpp>

#include "vantage/camera/camera_model.h"
#include "vantage/camera/camera_rig.h"
#include "vantage/camera/pinhole.h"
#include "vantage/features/feature_set.h"
#include "vantage/math/sizes.h"
#include "vantage/robot/arm_model.h"

/// @file
/// One configuration of arm, camera and features as the oracle files write it (JSON; the form and its
/// conventions are those of tests/data/oracles.json and docs/paper.md). Everything here throws
/// ConfigError, which names the key, for what is missing, of the wrong type or not known.

namespace vantage {

/// A point that features are computed from.
struct OraclePoint {
  bool on_body{true};                          ///< Fixed to E; false: to W.
  Eigen::Vector3d p{Eigen::Vector3d::Zero()};  ///< In that frame [m].
};

/// A camera given by spherical coordinates: a spherical rig of four axes at q_c.
struct OracleSphere {
  CameraRig rig;  ///< RigKind::kSpherical; limits are wide: ±1e6 rad or m.
  RigVector q_c;  ///< (R [m], theta [rad], phi [rad], roll [rad]).
};

/// Camera of a case: fixed in the world or carried by the end effector.
struct OracleCamera {
  bool eye_in_hand{false};  ///< Carried by E; false: fixed in W.
  CameraModel model;        ///< Without distortion. "Normalised" units: fx = fy = 1, u0 = v0 = 0.
  /// Pose in W, or in E for eye_in_hand.
  Eigen::Isometry3d X{Eigen::Isometry3d::Identity()};
  std::optional<OracleSphere> sphere;  ///< Where the file gives it; X is its pose.
};

/// What is measured in one case.
struct OracleCase {
  std::string id;                   ///< By which it is chosen from its file.
  std::string description;          ///< In words; may be empty.
  ArmModel arm;                     ///< Limits are wide: ±100 rad or m.
  JointVector q;                    ///< Joints that it is measured at [rad or m].
  std::vector<OraclePoint> points;  ///< In the order that the features number them.
  FeatureSet features;              ///< Rows of J_v, over `points`.
  OracleCamera camera;              ///< Intrinsics and pose.
  int task_dimension{6};            ///< m.
};

/// Reads and parses a JSON file.
[[nodiscard]] nlohmann::json ReadJsonFile(const std::string& path);

/// A matrix written as a list of rows, of the same length and finite.
[[nodiscard]] Eigen::MatrixXd ParseJsonMatrix(const nlohmann::json& rows, const std::string& key);

/// A list of finite numbers.
[[nodiscard]] Eigen::VectorXd ParseJsonVector(const nlohmann::json& values, const std::string& key);

/// One feature: {"type": "point", "p": 0, "coord": "x"}, {"type": "distance" or "angle", "i", "j"},
/// {"type": "edge_angle", "i", "j", "k", "l"}, {"type": "area", "poly": [...]} or {"type": "centroid",
/// "pts": [...], "coord": "y"}.
[[nodiscard]] Feature ParseOracleFeature(const nlohmann::json& feature, const std::string& key);

/// An arm: {"name", "convention", "base", "tool", "joints"}.
[[nodiscard]] ArmModel ParseOracleArm(const nlohmann::json& robot, const std::string& key);

/// One entry of the list "cases". What is expected of it is not read.
/// @throws ConfigError also where k, n or the size of q do not fit the rest.
[[nodiscard]] OracleCase ParseOracleCase(const nlohmann::json& entry);

/// The case `id` of a file. Throws ConfigError with the ids there are when it is not one of them.
[[nodiscard]] OracleCase LoadOracleCase(const std::string& path, const std::string& id);

/// Camera pose in W of a case, for its arm at X_WE.
[[nodiscard]] Eigen::Isometry3d CameraPoseOf(const OracleCamera& camera,
                                             const Eigen::Isometry3d& X_WE) noexcept;

/// The points of a case as its camera sees them: those behind it are not visible.
[[nodiscard]] PointViews ViewPoints(const std::vector<OraclePoint>& points,
                                    const Eigen::Isometry3d& X_WE, const Eigen::Isometry3d& X_WC);

}  // namespace vantage
