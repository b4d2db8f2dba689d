#include "view_candidates.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "vantage/math/angles.h"

namespace vantage {
namespace {

using Eigen::Vector3d;

constexpr double kTurn = 2.0 * kPi;
constexpr double kGolden = 0.6180339887498949;   // 1 / golden ratio
constexpr double kPlastic = 0.7548776662466927;  // 1 / plastic number: even beside the golden one
// Powers of 1 / 1.2207..., the root of x^4 = x + 1: evenly spread in three dimensions.
constexpr std::array<double, 3> kSpread3{0.8191725133961645, 0.6710436067037893,
                                         0.5497004779019703};

double Fraction(double x) noexcept {
  return x - std::floor(x);
}

bool IsFree(const RigAxis& axis) noexcept {
  return axis.max_speed > 0.0 && axis.upper > axis.lower;
}

double At(const RigAxis& axis, double share) noexcept {
  return axis.lower + share * (axis.upper - axis.lower);
}

// The turn of `angle` inside the limits that is nearest to `near`.
double NearestTurn(const RigAxis& axis, double angle, double near) noexcept {
  double best = angle;
  for (int i = -2; i <= 2; ++i) {
    const double turn = angle + i * kTurn;
    const bool inside = turn >= axis.lower && turn <= axis.upper;
    if (inside && std::abs(turn - near) < std::abs(best - near)) best = turn;
  }
  return best;
}

RigVector OnSphere(const CameraRig& rig, const RigVector& q_c, int i, int count) {
  RigVector candidate = q_c;
  const RigAxis& R = rig.axes[0];
  const RigAxis& theta = rig.axes[1];
  const RigAxis& phi = rig.axes[2];
  if (IsFree(R)) candidate(0) = At(R, Fraction(0.5 + kPlastic * i));
  if (IsFree(theta)) {
    // Evenly in cos(theta), so evenly over the sphere's surface.
    const double share = (i + 0.5) / count;
    candidate(1) = std::acos((1.0 - share) * std::cos(theta.lower) + share * std::cos(theta.upper));
  }
  if (IsFree(phi)) {
    const double span = std::min(kTurn, phi.upper - phi.lower);
    candidate(2) = NearestTurn(phi, phi.lower + span * Fraction(kGolden * i), q_c(2));
  }
  return candidate;
}

// How far an arm reaches from its first joint at most [m].
double ReachOf(const CameraRig& rig) {
  double reach = 0.0;
  Vector3d last = rig.X_WC_fixed.translation();
  for (std::size_t i = rig.joints.size(); i-- > 0;) {
    if (rig.joints[i].prismatic) {
      reach += std::max(std::abs(rig.axes[i].lower), std::abs(rig.axes[i].upper));
    } else {
      reach += (last - rig.joints[i].point_W).norm();
      last = rig.joints[i].point_W;
    }
  }
  return reach;
}

// Views from a ball round the aim, as far as the arm reaches them. Each is turned from the present one
// by the least angle, every other one rolled besides.
void AddByArm(const CameraRig& rig, const RigVector& q_c, const Vector3d& aim_W, int count,
              std::vector<RigVector>* candidates) {
  constexpr double kNearest = 0.35, kFarthest = 1.6;  // [m]
  constexpr int kArmSteps = 15;                       // as exact as a first view needs
  const Eigen::Isometry3d X_WNow = RigPose(rig, q_c);
  const Vector3d shoulder_W =
      rig.joints[0].prismatic ? rig.X_WC_fixed.translation() : rig.joints[0].point_W;
  const double reach = ReachOf(rig);
  const std::size_t first = candidates->size() - 1;  // q_c itself is the first
  std::vector<Vector3d> places{X_WNow.translation()};
  for (int i = 0; i < count; ++i) {
    const double z = 1.0 - 2.0 * (i + 0.5) / count;
    const double phi = kTurn * Fraction(kGolden * i);
    const double across = std::sqrt(1.0 - z * z);
    const Vector3d outward(across * std::cos(phi), across * std::sin(phi), z);
    Eigen::Isometry3d X_WC;
    X_WC.translation() =
        aim_W + (kNearest + (kFarthest - kNearest) * Fraction(0.5 + kPlastic * i)) * outward;
    if ((X_WC.translation() - shoulder_W).norm() > reach) continue;
    const Eigen::Quaterniond turn =
        Eigen::Quaterniond::FromTwoVectors(X_WNow.linear().col(2), -outward);
    const double roll = i % 2 == 0 ? 0.0 : kPi * (Fraction(kPlastic * i) - 0.5);
    X_WC.linear() = turn.toRotationMatrix() * X_WNow.linear() *
                    Eigen::AngleAxisd(roll, Vector3d::UnitZ()).toRotationMatrix();
    // The search starts from the nearest place that was found before.
    std::size_t nearest = 0;
    for (std::size_t k = 1; k < places.size(); ++k) {
      const double distance = (places[k] - X_WC.translation()).norm();
      if (distance < (places[nearest] - X_WC.translation()).norm()) nearest = k;
    }
    candidates->push_back(
        NearestRigCoordinates(rig, X_WC, (*candidates)[first + nearest], kArmSteps));
    places.push_back(RigPose(rig, candidates->back()).translation());
  }
}

// Keeps q inside the limits, and locked axes where they stand.
RigVector Admit(const CameraRig& rig, const RigVector& q, const RigVector& q_c) {
  RigVector admitted = ClampToLimits(rig, q);
  for (int i = 0; i < rig.size(); ++i) {
    if (rig.axes[i].max_speed == 0.0) admitted(i) = q_c(i);
  }
  return admitted;
}

// A curve whose middle lies `bulge` away from the straight line's. On the way its head turns from where
// it looks at the start to the aim, and from there to where it looks at the end.
RigPath Bent(const CameraRig& rig, const RigVector& from, const RigVector& to,
             const RigVector& bulge, const Vector3d& aim_W) {
  const RigVector middle = 0.5 * (from + to);
  RigPath path = RigPath::Parabola(from, Admit(rig, middle + 2.0 * bulge, middle), to);
  const RigHead head = HeadOf(rig);
  if (head.pan < 0) return path;
  for (int i = 1; i + 1 < RigPath::kPoints; ++i) {
    const RigVector aimed = AimAt(rig, path.At(RigPath::Station(i)), aim_W);
    for (const int axis : {head.pan, head.tilt}) path.point(i)(axis) = aimed(axis);
  }
  return path;
}

// How far a neighbour lies along an axis [m or rad].
double StepOf(const CameraRig& rig, int axis, double scale) noexcept {
  return scale * std::min(0.4, 0.1 * (rig.axes[axis].upper - rig.axes[axis].lower));
}

}  // namespace

bool CanMove(const CameraRig& rig) noexcept {
  return std::any_of(rig.axes.begin(), rig.axes.end(), IsFree);
}

std::vector<RigVector> CandidatePositions(const CameraRig& rig, const RigVector& q_c,
                                          const Vector3d& aim_W, int count) {
  std::vector<RigVector> candidates;
  if (!CanMove(rig)) return candidates;
  candidates.reserve(static_cast<std::size_t>(count) + 1);
  candidates.push_back(AimAt(rig, q_c, aim_W));
  if (rig.kind == RigKind::kArm) {
    AddByArm(rig, q_c, aim_W, count, &candidates);
    return candidates;
  }
  for (int i = 0; i < count; ++i) {
    RigVector candidate = q_c;
    switch (rig.kind) {
      case RigKind::kFixed:
      case RigKind::kPanTilt:
      case RigKind::kArm:
        return candidates;  // One position, and it is in.
      case RigKind::kSpherical:
        candidate = OnSphere(rig, q_c, i, count);
        break;
      case RigKind::kRail:
        if (!IsFree(rig.axes[0])) return candidates;
        candidate(0) = At(rig.axes[0], (i + 0.5) / count);
        break;
      case RigKind::kFree:
        for (int axis = 0; axis < 3; ++axis) {
          if (!IsFree(rig.axes[axis])) continue;
          candidate(axis) = At(rig.axes[axis], Fraction(0.5 + kSpread3[axis] * i));
        }
        break;
    }
    candidates.push_back(AimAt(rig, candidate, aim_W));
  }
  return candidates;
}

std::vector<RigVector> Neighbours(const CameraRig& rig, const RigVector& q_c, const Vector3d& aim_W,
                                  double scale) {
  std::vector<RigVector> neighbours;
  const RigHead head = HeadOf(rig);
  for (int axis = 0; axis < rig.size(); ++axis) {
    if (!IsFree(rig.axes[axis])) continue;
    for (const double sign : {-1.0, 1.0}) {
      RigVector neighbour = q_c;
      neighbour(axis) += sign * StepOf(rig, axis, scale);
      const bool turns = axis == head.pan || axis == head.tilt || axis == head.roll;
      neighbour = ClampToLimits(rig, neighbour);
      neighbours.push_back(turns ? neighbour : AimAt(rig, neighbour, aim_W));
    }
  }
  return neighbours;
}

std::vector<double> OtherRolls(const CameraRig& rig, const RigVector& q_c) {
  std::vector<double> rolls;
  const int axis = HeadOf(rig).roll;
  if (axis < 0 || !IsFree(rig.axes[axis])) return rolls;
  const RigAxis& bounds = rig.axes[axis];
  for (int eighth = 1; eighth < 4; ++eighth) {
    // Half a turn shows the same picture upside down, with the same measures: of all the rolls that
    // differ by half turns the nearest will do.
    const double wanted = q_c(axis) + eighth * kTurn / 8.0;
    double best = bounds.upper + kTurn;
    for (int half = -4; half <= 4; ++half) {
      const double roll = wanted + half * 0.5 * kTurn;
      const bool inside = roll >= bounds.lower && roll <= bounds.upper;
      if (inside && std::abs(roll - q_c(axis)) < std::abs(best - q_c(axis))) best = roll;
    }
    if (best <= bounds.upper) rolls.push_back(best);
  }
  return rolls;
}

std::vector<RigPath> PathsBetween(const CameraRig& rig, const RigVector& from, const RigVector& to,
                                  const Vector3d& aim_W) {
  const RigVector none = RigVector::Zero(rig.size());
  std::vector<RigPath> paths{Bent(rig, from, to, none, aim_W)};
  const auto add = [&](int axis, double bulge, const RigVector& end) {
    if (!IsFree(rig.axes[axis])) return;
    RigVector d = none;
    d(axis) = bulge;
    paths.push_back(Bent(rig, from, end, d, aim_W));
  };
  switch (rig.kind) {
    case RigKind::kFixed:
    case RigKind::kPanTilt:
    case RigKind::kRail:
      break;
    case RigKind::kSpherical: {
      add(1, -0.5, to);                      // over the top
      add(1, 0.5, to);                       // under
      add(0, 0.25 * (from(0) + to(0)), to);  // wide
      const RigAxis& phi = rig.axes[2];
      for (const double turn : {-kTurn, kTurn}) {
        RigVector round = to;
        round(2) += turn;
        if (IsFree(phi) && round(2) >= phi.lower && round(2) <= phi.upper) {
          paths.push_back(Bent(rig, from, round, none, aim_W));
        }
      }
      break;
    }
    case RigKind::kFree:
    case RigKind::kArm:
      for (int axis = 0; axis < std::min(3, rig.size()); ++axis) {
        add(axis, 0.4, to);
        add(axis, -0.4, to);
      }
      break;
  }
  return paths;
}

}  // namespace vantage
