#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "vantage/camera/camera_model.h"
#include "vantage/camera/camera_rig.h"
#include "vantage/config/section.h"
#include "vantage/features/feature_set.h"
#include "vantage/features/marker.h"
#include "vantage/math/sizes.h"
#include "vantage/robot/arm_model.h"

/// @file
/// What vantage-measure measures and vantage-map sweeps: an arm, a camera and features.

namespace vantage {

/// A point that features are computed from.
struct MeasuredPoint {
  Marker marker;          ///< Where it is; a plain point uses its position alone.
  bool on_body{true};     ///< Fixed to E; false: to W.
  bool one_sided{false};  ///< A marker: its back and the arm's links hide it. A point is a point.
};

/// One arm, camera and set of features at one configuration.
struct MeasureSetup {
  std::string name;         ///< Of the file, without folder and ending.
  std::string description;  ///< One line.
  ArmModel arm;
  JointVector q;       ///< [rad or m].
  CameraModel camera;  ///< Metric or normalised units: fx = fy = f, u0 = v0 = 0.
  /// Features in pixels. False: in the units of the focal length, without a border of the image.
  bool pixels{true};
  bool eye_in_hand{false};
  Eigen::Isometry3d X_EC{Eigen::Isometry3d::Identity()};  ///< Camera in E, for eye_in_hand.
  CameraRig rig;                                          ///< Where the camera stands otherwise.
  RigVector q_c;
  std::vector<MeasuredPoint> points;
  FeatureSet features;
  /// Dimension of the translation-only task of the paper's examples (docs/paper.md, sections 6 and 7):
  /// 2 for axes x and y of W, 3 for all. 0: its measures are not asked for.
  int translation_task{0};
  /// w_c^(1/s) below which w_c counts as low [px/rad]; 0: only where J_c loses rank.
  double threshold{0.0};
  std::vector<JointVector> waypoints;  ///< Of the trajectory (key `path`); empty: none.
  Eigen::MatrixXd covariance;          ///< Of all features' errors; 0×0 where it is not given.
};

/// One case of an oracle file (see oracle_case.h). Throws ConfigError.
[[nodiscard]] MeasureSetup LoadOracleSetup(const std::string& path, const std::string& id);

/// Reads the keys of a measurement from the root of a file; other keys may stand beside them.
/// Throws ConfigError with file, line and key.
[[nodiscard]] MeasureSetup LoadMeasureSetup(const Section& root);

/// A measurement file, or a built-in one by its name. Throws ConfigError.
/// @param recorder  Told of each key that is read (for the reference); may be null.
[[nodiscard]] MeasureSetup FindMeasureSetup(const std::string& name_or_path,
                                            SchemaRecorder* recorder = nullptr);

/// Short name of a feature over the given points: "x_0", "distance_0_1", "area_0_1_2".
[[nodiscard]] std::string NameOf(const Feature& feature);

/// Joints along straight lines between the waypoints, t in [0, 1] over lines of equal share.
/// @pre waypoints.size() >= 2.
[[nodiscard]] JointVector JointsAlong(const std::vector<JointVector>& waypoints, double t) noexcept;

/// Unit of a feature's value: "px", "rad", "px^2"; metric cameras have "-" for px.
[[nodiscard]] std::string UnitOf(const Feature& feature, bool pixels);

}  // namespace vantage
