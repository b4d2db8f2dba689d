#include "vantage/plan/arm_motion.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "vantage/math/error.h"
#include "vantage/math/spatial.h"

namespace vantage {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

[[noreturn]] void Refuse(const std::string& key, const std::string& reason) {
  throw ConfigError("", "motion" + key, reason);
}

void CheckClock(std::size_t waypoints, double duration, int count) {
  if (waypoints == 0) Refuse("", "needs a waypoint");
  if (!(duration > 0.0) || !std::isfinite(duration)) {
    Refuse(".duration", "must be > 0 s, is " + std::to_string(duration));
  }
  if (count < (waypoints == 1 ? 1 : 2)) {
    Refuse(".samples", "must be >= 2, are " + std::to_string(count));
  }
}

// Where a sample lies: between waypoints line and line + 1.
struct Place {
  std::size_t line;
  double share;
};

// Places of `count` samples, evenly along lines of the given lengths.
std::vector<Place> Places(const std::vector<double>& lengths, int count) {
  double total = 0.0;
  for (const double length : lengths) total += length;
  std::vector<Place> places;
  for (int i = 0; i < count; ++i) {
    double at = count == 1 ? 0.0 : total * i / (count - 1);
    std::size_t line = 0;
    while (line + 1 < lengths.size() && at > lengths[line]) at -= lengths[line++];
    const double share = lengths[line] > 0.0 ? std::min(1.0, at / lengths[line]) : 0.0;
    places.push_back({line, i + 1 == count && count > 1 ? 1.0 : share});
  }
  return places;
}

void SetClock(double duration, ArmMotion* motion) {
  const int count = motion->size();
  const double step = count > 1 ? duration / (count - 1) : duration;
  for (int i = 0; i < count; ++i) {
    motion->time.push_back(count > 1 ? step * i : 0.0);
    motion->weight.push_back(count > 1 && (i == 0 || i + 1 == count) ? 0.5 * step : step);
  }
}

}  // namespace

ArmMotion MoveThroughJoints(const ViewModel& view, const std::vector<JointVector>& waypoints,
                            double duration, int count) {
  if (waypoints.size() == 1) count = 1;
  CheckClock(waypoints.size(), duration, count);
  std::vector<double> lengths;
  for (std::size_t i = 0; i < waypoints.size(); ++i) {
    const std::string key = ".path[" + std::to_string(i) + "]";
    if (waypoints[i].size() != view.arm.size()) {
      Refuse(key, "must have " + std::to_string(view.arm.size()) + " joints, has " +
                      std::to_string(waypoints[i].size()));
    }
    if (!WithinLimits(view.arm, waypoints[i])) Refuse(key, "leaves the arm's joint limits");
    if (i > 0) lengths.push_back((waypoints[i] - waypoints[i - 1]).cwiseAbs().maxCoeff());
  }
  if (lengths.empty()) lengths.push_back(0.0);
  ArmMotion motion;
  for (const Place& place : Places(lengths, count)) {
    const JointVector& from = waypoints[place.line];
    const JointVector& to = waypoints[std::min(place.line + 1, waypoints.size() - 1)];
    motion.samples.push_back(SampleArm(view, from + place.share * (to - from)));
  }
  SetClock(duration, &motion);
  return motion;
}

ArmMotion MoveThroughPoses(const ViewModel& view, const std::vector<Isometry3d>& poses,
                           PathFrame frame, const JointVector& q_near, double duration, int count) {
  constexpr double kReached = 1e-6;  // [m]
  constexpr double kLever = 0.1;     // a radian weighs as much as a decimetre
  if (poses.size() == 1) count = 1;
  CheckClock(poses.size(), duration, count);
  if (q_near.size() != view.arm.size()) {
    Refuse(".start", "must have " + std::to_string(view.arm.size()) + " joints");
  }
  std::vector<double> lengths;
  for (std::size_t i = 1; i < poses.size(); ++i) {
    lengths.push_back((poses[i].translation() - poses[i - 1].translation()).norm());
  }
  if (std::all_of(lengths.begin(), lengths.end(), [](double d) { return d == 0.0; })) {
    for (std::size_t i = 1; i < poses.size(); ++i) {
      lengths[i - 1] = AngleBetween(poses[i - 1].linear(), poses[i].linear());
    }
  }
  if (lengths.empty()) lengths.push_back(0.0);
  std::vector<Vector3d> p_EP{Vector3d::Zero()};
  if (frame == PathFrame::kPose) {
    p_EP = {kLever * Vector3d::UnitX(), kLever * Vector3d::UnitY(), kLever * Vector3d::UnitZ()};
  }
  ArmMotion motion;
  JointVector q = q_near;
  for (const Place& place : Places(lengths, count)) {
    const Isometry3d& from = poses[place.line];
    const Isometry3d& to = poses[std::min(place.line + 1, poses.size() - 1)];
    Isometry3d X_WE;
    X_WE = Eigen::Quaterniond(from.linear())
               .slerp(place.share, Eigen::Quaterniond(to.linear()))
               .toRotationMatrix();
    X_WE.translation() = from.translation() + place.share * (to.translation() - from.translation());
    std::vector<Vector3d> p_WP;
    for (const Vector3d& p : p_EP) p_WP.push_back(X_WE * p);
    const PointGoalSolution solution = SolveForPoints(view.arm, p_EP, p_WP, q, 1e-10);
    if (!(solution.rms_error < kReached)) {
      const Vector3d p = X_WE.translation();
      Refuse(".path", "sample " + std::to_string(motion.size() + 1) + " of " +
                          std::to_string(count) + ", at (" + std::to_string(p.x()) + ", " +
                          std::to_string(p.y()) + ", " + std::to_string(p.z()) +
                          ") m, is out of the arm's reach by " +
                          std::to_string(1e3 * solution.rms_error) + " mm");
    }
    q = solution.q;
    motion.samples.push_back(SampleArm(view, q));
  }
  SetClock(duration, &motion);
  return motion;
}

}  // namespace vantage
