#include "vantage/math/spatial.h"

#include <cmath>

namespace vantage {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

// V of exp(ρ, θ) = (R, V ρ): V = I + b [θ] + c [θ]², with b = (1 - cos θ)/θ², c = (θ - sin θ)/θ³.
Matrix3d LeftJacobian(const Vector3d& theta) noexcept {
  const double t2 = theta.squaredNorm();
  const double t = std::sqrt(t2);
  const double half = std::sin(0.5 * t);
  // The series' next terms are below 1e-16 where they take over.
  const double b = t < 1e-4 ? 0.5 - t2 / 24.0 : 2.0 * half * half / t2;
  const double c =
      t < 1e-2 ? (1.0 / 6.0) - t2 / 120.0 + t2 * t2 / 5040.0 : (t - std::sin(t)) / (t2 * t);
  const Matrix3d S = Skew(theta);
  return Matrix3d::Identity() + b * S + c * S * S;
}

Vector3d RotationVector(const Matrix3d& R) noexcept {
  const Eigen::AngleAxisd turn(R);
  return turn.angle() * turn.axis();
}

Matrix3d Rotation(const Vector3d& theta) noexcept {
  const double angle = theta.norm();
  if (angle < 1e-150) return Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, theta / angle).toRotationMatrix();
}

}  // namespace

Matrix3d Skew(const Vector3d& a) noexcept {
  Matrix3d S;
  // clang-format off
  S <<    0.0, -a.z(),  a.y(),
        a.z(),    0.0, -a.x(),
       -a.y(),  a.x(),    0.0;
  // clang-format on
  return S;
}

Matrix6d AdjointMap(const Isometry3d& X_AB) noexcept {
  Matrix6d Ad;
  Ad.topLeftCorner<3, 3>() = X_AB.linear();
  Ad.topRightCorner<3, 3>() = Skew(X_AB.translation()) * X_AB.linear();
  Ad.bottomLeftCorner<3, 3>().setZero();
  Ad.bottomRightCorner<3, 3>() = X_AB.linear();
  return Ad;
}

Isometry3d Advance(const Isometry3d& X_WA, const Twist& step_A) noexcept {
  const Vector3d theta = step_A.tail<3>();
  Isometry3d X_WB = X_WA;
  X_WB.translation() += X_WA.linear() * (LeftJacobian(theta) * step_A.head<3>());
  X_WB.linear() = X_WA.linear() * Rotation(theta);
  return X_WB;
}

Twist Displacement(const Isometry3d& X_WA, const Isometry3d& X_WB) noexcept {
  const Isometry3d X_AB = X_WA.inverse() * X_WB;
  const Vector3d theta = RotationVector(X_AB.linear());
  Twist step;
  step.head<3>() = LeftJacobian(theta).inverse() * X_AB.translation();
  step.tail<3>() = theta;
  return step;
}

Isometry3d PoseBetween(const Isometry3d& X_WA, const Isometry3d& X_WB, double fraction) noexcept {
  return Advance(X_WA, fraction * Displacement(X_WA, X_WB));
}

double AngleBetween(const Matrix3d& R_WA, const Matrix3d& R_WB) noexcept {
  return Eigen::AngleAxisd(R_WA.transpose() * R_WB).angle();
}

bool IsPose(const Isometry3d& X) noexcept {
  if (!X.matrix().allFinite()) return false;
  const Matrix3d R = X.linear();
  return (R * R.transpose() - Matrix3d::Identity()).norm() < 1e-6 && R.determinant() > 0.0;
}

}  // namespace vantage
