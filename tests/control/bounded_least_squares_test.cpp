#include "vantage/control/bounded_least_squares.h"

#include <limits>
#include <random>

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include "allocation_guard.h"

namespace vantage {
namespace {

struct Problem {
  JointMatrix H;
  JointVector g, lower, upper;
};

Problem RandomProblem(int n, double box, std::mt19937* random) {
  std::normal_distribution<double> normal(0.0, 1.0);
  std::uniform_real_distribution<double> width(0.0, box);
  Problem p{JointMatrix(n, n), JointVector(n), JointVector(n), JointVector(n)};
  Eigen::MatrixXd A(n + 2, n);
  for (int i = 0; i < A.size(); ++i) A.data()[i] = normal(*random);
  p.H = A.transpose() * A + 1e-3 * Eigen::MatrixXd::Identity(n, n);
  for (int i = 0; i < n; ++i) {
    p.g(i) = normal(*random);
    p.lower(i) = -width(*random);
    p.upper(i) = width(*random);
  }
  return p;
}

double Cost(const Problem& p, const JointVector& x) {
  return 0.5 * x.dot(p.H * x) - p.g.dot(x);
}

// Every sign pattern of bounds, the free rest solved: the best feasible point is the optimum.
double BruteForceCost(const Problem& p) {
  const int n = static_cast<int>(p.g.size());
  int patterns = 1;
  for (int i = 0; i < n; ++i) patterns *= 3;
  double best = std::numeric_limits<double>::infinity();
  for (int code = 0; code < patterns; ++code) {
    JointVector x = JointVector::Zero(n);
    std::vector<int> free;
    for (int i = 0, rest = code; i < n; ++i, rest /= 3) {
      if (rest % 3 == 0) free.push_back(i);
      if (rest % 3 == 1) x(i) = p.lower(i);
      if (rest % 3 == 2) x(i) = p.upper(i);
    }
    const int m = static_cast<int>(free.size());
    Eigen::MatrixXd H(m, m);
    Eigen::VectorXd g(m);
    for (int a = 0; a < m; ++a) {
      g(a) = p.g(free[a]) - p.H.row(free[a]).dot(x);
      for (int b = 0; b < m; ++b) H(a, b) = p.H(free[a], free[b]);
    }
    const Eigen::VectorXd z = H.llt().solve(g);
    for (int a = 0; a < m; ++a) x(free[a]) = z(a);
    const bool feasible =
        ((x - p.lower).array() >= -1e-12).all() && ((p.upper - x).array() >= -1e-12).all();
    if (feasible) best = std::min(best, Cost(p, x));
  }
  return best;
}

TEST(MinimiseInBox, ReachesTheBestOfAllActiveSets) {
  std::mt19937 random(11);
  int bound_cases = 0;
  for (int i = 0; i < 300; ++i) {
    const int n = 1 + i % 6;
    const Problem p = RandomProblem(n, i % 2 == 0 ? 0.3 : 2.0, &random);
    const BoxSolution solution = MinimiseInBox(p.H, p.g, p.lower, p.upper, JointVector::Zero(n));
    ASSERT_TRUE(solution.optimal);
    EXPECT_TRUE((solution.x.array() >= p.lower.array()).all());
    EXPECT_TRUE((solution.x.array() <= p.upper.array()).all());
    const double best = BruteForceCost(p);
    EXPECT_NEAR(Cost(p, solution.x), best, 1e-10 * (1.0 + std::abs(best)));
    bound_cases += solution.active > 0 ? 1 : 0;
  }
  EXPECT_GT(bound_cases, 100);
}

TEST(MinimiseInBox, SixteenJointsAndEqualBounds) {
  std::mt19937 random(12);
  for (int i = 0; i < 50; ++i) {
    Problem p = RandomProblem(kMaxJoints, 0.2, &random);
    p.lower(3) = p.upper(3) = 0.05;
    const BoxSolution solution =
        MinimiseInBox(p.H, p.g, p.lower, p.upper, JointVector::Zero(kMaxJoints));
    EXPECT_TRUE(solution.optimal);
    EXPECT_EQ(solution.x(3), 0.05);
  }
}

TEST(MinimiseInBox, DoesNotAllocate) {
  if (!test::AllocationGuard::kSupported) GTEST_SKIP();
  std::mt19937 random(13);
  const Problem p = RandomProblem(7, 0.1, &random);
  const JointVector start = JointVector::Zero(7);
  const test::AllocationGuard guard;
  const BoxSolution solution = MinimiseInBox(p.H, p.g, p.lower, p.upper, start);
  EXPECT_EQ(guard.count(), 0u);
  EXPECT_GT(solution.active, 0);
}

}  // namespace
}  // namespace vantage
