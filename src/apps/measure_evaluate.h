#pragma once

#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include "measure_setup.h"
#include "vantage/active/view.h"
#include "vantage/features/feature_set.h"
#include "vantage/math/sizes.h"
#include "vantage/observability/measures.h"
#include "vantage/observability/paper_product.h"
#include "vantage/robot/kinematics.h"

namespace vantage {

/// All that is measured of one configuration.
struct Measurement {
  Kinematics kinematics;
  Eigen::Isometry3d X_WC{Eigen::Isometry3d::Identity()};
  std::vector<ViewFault> faults;  ///< Of each point; kNone: it is visible.
  std::vector<Eigen::Vector2d>
      uv;                     ///< Of each point, undistorted; 0 where it is behind the camera.
  std::vector<double> depth;  ///< Of each point [m]; may be negative.
  FeatureRows rows;           ///< Those whose points are all visible.
  FeatureJacobian J_v;
  ArmJacobian J_r;
  TaskJacobian J_c;
  SingularSystem view, arm, composite;
  Coupling coupling;
  bool low{false};  ///< w_c is below the set-up's threshold, or J_c lost rank.
  LowCause cause{LowCause::kNone};
  /// Worst motion of a point on the end effector that a feature error of one pixel may hide [mm/px];
  /// inf: any motion. For cameras beside the arm, and only where every feature is in pixels.
  std::optional<double> mm_per_px;
  std::optional<PaperProduct> translation;  ///< Where the set-up asks for it.
};

/// Measures the set-up at joints q and rig coordinates q_c. Points that are behind the camera, outside
/// a pixel camera's image or, if one-sided, hidden or seen from behind are not visible, and the
/// features that need them have no row. Never holds a NaN.
/// @pre q and q_c have the sizes of the arm and the rig.
[[nodiscard]] Measurement Evaluate(const MeasureSetup& setup, const JointVector& q,
                                   const RigVector& q_c);

}  // namespace vantage
