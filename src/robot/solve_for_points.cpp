#include <algorithm>
#include <cassert>
#include <cmath>
#include <random>

#include <Eigen/Cholesky>

#include "vantage/robot/kinematics.h"

namespace vantage {
namespace {

constexpr int kMaxIterations = 100;  // Of one descent.
constexpr int kMaxDescents = 100;    // The first from q_start itself.

struct Problem {
  const ArmModel& arm;
  const std::vector<Eigen::Vector3d>& p_EP;
  const std::vector<Eigen::Vector3d>& p_WP;
};

double Cost(const Problem& problem, const JointVector& q) {
  const Eigen::Isometry3d X_WE = EndEffectorPose(problem.arm, q);
  double cost = 0.0;
  for (std::size_t i = 0; i < problem.p_EP.size(); ++i) {
    cost += (X_WE * problem.p_EP[i] - problem.p_WP[i]).squaredNorm();
  }
  return cost;
}

double Rms(const Problem& problem, double cost) {
  return std::sqrt(cost / static_cast<double>(problem.p_EP.size()));
}

// Normal equations of the residual: H = JᵀJ, g = Jᵀr.
void Linearise(const Problem& problem, const JointVector& q, JointMatrix* H, JointVector* g) {
  const Kinematics kinematics = ComputeKinematics(problem.arm, q);
  const int n = problem.arm.size();
  H->setZero(n, n);
  g->setZero(n);
  for (std::size_t i = 0; i < problem.p_EP.size(); ++i) {
    const Eigen::Vector3d arm_W = kinematics.X_WE.linear() * problem.p_EP[i];
    const Eigen::Vector3d r = kinematics.X_WE.translation() + arm_W - problem.p_WP[i];
    const PointJacobian J =
        kinematics.J_WE_W.topRows<3>() - Skew(arm_W) * kinematics.J_WE_W.bottomRows<3>();
    H->noalias() += J.transpose() * J;
    g->noalias() += J.transpose() * r;
  }
}

// A joint at a bound that descent would push through keeps still: its row and column become those of
// the identity.
void HoldBoundJoints(const Problem& problem, const JointVector& q, JointMatrix* H, JointVector* g) {
  const std::vector<JointLimits>& limits = problem.arm.limits();
  for (int i = 0; i < q.size(); ++i) {
    const bool held =
        (q(i) <= limits[i].lower && (*g)(i) > 0.0) || (q(i) >= limits[i].upper && (*g)(i) < 0.0);
    if (!held) continue;
    H->row(i).setZero();
    H->col(i).setZero();
    (*H)(i, i) = 1.0;
    (*g)(i) = 0.0;
  }
}

// One Levenberg-Marquardt descent inside the limits. Ends at a stationary point, at a distance far
// below the tolerance, or after kMaxIterations.
JointVector Descend(const Problem& problem, JointVector q, double tolerance) {
  const double enough = static_cast<double>(problem.p_EP.size()) * std::pow(1e-3 * tolerance, 2);
  JointMatrix H;
  JointVector g;
  double cost = Cost(problem, q);
  double damping = 1e-4;  // Relative to the diagonal of H.
  for (int iteration = 0; iteration < kMaxIterations && cost > enough; ++iteration) {
    Linearise(problem, q, &H, &g);
    HoldBoundJoints(problem, q, &H, &g);
    if (g.squaredNorm() == 0.0) break;
    const double floor = 1e-9 * H.diagonal().maxCoeff();
    bool better = false;
    while (!better && damping < 1e8) {
      JointMatrix damped = H;
      damped.diagonal() += damping * H.diagonal().cwiseMax(floor);
      const JointVector trial = ClampToLimits(problem.arm, q - damped.llt().solve(g));
      const double trial_cost = Cost(problem, trial);
      better = trial_cost < cost;
      if (better) {
        // Progress below rounding is no progress.
        const bool stationary = cost - trial_cost <= 1e-14 * cost;
        q = trial;
        cost = trial_cost;
        damping = std::max(1e-12, damping * 0.1);
        if (stationary) return q;
      } else {
        damping *= 8.0;
      }
    }
    if (!better) break;
  }
  return q;
}

// q moved at random by up to `share` of each joint's range.
JointVector Disturbed(const ArmModel& arm, const JointVector& q, double share,
                      std::mt19937* random) {
  JointVector moved = q;
  for (int i = 0; i < q.size(); ++i) {
    const JointLimits& limit = arm.limits()[i];
    std::uniform_real_distribution<double> step(-1.0, 1.0);
    moved(i) += share * (limit.upper - limit.lower) * step(*random);
  }
  return ClampToLimits(arm, moved);
}

}  // namespace

PointGoalSolution SolveForPoints(const ArmModel& arm, const std::vector<Eigen::Vector3d>& p_EP,
                                 const std::vector<Eigen::Vector3d>& p_WP,
                                 const JointVector& q_start, double tolerance) {
  assert(!p_EP.empty() && p_EP.size() == p_WP.size());
  assert(q_start.size() == arm.size());
  const Problem problem{arm, p_EP, p_WP};
  const JointVector q_first = ClampToLimits(arm, q_start);

  // A descent can end at a stationary point that is no solution (a stretched arm, a limit). Then it
  // starts again from beside q_start, further away each time, so that near branches are found first.
  std::mt19937 random(1);
  PointGoalSolution best;
  for (int descent = 0; descent < kMaxDescents; ++descent) {
    const double share = 0.5 * static_cast<double>(descent) / (kMaxDescents - 1);
    const JointVector start = descent == 0 ? q_first : Disturbed(arm, q_first, share, &random);
    const JointVector q = Descend(problem, start, tolerance);
    const double rms = Rms(problem, Cost(problem, q));
    // A tie (another turn of a joint, say) goes to the earlier one.
    if (descent == 0 || rms < 0.999 * best.rms_error) best = {q, rms, rms < tolerance};
    if (best.converged) break;
  }
  return best;
}

}  // namespace vantage
