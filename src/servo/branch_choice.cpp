#include "vantage/servo/branch_choice.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <tuple>

#include <Eigen/LU>

#include "vantage/robot/kinematics.h"

namespace vantage {
namespace {

using Eigen::Vector3d;

// Random starts of the search, besides the joints now.
constexpr int kStarts = 10;
// Solutions nearer to one another than this are one branch [rad or m].
constexpr double kSameBranch = 0.1;
// A goal further from what the arm can reach than this is no prediction [m].
constexpr double kReachable = 0.05;
// A joint nearer to its limit than this is at it [rad or m].
constexpr double kLimitRoom = 0.04;
// Configurations of a way at which it is looked at closely.
constexpr int kFineSamples = 33;
// A way passes a singularity where w of the markers' motion falls below this share of what it is at
// either end.
constexpr double kSingularShare = 0.1;

bool Among(const std::vector<JointVector>& known, const JointVector& q) {
  return std::any_of(known.begin(), known.end(), [&](const JointVector& other) {
    return (other - q).lpNorm<Eigen::Infinity>() < kSameBranch;
  });
}

double TimeTo(const ArmModel& arm, const JointVector& q, const JointVector& q_goal) {
  double time = 0.0;
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    const double speed = arm.limits()[static_cast<std::size_t>(i)].velocity;
    time = std::max(time, std::abs(q_goal(i) - q(i)) / speed);
  }
  return time;
}

bool AtLimit(const ArmModel& arm, const JointVector& q) {
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    const JointLimits& limit = arm.limits()[static_cast<std::size_t>(i)];
    if (std::min(q(i) - limit.lower, limit.upper - q(i)) < kLimitRoom) return true;
  }
  return false;
}

// How far the joints move the markers, as a volume: w of the markers' stacked Jacobians.
double LogMotionVolume(const ArmSample& sample) {
  const Eigen::Index n = sample.q.size();
  JointMatrix G = JointMatrix::Zero(n, n);
  for (const PointJacobian& J : sample.J_marker_W) G += J.transpose().lazyProduct(J);
  const double det = G.determinant();
  return det > 0.0 ? 0.5 * std::log(det) : -std::numeric_limits<double>::infinity();
}

bool PassesSingularity(const std::vector<ArmSample>& motion) {
  // Where the joints are more than the motions, there is always one that moves nothing.
  const auto rows = 3 * static_cast<Eigen::Index>(motion.front().J_marker_W.size());
  if (std::min<Eigen::Index>(rows, kTaskDimension) < motion.front().q.size()) return false;
  const double ends = std::min(LogMotionVolume(motion.front()), LogMotionVolume(motion.back()));
  return std::any_of(motion.begin(), motion.end(), [&](const ArmSample& sample) {
    return LogMotionVolume(sample) < ends + std::log(kSingularShare);
  });
}

// Whether there is less against `a` than against `b`. One that is out of reach loses.
bool Better(const Branch& a, const Branch& b) {
  const auto against = [](const Branch& branch) {
    return std::tuple(branch.q.size() == 0, branch.at_limit, branch.touches_goal,
                      branch.unwatchable, branch.passes_singularity, branch.time);
  };
  return against(a) < against(b);
}

// What the way to the branch has against it. Dearest last, and no further than it can still be better than
// `best`: what is not judged yet counts as good.
void JudgeWay(const ViewModel& view, const CameraRig& rig, const PlannerOptions& planner,
              const BranchRequest& request, const Branch& best, Branch* branch) {
  branch->time = TimeTo(view.arm, request.q, branch->q);
  branch->at_limit = AtLimit(view.arm, branch->q);
  if (!Better(*branch, best)) return;
  const auto fine = SampleMotion(view, request.q, branch->q, kFineSamples);
  branch->touches_goal = std::any_of(fine.begin(), fine.end(), [&](const ArmSample& sample) {
    return PlatesTouch(sample.markers, request.goal_markers);
  });
  branch->passes_singularity = PassesSingularity(fine);
  if (!Better(*branch, best)) return;
  const auto motion = SampleMotion(view, request.q, branch->q, planner.path_samples);
  branch->unwatchable = !CanWatch(view, rig, planner, motion, request.goal_markers, request.q_c);
}

}  // namespace

bool PlatesTouch(const std::vector<PlacedMarker>& arm_markers,
                 const std::vector<PlacedMarker>& goal_markers) noexcept {
  return std::any_of(goal_markers.begin(), goal_markers.end(), [&](const PlacedMarker& goal) {
    return std::any_of(arm_markers.begin(), arm_markers.end(), [&](const PlacedMarker& marker) {
      return (marker.p_W - goal.p_W).norm() < kPlateRadii * (marker.radius + goal.radius);
    });
  });
}

Branch ChooseBranch(const ViewModel& view, const CameraRig& rig, const PlannerOptions& planner,
                    const BranchRequest& request, double solved) {
  const ArmModel& arm = view.arm;
  const auto first = SolveForPoints(arm, request.p_EM, request.p_WG, request.q, solved);
  if (first.rms_error >= kReachable) return Branch();
  std::vector<JointVector> found;
  if (!Among(request.failed, first.q)) found.push_back(first.q);
  std::mt19937_64 random(1);
  for (int start = 0; start < kStarts; ++start) {
    JointVector from = request.q;
    for (Eigen::Index i = 0; i < from.size(); ++i) {
      const JointLimits& limit = arm.limits()[static_cast<std::size_t>(i)];
      from(i) = std::uniform_real_distribution<double>(limit.lower, limit.upper)(random);
    }
    const auto other = SolveForPoints(arm, request.p_EM, request.p_WG, from,
                                      std::max(solved, kFitSlack * first.rms_error));
    if (!other.converged || Among(found, other.q) || Among(request.failed, other.q)) continue;
    found.push_back(other.q);
  }
  Branch best;
  for (const JointVector& q : found) {
    Branch branch;
    branch.q = q;
    branch.fit = first.rms_error;
    JudgeWay(view, rig, planner, request, best, &branch);
    if (Better(branch, best)) best = branch;
  }
  return best;
}

}  // namespace vantage
