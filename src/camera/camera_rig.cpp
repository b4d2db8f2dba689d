#include "vantage/camera/camera_rig.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <sstream>

#include <Eigen/Cholesky>

#include "vantage/math/angles.h"
#include "vantage/math/error.h"

namespace vantage {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::Vector4d;

constexpr double kTurn = 2.0 * kPi;
// What a radian of orientation weighs against a metre where an arm cannot reach both.
constexpr double kMetresPerRadian = 0.1;

Matrix3d RotX(double angle) noexcept {
  return Eigen::AngleAxisd(angle, Vector3d::UnitX()).toRotationMatrix();
}
Matrix3d RotY(double angle) noexcept {
  return Eigen::AngleAxisd(angle, Vector3d::UnitY()).toRotationMatrix();
}
Matrix3d RotZ(double angle) noexcept {
  return Eigen::AngleAxisd(angle, Vector3d::UnitZ()).toRotationMatrix();
}

struct SphericalFrame {
  Vector3d e_r, e_theta, e_phi;
};

// From sine and cosine of theta and phi.
SphericalFrame FrameOf(double st, double ct, double sp, double cp) noexcept {
  return {{st * cp, st * sp, ct}, {ct * cp, ct * sp, -st}, {-sp, cp, 0.0}};
}

SphericalFrame FrameAt(double theta, double phi) noexcept {
  return FrameOf(std::sin(theta), std::cos(theta), std::sin(phi), std::cos(phi));
}

// How a spherical rig holds its camera before that rolls.
Matrix3d BaseOf(RigOrientation orientation, const SphericalFrame& frame) noexcept {
  Matrix3d R_WB;
  if (orientation == RigOrientation::kLookAt) {
    R_WB << frame.e_phi, frame.e_theta, -frame.e_r;
  } else {
    R_WB = Vector3d(1.0, -1.0, -1.0).asDiagonal();
  }
  return R_WB;
}

// R_WB Rz(roll), from the sine and cosine of the roll.
Matrix3d Rolled(const Matrix3d& R_WB, double sine, double cosine) noexcept {
  Matrix3d R_WC;
  R_WC << cosine * R_WB.col(0) + sine * R_WB.col(1), cosine * R_WB.col(1) - sine * R_WB.col(0),
      R_WB.col(2);
  return R_WC;
}

// Axes of a spherical rig.
enum SphericalAxis { kR = 0, kTheta, kPhi, kRoll, kPan, kTilt };

// Angles of the head at q_c; 0 for axes that the rig has not.
struct HeadAngles {
  double pan{0.0}, tilt{0.0}, roll{0.0};
};

HeadAngles AnglesAt(const RigHead& head, const RigVector& q_c) noexcept {
  const auto value = [&](int axis) { return axis < 0 ? 0.0 : q_c(axis); };
  return {value(head.pan), value(head.tilt), value(head.roll)};
}

Matrix3d HeadRotation(const HeadAngles& head) noexcept {
  return RotY(head.pan) * RotX(head.tilt) * RotZ(head.roll);
}

// Motion of everything beyond a joint at q, from where it is at 0.
Isometry3d JointMotion(const RigJoint& joint, double q) noexcept {
  Isometry3d X = Isometry3d::Identity();
  if (joint.prismatic) {
    X.translation() = q * joint.axis_W;
  } else {
    X.linear() = Eigen::AngleAxisd(q, joint.axis_W).toRotationMatrix();
    X.translation() = joint.point_W - X.linear() * joint.point_W;
  }
  return X;
}

Isometry3d ArmPose(const CameraRig& rig, const RigVector& q_c) noexcept {
  Isometry3d X = Isometry3d::Identity();
  for (std::size_t i = 0; i < rig.joints.size(); ++i) {
    X = X * JointMotion(rig.joints[i], q_c(static_cast<Eigen::Index>(i)));
  }
  return X * rig.X_WC_fixed;
}

// Columns of the joints' axes where the arm is at q_c.
void FillArmJacobian(const CameraRig& rig, const RigVector& q_c, RigJacobianMatrix* J) noexcept {
  const Isometry3d X_WC = ArmPose(rig, q_c);
  const Matrix3d R_CW = X_WC.linear().transpose();
  Isometry3d X = Isometry3d::Identity();
  for (std::size_t i = 0; i < rig.joints.size(); ++i) {
    const auto column = static_cast<Eigen::Index>(i);
    const RigJoint& joint = rig.joints[i];
    const Vector3d axis_W = X.linear() * joint.axis_W;
    if (joint.prismatic) {
      J->col(column).head<3>() = R_CW * axis_W;
    } else {
      J->col(column).head<3>() = R_CW * axis_W.cross(X_WC.translation() - X * joint.point_W);
      J->col(column).tail<3>() = R_CW * axis_W;
    }
    X = X * JointMotion(joint, q_c(column));
  }
}

// Where the rig puts the camera before its head turns it: B, the head's base.
Isometry3d BasePose(const CameraRig& rig, const RigVector& q_c) noexcept {
  Isometry3d X_WB = rig.X_WC_fixed;
  switch (rig.kind) {
    case RigKind::kFixed:
    case RigKind::kPanTilt:
      break;
    case RigKind::kSpherical:
      X_WB = SphericalPose(rig.orientation, rig.target_W,
                           Vector4d(q_c(kR), q_c(kTheta), q_c(kPhi), 0.0));
      break;
    case RigKind::kRail:
      X_WB.translation() += q_c(0) * rig.rail_W;
      break;
    case RigKind::kFree:
      X_WB.translation() += q_c.head<3>();
      break;
    case RigKind::kArm:
      X_WB = ArmPose(rig, q_c);
      break;
  }
  return X_WB;
}

bool IsLocked(const RigAxis& axis) noexcept {
  return axis.max_speed == 0.0;
}

// The value an axis takes when `wanted` is asked for: locked axes stay.
double Admit(const RigAxis& axis, double wanted, double now) noexcept {
  return IsLocked(axis) ? now : std::clamp(wanted, axis.lower, axis.upper);
}

// Of the turns of `angle`, the one inside the limits that is nearest to `near`; where none is inside,
// the bound that is fewer radians away on the circle.
double AdmitAngle(const RigAxis& axis, double angle, double near) noexcept {
  if (IsLocked(axis)) return near;
  const double nearest = angle + kTurn * std::round((near - angle) / kTurn);
  const double lowest = angle + kTurn * std::ceil((axis.lower - angle) / kTurn);
  const double highest = angle + kTurn * std::floor((axis.upper - angle) / kTurn);
  if (lowest <= highest) return std::clamp(nearest, lowest, highest);
  return std::abs(std::remainder(angle - axis.lower, kTurn)) <
                 std::abs(std::remainder(angle - axis.upper, kTurn))
             ? axis.lower
             : axis.upper;
}

// theta in its limits whose direction, at azimuth phi, is nearest to the offset p from the target.
double BestTheta(const RigAxis& axis, double now, const Vector3d& p, double phi) noexcept {
  if (IsLocked(axis)) return now;
  const double outward = p.x() * std::cos(phi) + p.y() * std::sin(phi);
  const double best = std::atan2(outward, p.z());
  // The cosine to the best angle falls off to both sides, so one of the bounds is next best.
  if (best >= axis.lower && best <= axis.upper) return best;
  return std::cos(best - axis.lower) > std::cos(best - axis.upper) ? axis.lower : axis.upper;
}

void NearestOnSphere(const CameraRig& rig, const Vector3d& p_WC, RigVector* q_c) noexcept {
  const Vector3d p = p_WC - rig.target_W;
  const double now = (*q_c)(kPhi);
  const double across = std::hypot(p.x(), p.y());
  if (p.norm() < 1e-12) return;  // No direction is nearer than another.
  const RigAxis& phi_axis = rig.axes[kPhi];
  const double phi = across < 1e-12 * p.norm() ? now : std::atan2(p.y(), p.x());
  const double phi_admitted = AdmitAngle(phi_axis, phi, now);
  (*q_c)(kPhi) = phi_admitted;
  (*q_c)(kTheta) = BestTheta(rig.axes[kTheta], (*q_c)(kTheta), p, phi_admitted);
  const double along = p.dot(FrameAt((*q_c)(kTheta), phi_admitted).e_r);
  (*q_c)(kR) = Admit(rig.axes[kR], along, (*q_c)(kR));
}

// Pan and tilt that point the optical axis along d_B, given in the head's base frame.
void PointAlong(const CameraRig& rig, const RigHead& head, const Vector3d& d_B,
                RigVector* q_c) noexcept {
  if (head.pan < 0 || head.tilt < 0 || d_B.norm() < 1e-12) return;
  const Vector3d d = d_B.normalized();
  // The optical axis is (cos(tilt) sin(pan), -sin(tilt), cos(tilt) cos(pan)).
  const double pan = std::hypot(d.x(), d.z()) < 1e-12 ? (*q_c)(head.pan) : std::atan2(d.x(), d.z());
  (*q_c)(head.pan) = AdmitAngle(rig.axes[head.pan], pan, (*q_c)(head.pan));
  // With the pan that the limits left, the tilt that is nearest to d.
  const double p = (*q_c)(head.pan);
  const double ahead = d.x() * std::sin(p) + d.z() * std::cos(p);
  const double tilt = std::atan2(-d.y(), ahead);
  (*q_c)(head.tilt) = AdmitAngle(rig.axes[head.tilt], tilt, (*q_c)(head.tilt));
}

void NearestHead(const CameraRig& rig, const Matrix3d& R_WC, RigVector* q_c) noexcept {
  const RigHead head = HeadOf(rig);
  const Matrix3d R_BC = BasePose(rig, *q_c).linear().transpose() * R_WC;
  PointAlong(rig, head, R_BC.col(2), q_c);
  if (head.roll < 0) return;
  HeadAngles angles = AnglesAt(head, *q_c);
  angles.roll = 0.0;
  const Matrix3d M = HeadRotation(angles).transpose() * R_BC;
  const double s = M(1, 0) - M(0, 1);
  const double c = M(0, 0) + M(1, 1);
  // Half a turn away about an axis across, every roll is as near as another.
  const double roll = std::hypot(s, c) < 1e-12 ? (*q_c)(head.roll) : std::atan2(s, c);
  (*q_c)(head.roll) = AdmitAngle(rig.axes[head.roll], roll, (*q_c)(head.roll));
}

// What is left to X_WC, in the camera's axes: distance [m], and turn in decimetres for radians. Minus
// J^T times it is the exact gradient of half its square, however far it is.
Twist WeightedError(const CameraRig& rig, const RigVector& q_c, const Isometry3d& X_WC) noexcept {
  const Isometry3d X_CTarget = RigPose(rig, q_c).inverse() * X_WC;
  const Eigen::AngleAxisd turn(X_CTarget.linear());
  Twist error;
  error << X_CTarget.translation(), kMetresPerRadian * turn.angle() * turn.axis();
  return error;
}

// Levenberg-Marquardt with the axes' limits as bounds.
void NearestOfArm(const CameraRig& rig, const Isometry3d& X_WC, int most_steps,
                  RigVector* q_c) noexcept {
  using Square = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMaxRigAxes,
                               kMaxRigAxes>;
  for (int i = 0; i < rig.size(); ++i) {
    (*q_c)(i) = Admit(rig.axes[i], (*q_c)(i), (*q_c)(i));
  }
  double damping = 1e-4;
  Twist error = WeightedError(rig, *q_c, X_WC);
  for (int step = 0; step < most_steps && error.norm() > 1e-12 && damping < 1e8; ++step) {
    RigJacobianMatrix J = RigJacobian(rig, *q_c);
    J.bottomRows<3>() *= kMetresPerRadian;
    RigVector gradient = J.transpose() * error;
    for (int i = 0; i < rig.size(); ++i) {
      const RigAxis& axis = rig.axes[i];
      const bool outward = ((*q_c)(i) <= axis.lower && gradient(i) < 0.0) ||
                           ((*q_c)(i) >= axis.upper && gradient(i) > 0.0);
      if (!IsLocked(axis) && !outward) continue;
      J.col(i).setZero();
      gradient(i) = 0.0;
    }
    Square H = J.transpose().lazyProduct(J);
    H.diagonal().array() += damping;
    RigVector next = *q_c + RigVector(H.llt().solve(gradient));
    for (int i = 0; i < rig.size(); ++i) next(i) = Admit(rig.axes[i], next(i), (*q_c)(i));
    const Twist left = WeightedError(rig, next, X_WC);
    if (left.squaredNorm() < error.squaredNorm()) {
      *q_c = next;
      // Out of reach the rest shrinks ever more slowly: enough is enough.
      const bool creeping = left.norm() > 1e-6 && left.norm() > (1.0 - 1e-7) * error.norm();
      error = left;
      if (creeping) break;
      damping = std::max(1e-9, 0.2 * damping);
    } else {
      damping *= 8.0;
    }
  }
}

[[noreturn]] void Refuse(const std::string& key, const std::string& reason) {
  throw ConfigError("", key, reason);
}

std::string Text(double value) {
  std::ostringstream text;
  text << value;
  return text.str();
}

std::string Text(const Vector3d& v) {
  return "(" + Text(v.x()) + ", " + Text(v.y()) + ", " + Text(v.z()) + ")";
}

bool HasAxisCount(const CameraRig& rig) noexcept {
  const int count = rig.size();
  switch (rig.kind) {
    case RigKind::kFixed:
      return count == 0;
    case RigKind::kSpherical:
      return count == 4 || count == 6;
    case RigKind::kPanTilt:
      return count == 2;
    case RigKind::kRail:
      return count == 1 || count == 3;
    case RigKind::kFree:
      return count == 6;
    case RigKind::kArm:
      return count > 0 && count <= kMaxRigAxes && rig.joints.size() == rig.axes.size();
  }
  return false;
}

std::string AxisCountText(RigKind kind) {
  switch (kind) {
    case RigKind::kFixed:
      return "a fixed rig has no axes";
    case RigKind::kSpherical:
      return "a spherical rig has the axes R, theta, phi, roll and perhaps pan, tilt";
    case RigKind::kPanTilt:
      return "a pan-tilt rig has the axes pan, tilt";
    case RigKind::kRail:
      return "a rail rig has the axis s and perhaps pan, tilt";
    case RigKind::kFree:
      return "a free rig has the axes x, y, z, pan, tilt, roll";
    case RigKind::kArm:
      return "a rig on an arm has one axis for each joint, 1 to " + std::to_string(kMaxRigAxes);
  }
  return "unknown kind";
}

void ValidateAxis(const RigAxis& axis, const std::string& key) {
  if (!std::isfinite(axis.lower) || !std::isfinite(axis.upper)) {
    Refuse(key + ".limits", "must be finite, are " + Text(axis.lower) + " and " + Text(axis.upper));
  }
  if (axis.lower > axis.upper) {
    Refuse(key + ".limits",
           "lower must not exceed upper, are " + Text(axis.lower) + " and " + Text(axis.upper));
  }
  if (!(axis.max_speed >= 0.0) || !std::isfinite(axis.max_speed)) {
    Refuse(key + ".max_speed", "must be >= 0 (m/s or rad/s), is " + Text(axis.max_speed));
  }
  const double a = axis.max_acceleration;
  if (!std::isfinite(a) || a < 0.0 || (axis.max_speed > 0.0 && a == 0.0)) {
    Refuse(key + ".max_acceleration",
           "must be > 0 (m/s^2 or rad/s^2) on an axis that moves, is " + Text(a));
  }
}

}  // namespace

bool AxisTurns(const CameraRig& rig, int axis) noexcept {
  switch (rig.kind) {
    case RigKind::kSpherical:
    case RigKind::kRail:
      return axis > 0;
    case RigKind::kFree:
      return axis > 2;
    case RigKind::kArm:
      return !rig.joints[axis].prismatic;
    case RigKind::kFixed:
    case RigKind::kPanTilt:
      break;
  }
  return true;
}

Isometry3d SphericalPose(RigOrientation orientation, const Vector3d& target_W,
                         const Vector4d& q_c) noexcept {
  const SphericalFrame frame = FrameAt(q_c(kTheta), q_c(kPhi));
  Isometry3d X_WC = Isometry3d::Identity();
  X_WC.translation() = target_W + q_c(kR) * frame.e_r;
  const double roll = q_c(kRoll);
  X_WC.linear() = Rolled(BaseOf(orientation, frame), std::sin(roll), std::cos(roll));
  return X_WC;
}

RigHead HeadOf(const CameraRig& rig) noexcept {
  switch (rig.kind) {
    case RigKind::kFixed:
      return {};
    case RigKind::kSpherical:
      return rig.size() == 6 ? RigHead{kPan, kTilt, kRoll} : RigHead{-1, -1, kRoll};
    case RigKind::kPanTilt:
      return {0, 1, -1};
    case RigKind::kRail:
      return rig.size() == 3 ? RigHead{1, 2, -1} : RigHead{};
    case RigKind::kFree:
      return {3, 4, 5};
    case RigKind::kArm:
      return {};
  }
  return {};
}

Isometry3d RigPose(const CameraRig& rig, const RigVector& q_c) noexcept {
  assert(q_c.size() == rig.size());
  if (rig.kind == RigKind::kSpherical && rig.size() == 4) {
    return SphericalPose(rig.orientation, rig.target_W, q_c.head<4>());
  }
  Isometry3d X_WC = BasePose(rig, q_c);
  X_WC.linear() = X_WC.linear() * HeadRotation(AnglesAt(HeadOf(rig), q_c));
  return X_WC;
}

void RigPoses(const CameraRig& rig, const std::vector<std::vector<double>>& values,
              const std::vector<int>& pick, std::vector<Isometry3d>* X_WC) {
  assert(static_cast<int>(values.size()) == rig.size() && pick.size() % values.size() == 0);
  X_WC->resize(pick.size() / values.size(), Isometry3d::Identity());
  const int* at = pick.data();
  if (rig.kind == RigKind::kSpherical && rig.size() == 4) {
    struct Turn {
      double sine, cosine;
    };
    const auto turns = [](const std::vector<double>& angles) {
      std::vector<Turn> of_angles(angles.size());
      for (std::size_t i = 0; i < angles.size(); ++i) {
        // Values that do not vary come as copies.
        const bool again = i > 0 && angles[i] == angles[i - 1];
        of_angles[i] = again ? of_angles[i - 1] : Turn{std::sin(angles[i]), std::cos(angles[i])};
      }
      return of_angles;
    };
    const std::vector<Turn> thetas = turns(values[kTheta]), phis = turns(values[kPhi]),
                            rolls = turns(values[kRoll]);
    for (Isometry3d& X : *X_WC) {
      const Turn& theta = thetas[at[kTheta]];
      const Turn& phi = phis[at[kPhi]];
      const Turn& roll = rolls[at[kRoll]];
      const SphericalFrame frame = FrameOf(theta.sine, theta.cosine, phi.sine, phi.cosine);
      X.linear() = Rolled(BaseOf(rig.orientation, frame), roll.sine, roll.cosine);
      X.translation() = rig.target_W + values[kR][at[kR]] * frame.e_r;
      at += rig.size();
    }
    return;
  }
  RigVector q_c(rig.size());
  for (Isometry3d& X : *X_WC) {
    for (int axis = 0; axis < rig.size(); ++axis) q_c(axis) = values[axis][at[axis]];
    X = RigPose(rig, q_c);
    at += rig.size();
  }
}

RigJacobianMatrix RigJacobian(const CameraRig& rig, const RigVector& q_c) noexcept {
  assert(q_c.size() == rig.size());
  RigJacobianMatrix J = RigJacobianMatrix::Zero(6, rig.size());
  const RigHead head = HeadOf(rig);
  const HeadAngles angles = AnglesAt(head, q_c);
  const Matrix3d R_BC = HeadRotation(angles);
  const Matrix3d R_CW = (BasePose(rig, q_c).linear() * R_BC).transpose();
  switch (rig.kind) {
    case RigKind::kFixed:
    case RigKind::kPanTilt:
      break;
    case RigKind::kSpherical: {
      const SphericalFrame frame = FrameAt(q_c(kTheta), q_c(kPhi));
      J.col(kR).head<3>() = R_CW * frame.e_r;
      J.col(kTheta).head<3>() = q_c(kR) * (R_CW * frame.e_theta);
      J.col(kPhi).head<3>() = q_c(kR) * std::sin(q_c(kTheta)) * (R_CW * frame.e_phi);
      if (rig.orientation == RigOrientation::kLookAt) {
        J.col(kTheta).tail<3>() = R_CW * frame.e_phi;  // theta tips e_r towards e_theta.
        J.col(kPhi).tail<3>() = R_CW.col(2);
      }
      break;
    }
    case RigKind::kRail:
      J.col(0).head<3>() = R_CW * rig.rail_W;
      break;
    case RigKind::kFree:
      J.topLeftCorner<3, 3>() = R_CW;
      break;
    case RigKind::kArm:
      FillArmJacobian(rig, q_c, &J);
      break;
  }
  // The axes the head turns about, in C: Ry(pan) Rx(tilt) Rz(roll) read from the right.
  if (head.pan >= 0) J.col(head.pan).tail<3>() = R_BC.row(1).transpose();
  if (head.tilt >= 0) J.col(head.tilt).tail<3>() = RotZ(angles.roll).row(0).transpose();
  if (head.roll >= 0) J.col(head.roll).tail<3>() = Vector3d::UnitZ();
  return J;
}

RigVector NearestRigCoordinates(const CameraRig& rig, const Isometry3d& X_WC,
                                const RigVector& q_c_near, int arm_steps) noexcept {
  assert(q_c_near.size() == rig.size());
  RigVector q_c = q_c_near;
  const Vector3d offset = X_WC.translation() - rig.X_WC_fixed.translation();
  switch (rig.kind) {
    case RigKind::kFixed:
    case RigKind::kPanTilt:
      break;
    case RigKind::kSpherical:
      NearestOnSphere(rig, X_WC.translation(), &q_c);
      break;
    case RigKind::kRail:
      q_c(0) = Admit(rig.axes[0], offset.dot(rig.rail_W), q_c(0));
      break;
    case RigKind::kFree:
      for (int i = 0; i < 3; ++i) q_c(i) = Admit(rig.axes[i], offset(i), q_c(i));
      break;
    case RigKind::kArm:
      NearestOfArm(rig, X_WC, arm_steps, &q_c);
      return q_c;
  }
  NearestHead(rig, X_WC.linear(), &q_c);
  return q_c;
}

RigVector ClampToLimits(const CameraRig& rig, const RigVector& q_c) noexcept {
  RigVector clamped = q_c;
  for (int i = 0; i < rig.size(); ++i) {
    clamped(i) = std::clamp(q_c(i), rig.axes[i].lower, rig.axes[i].upper);
  }
  return clamped;
}

RigVector AimAt(const CameraRig& rig, const RigVector& q_c, const Vector3d& p_W) noexcept {
  RigVector aimed = q_c;
  PointAlong(rig, HeadOf(rig), BasePose(rig, q_c).inverse() * p_W, &aimed);
  return aimed;
}

void Validate(const CameraRig& rig) {
  if (!HasAxisCount(rig)) {
    std::string found = std::to_string(rig.size());
    if (rig.kind == RigKind::kArm) found += " for " + std::to_string(rig.joints.size()) + " joints";
    Refuse("camera_rig.axes", AxisCountText(rig.kind) + ", found " + found);
  }
  for (const RigAxis& axis : rig.axes) ValidateAxis(axis, "camera_rig.axes." + axis.name);
  if (!(rig.max_linear_speed > 0.0) || !std::isfinite(rig.max_linear_speed)) {
    Refuse("camera_rig.max_linear_speed", "must be > 0 m/s, is " + Text(rig.max_linear_speed));
  }
  if (!rig.target_W.allFinite()) {
    Refuse("camera_rig.target", "must be finite (m), is " + Text(rig.target_W));
  }
  if (rig.kind == RigKind::kSpherical) {
    const RigAxis& R = rig.axes[kR];
    if (!(R.lower > 0.0)) {
      Refuse("camera_rig.axes." + R.name + ".limits", "lower must be > 0 m, is " + Text(R.lower));
    }
    const RigAxis& theta = rig.axes[kTheta];
    if (theta.lower < 0.0 || theta.upper > kPi) {
      Refuse("camera_rig.axes." + theta.name + ".limits",
             "must be in [0, pi] rad, are " + Text(theta.lower) + " and " + Text(theta.upper));
    }
    return;
  }
  if (!IsPose(rig.X_WC_fixed)) Refuse("camera_rig.pose", "is no rigid pose");
  if (rig.kind == RigKind::kRail && !(std::abs(rig.rail_W.norm() - 1.0) < 1e-6)) {
    Refuse("camera_rig.rail", "must be a unit vector, has length " + Text(rig.rail_W.norm()));
  }
  for (std::size_t i = 0; i < rig.joints.size(); ++i) {
    const RigJoint& joint = rig.joints[i];
    const std::string key = "camera_rig.joints[" + std::to_string(i) + "]";
    if (!(std::abs(joint.axis_W.norm() - 1.0) < 1e-6)) {
      Refuse(key + ".axis", "must be a unit vector, has length " + Text(joint.axis_W.norm()));
    }
    if (!joint.point_W.allFinite()) {
      Refuse(key + ".point", "must be finite (m), is " + Text(joint.point_W));
    }
  }
}

}  // namespace vantage
