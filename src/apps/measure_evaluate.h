#pragma once

#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include "measure_setup.h"
#include "vantage/active/view.h"
#include "vantage/features/feature_gradient.h"
#include "vantage/features/feature_set.h"
#include "vantage/math/sizes.h"
#include "vantage/observability/measures.h"
#include "vantage/observability/paper_product.h"
#include "vantage/observability/selection.h"
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
  PointViews views;           ///< What the features were computed from.
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

/// Gradients of log w; those of w are w times as much.
struct LogMeasureGradient {
  GradientStatus status{GradientStatus::kNotMeasured};
  ViewGradient by;  ///< 0 where the status is not kOk.
  RigVector rig;    ///< By the rig's coordinates; empty for a carried camera.
};

struct MeasureGradients {
  LogMeasureGradient view, composite;
};

/// Measures of whitened features.
struct WhitenedMeasures {
  Measure view, composite;
};

/// Of the features of a set-up those that were chosen.
struct FeatureChoice {
  Selection selection;  ///< Its rows are the features' indices.
  SelectionOptions options;
  int count{0};    ///< k, as asked for.
  int samples{1};  ///< Configurations.
};

/// What vantage-measure has to say of a set-up.
struct MeasureReport {
  Measurement measurement;
  MeasureGradients gradients;
  std::optional<WhitenedMeasures> whitened;
  std::optional<FeatureChoice> choice;  ///< Where it was asked for.
};

/// Measures the set-up at joints q and rig coordinates q_c. Points that are behind the camera, outside
/// a pixel camera's image or, if one-sided, hidden or seen from behind are not visible, and the
/// features that need them have no row. Never holds a NaN.
/// @pre q and q_c have the sizes of the arm and the rig.
[[nodiscard]] Measurement Evaluate(const MeasureSetup& setup, const JointVector& q,
                                   const RigVector& q_c);

/// Gradients of log w_v and log w_c of a measurement by the camera, its rig at q_c and the joints.
[[nodiscard]] MeasureGradients Differentiate(const MeasureSetup& setup, const Measurement& m,
                                             const RigVector& q_c);

/// nullopt where the set-up has no covariance.
[[nodiscard]] std::optional<WhitenedMeasures> WhitenedMeasuresOf(const MeasureSetup& setup,
                                                                 const Measurement& m);

/// All of it at the set-up's own configuration, without a choice of features.
[[nodiscard]] MeasureReport Report(const MeasureSetup& setup);

/// Chooses the best `count` features along the set-up's path (`samples` configurations of it), or at its
/// joints when it has none.
[[nodiscard]] FeatureChoice ChooseFeatures(const MeasureSetup& setup, int count, int samples,
                                           const SelectionOptions& options);

}  // namespace vantage
