#include "vantage/servo/branch_choice.h"

#include <gtest/gtest.h>

#include "eigen_matchers.h"
#include "vantage/config/loaders.h"
#include "vantage/math/angles.h"
#include "vantage/robot/kinematics.h"

namespace vantage {
namespace {

using Eigen::Vector3d;

constexpr double kSolved = 1e-4;

JointVector Joints(std::initializer_list<double> degrees) {
  JointVector q(static_cast<Eigen::Index>(degrees.size()));
  int i = 0;
  for (const double v : degrees) q(i++) = v * kDegree;
  return q;
}

// The PUMA 560 with four dots before its wrist, under a dome of views.
struct Puma {
  Puma() {
    for (int i = 0; i < 4; ++i) {
      view.markers.push_back(
          {i, {i % 2 == 0 ? 0.05 : -0.05, i < 2 ? 0.05 : -0.05, 0.08}, {0, 0, 1}, 0.009});
    }
    rig.kind = RigKind::kSpherical;
    rig.target_W = Vector3d(0, 0, 0.6);
    rig.axes = {{"R", 1.2, 2.0, 0.4, 1.2},
                {"theta", 0.1, 1.5, 1.0, 3.0},
                {"phi", -2.0 * kPi, 2.0 * kPi, 1.0, 3.0},
                {"roll", -kPi, kPi, 1.0, 3.0}};
    rig.max_linear_speed = 0.4;
  }

  [[nodiscard]] BranchRequest From(const JointVector& q, const JointVector& q_goal) const {
    BranchRequest request;
    request.q = q;
    const Eigen::Isometry3d X_WE = EndEffectorPose(view.arm, q_goal);
    for (const Marker& marker : view.markers) {
      request.p_EM.push_back(marker.p);
      request.p_WG.push_back(X_WE * marker.p);
    }
    request.q_c = Eigen::Vector4d(1.6, 0.5, 0.0, 0.0);
    return request;
  }

  [[nodiscard]] Branch Choose(const BranchRequest& request) const {
    return ChooseBranch(view, rig, {}, request, kSolved);
  }

  [[nodiscard]] double FitOf(const BranchRequest& request, const JointVector& q) const {
    double worst = 0.0;
    const Eigen::Isometry3d X_WE = EndEffectorPose(view.arm, q);
    for (std::size_t i = 0; i < request.p_EM.size(); ++i) {
      worst = std::max(worst, (X_WE * request.p_EM[i] - request.p_WG[i]).norm());
    }
    return worst;
  }

  ViewModel view{FindRobot("puma560"), CameraModel(), FeatureSet::AllPoints(4), {}};
  CameraRig rig;
};

TEST(ChooseBranch, TakesTheNearestWhereNothingSpeaksAgainstIt) {
  const Puma puma;
  const JointVector q_goal = Joints({20, 130, -120, 30, -60, 40});
  const Branch branch = puma.Choose(puma.From(Joints({10, 120, -110, 20, -50, 30}), q_goal));
  EXPECT_TRUE(test::Near(branch.q, q_goal, 1e-3));
  EXPECT_FALSE(branch.at_limit);
  EXPECT_FALSE(branch.touches_goal);
  EXPECT_FALSE(branch.passes_singularity);
  EXPECT_LT(branch.fit, kSolved);
}

// The nearest solution has the last joint at its limit of 266 degrees; a turn less is as good.
TEST(ChooseBranch, AvoidsAJointsLimit) {
  const Puma puma;
  const JointLimits& last = puma.view.arm.limits()[5];
  JointVector q_goal = Joints({20, 130, -120, 30, -60, 0});
  q_goal(5) = last.upper - 0.01;
  JointVector q = q_goal;
  q(5) -= 0.6;
  const BranchRequest request = puma.From(q, q_goal);
  const Branch branch = puma.Choose(request);
  ASSERT_EQ(branch.q.size(), 6);
  EXPECT_LT(puma.FitOf(request, branch.q), 1e-3);
  EXPECT_FALSE(branch.at_limit);
  EXPECT_GT(last.upper - branch.q(5), 0.04);
}

// A marker of the goal stands where the nearest way passes.
TEST(ChooseBranch, AvoidsRunningIntoTheGoalsMarkers) {
  const Puma puma;
  const JointVector q = Joints({-40, 130, -120, 30, -60, 40});
  const JointVector q_goal = Joints({40, 130, -120, 30, -60, 40});
  BranchRequest request = puma.From(q, q_goal);
  const Branch free = puma.Choose(request);
  ASSERT_TRUE(test::Near(free.q, q_goal, 1e-3));
  const Vector3d on_the_way =
      EndEffectorPose(puma.view.arm, 0.5 * (q + q_goal)) * puma.view.markers[0].p;
  request.goal_markers.push_back({on_the_way, Vector3d::UnitZ(), 0.009});
  const Branch other = puma.Choose(request);
  ASSERT_EQ(other.q.size(), 6);
  EXPECT_LT(puma.FitOf(request, other.q), 1e-3);
  EXPECT_FALSE(other.touches_goal);
  EXPECT_GT((other.q - free.q).lpNorm<Eigen::Infinity>(), 0.1);
}

TEST(ChooseBranch, LeavesFailedBranchesOut) {
  const Puma puma;
  const JointVector q_goal = Joints({20, 130, -120, 30, -60, 40});
  BranchRequest request = puma.From(Joints({10, 120, -110, 20, -50, 30}), q_goal);
  request.failed = {q_goal};
  const Branch branch = puma.Choose(request);
  ASSERT_EQ(branch.q.size(), 6);
  EXPECT_LT(puma.FitOf(request, branch.q), 1e-3);
  EXPECT_GT((branch.q - q_goal).lpNorm<Eigen::Infinity>(), 0.1);
}

TEST(ChooseBranch, KnowsWhatIsOutOfReach) {
  const Puma puma;
  BranchRequest request =
      puma.From(Joints({10, 120, -110, 20, -50, 30}), Joints({20, 130, -120, 30, -60, 40}));
  for (Vector3d& p_WG : request.p_WG) p_WG.x() += 3.0;
  EXPECT_EQ(puma.Choose(request).q.size(), 0);
}

}  // namespace
}  // namespace vantage
