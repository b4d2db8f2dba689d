#pragma once

#include <Eigen/Core>

#include "vantage/math/capacity.h"

/// @file
/// Bounded vectors and matrices of the control period. Their storage is inside the object, so that
/// nothing built from them touches the heap.

namespace vantage {

/// Joint positions [rad or m], velocities [rad/s or m/s] or accelerations; n rows.
using JointVector = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kMaxJoints, 1>;
/// n×n: of pairs of joints, JᵀJ for instance.
using JointMatrix =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMaxJoints, kMaxJoints>;
/// 6×n arm Jacobian, rows ordered as Twist.
using ArmJacobian = Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::ColMajor, 6, kMaxJoints>;
/// 3×n: ∂P/∂q of a point P on the arm [m/rad or m/m].
using PointJacobian = Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::ColMajor, 3, kMaxJoints>;
/// k feature values.
using FeatureVector = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kMaxRows, 1>;
/// k×6: rows of features, columns ordered as Twist. Interaction matrices L and image Jacobians J_v.
using FeatureJacobian = Eigen::Matrix<double, Eigen::Dynamic, 6, Eigen::ColMajor, kMaxRows, 6>;
/// k×n composite Jacobian J_c = J_v J_r.
using TaskJacobian =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMaxRows, kMaxJoints>;
/// Coordinates q_c of a camera rig: metres and radians, in the order of the rig's axes.
using RigVector = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kMaxRigAxes, 1>;

}  // namespace vantage
