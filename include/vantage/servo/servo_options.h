#pragma once

#include "vantage/control/servo_law.h"
#include "vantage/features/feature_set.h"
#include "vantage/servo/calibration_estimator.h"
#include "vantage/servo/reference_path.h"

namespace vantage {

/// How long an input may be used, and how old it may get.
struct StalenessLimits {
  double joint_state{0.05};  ///< [s]; > 0.
  double camera_pose{0.25};  ///< [s]; > 0.
  double features{0.25};     ///< Age of the newest image's exposure [s]; > 0.
  /// A marker that the newest image does not show is carried on by the model for this long [s]; >= 0.
  double marker{0.15};
  /// The same while two other markers of the arm are seen, which confirm the model [s]; >= 0.
  double hidden_marker{5.0};
};

/// When a servo counts as converged.
struct ConvergenceOptions {
  double tolerance_px{1.0};  ///< Root mean square error of the feature rows [px]; > 0.
  double settle_time{0.5};   ///< The error must stay below the tolerance this long [s]; >= 0.
  /// The view must certify the result: the worst motion of a marker that one pixel of error may hide
  /// [mm/px]; > 0.
  double max_mm_per_px{8.0};
  /// By the image, every marker must be nearer to its goal point than this [mm]; > 0.
  double tolerance_mm{1.0};
};

/// Options of one servo.
struct ServoOptions {
  double period{0.002};  ///< Control period [s]; in [0.0005, 0.1].
  /// Where interaction matrices come from.
  InteractionSource interaction{InteractionSource::kVisp};
  ServoLawOptions law;        ///< Gains and damping of the control law.
  ReferencePathOptions path;  ///< The way to the goal that the law follows.
  /// Whether the model carries the image from its exposure to now. False, for comparison: the newest image
  /// is taken for the present, as it is where no one minds the delay.
  bool latency_compensation{true};
  StalenessLimits staleness;       ///< How old the inputs may get.
  ConvergenceOptions convergence;  ///< When the goal counts as reached.
  /// Joints are kept this far inside their limits: room for encoder noise and for the lag of their
  /// drives [rad or m]; >= 0, at most a tenth of a joint's range is taken.
  double limit_margin{0.01};
  bool hold_while_camera_moves{false};  ///< Stop and go: the arm rests until the camera is there.
  /// While the camera moves to a better view the arm rests where one pixel may hide more than this: such a
  /// view is too poor to steer by [mm/px]; > 0.
  double wait_mm_per_px{25.0};
  double stall_time{1.5};        ///< Error not falling for this long counts as stalled [s]; > 0.
  double feature_noise_px{0.3};  ///< Standard deviation of a measured pixel coordinate [px]; > 0.
  /// By how much errors of calibration shift a whole image, one view against another [px]; >= 0.
  double calibration_px{2.0};
  /// What may be wrong with the calibration of camera and arm; it is estimated from the arm's own markers.
  CalibrationPrior calibration;
  /// How the image differs from the model changes slowly: measured differences are averaged over about
  /// this time [s]; >= 0.
  double offset_time{0.15};
};

/// @throws ConfigError with key, bound and value of the first option that is out of its bounds.
void Validate(const ServoOptions& options);

}  // namespace vantage
