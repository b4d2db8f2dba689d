#pragma once

#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include "vantage/math/sizes.h"
#include "vantage/robot/arm_model.h"
#include "vantage/robot/kinematics.h"

/// @file
/// A path in the image from where the markers are to where they have to go, by way of what the arm can
/// do. Far from the goal, the straight way in the image may lead an arm to a limit, to a wrong branch or
/// out of view; the image of a straight way in joint space does not.

namespace vantage {

/// Settings of the reference path.
struct ReferencePathOptions {
  bool enabled{true};  ///< False: the reference is always the goal itself.
  /// The reference runs ahead of the arm by at most this step of any joint [rad or m]; > 0. Within it the
  /// reference is the goal itself.
  double reach{0.25};
  /// Motions that the image shows by less than this follow the model's way: an image that is off by 5 px
  /// for its calibration against a model that is off by 0.1 rad [px/rad]; >= 0. Holds on the way and in
  /// views that certify nothing; at the goal, in a view that does, the image decides.
  double trust{50.0};
};

/// Where the reference is in this period.
struct PathReference {
  double share{1.0};  ///< Of the way to the goal that it is ahead; 1: it is the goal.
  JointVector step;   ///< Joints from here to it [rad or m].
  Eigen::Isometry3d X_WE{Eigen::Isometry3d::Identity()};  ///< End effector there; of share < 1.
};

/// The reference ahead of q on the straight way to q_goal. Real-time safe.
///
/// @param gain  λ [1/s]: q̇ = λ step stays within 70 % of the joints' speeds, in its direction.
/// @pre sizes agree.
[[nodiscard]] PathReference ReferenceAhead(const ReferencePathOptions& options, const ArmModel& arm,
                                           const JointVector& q, const JointVector& q_goal,
                                           double gain) noexcept;

}  // namespace vantage
