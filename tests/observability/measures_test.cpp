#include "vantage/observability/measures.h"

#include <array>
#include <cmath>
#include <limits>
#include <random>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "allocation_guard.h"
#include "eigen_matchers.h"
#include "finite_difference.h"
#include "vantage/math/angles.h"

namespace vantage {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

MatrixXd RandomMatrix(std::mt19937* random, int rows, int columns) {
  std::normal_distribution<double> normal;
  MatrixXd J(rows, columns);
  for (int i = 0; i < rows; ++i) {
    for (int j = 0; j < columns; ++j) J(i, j) = normal(*random);
  }
  return J;
}

// Full rank, and its singular values spread over the given number of decades.
MatrixXd GradedMatrix(std::mt19937* random, int rows, int columns, double decades) {
  const int n = std::min(rows, columns);
  const MatrixXd U =
      RandomMatrix(random, rows, n).householderQr().householderQ() * MatrixXd::Identity(rows, n);
  const MatrixXd V = RandomMatrix(random, columns, n).householderQr().householderQ() *
                     MatrixXd::Identity(columns, n);
  VectorXd sigma(n);
  for (int i = 0; i < n; ++i)
    sigma(i) = 300.0 * std::pow(10.0, n > 1 ? -decades * i / (n - 1) : 0.0);
  return U * sigma.asDiagonal() * V.transpose();
}

// Singular values in 64-bit mantissa.
VectorXd Reference(const MatrixXd& J) {
  using Wide = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;
  return Eigen::JacobiSVD<Wide>(J.cast<long double>()).singularValues().cast<double>();
}

struct Shape {
  int rows, columns;
};

class EveryShape : public ::testing::TestWithParam<Shape> {};

INSTANTIATE_TEST_SUITE_P(Measure, EveryShape,
                         ::testing::Values(Shape{1, 1}, Shape{1, 6}, Shape{2, 6}, Shape{3, 3},
                                           Shape{4, 6}, Shape{5, 6}, Shape{6, 6}, Shape{8, 6},
                                           Shape{32, 6}, Shape{6, 7}, Shape{8, 7}, Shape{12, 2},
                                           Shape{6, 16}, Shape{16, 16}, Shape{32, 16},
                                           Shape{5, 32}));

TEST_P(EveryShape, SingularValuesMatchExtendedPrecision) {
  const auto [rows, columns] = GetParam();
  std::mt19937 random(21);
  for (const double decades : {0.0, 1.0, 3.0, 5.0}) {
    for (int trial = 0; trial < 20; ++trial) {
      const MatrixXd J = GradedMatrix(&random, rows, columns, decades);
      const VectorXd expected = Reference(J);
      const Measure measure = MeasureOf(J, kMaxRows);
      ASSERT_EQ(measure.status, MeasureStatus::kOk);
      const double sigma_1 = expected(0);
      EXPECT_TRUE(test::Near(measure.sigma, expected, 5e-15 * sigma_1));
      EXPECT_NEAR(measure.w, expected.prod(), 1e-9 * expected.prod());
      EXPECT_NEAR(measure.log_w, expected.array().log().sum(), 1e-9);
      EXPECT_EQ(measure.sigma_min, measure.sigma(measure.size() - 1));
      EXPECT_NEAR(measure.condition, sigma_1 / expected.minCoeff(), 1e-9 * measure.condition);
      EXPECT_EQ(measure.rank, std::min(rows, columns));
    }
  }
}

TEST_P(EveryShape, DecompositionRebuildsTheMatrix) {
  const auto [rows, columns] = GetParam();
  std::mt19937 random(22);
  for (const double decades : {0.0, 4.0}) {
    const MatrixXd J = GradedMatrix(&random, rows, columns, decades);
    const SingularSystem system = Decompose(J, kMaxRows);
    const int s = std::min(rows, columns);
    ASSERT_EQ(system.axes.cols(), s);
    EXPECT_TRUE(test::Near(MatrixXd(system.axes * system.directions.transpose()), J, 1e-12 * 300));
    EXPECT_TRUE(test::Near(MatrixXd(system.directions.transpose() * system.directions),
                           MatrixXd::Identity(s, s), 1e-10));
    const MatrixXd gram = system.axes.transpose() * system.axes;
    const VectorXd squares = system.measure.sigma.array().square();
    EXPECT_TRUE(test::Near(gram, MatrixXd(squares.asDiagonal()), 1e-11 * squares(0)));
  }
}

TEST_P(EveryShape, DecompositionFromANeighbourIsAsExact) {
  const auto [rows, columns] = GetParam();
  std::mt19937 random(23);
  for (const double decades : {0.0, 3.0, 5.0}) {
    for (const double change : {0.0, 1e-9, 1e-4, 1e-2, 1.0}) {
      const MatrixXd before = GradedMatrix(&random, rows, columns, decades);
      const MatrixXd J = before + 300.0 * change * RandomMatrix(&random, rows, columns);
      TaskJacobian vectors = VectorsOf(Decompose(before));
      // Vectors that have lost some of their orthonormality on the way.
      vectors.array() += 1e-12;
      const SingularSystem system = DecomposeNear(J, vectors);
      const VectorXd expected = Reference(J).head(system.measure.size());
      const double sigma_1 = expected(0);
      EXPECT_TRUE(test::Near(system.measure.sigma, expected, 5e-15 * sigma_1));
      const Eigen::Index s = system.measure.size();
      const auto& V = system.directions;
      // The directions of a wide matrix are images: what is small against σ_1 has lost digits to it.
      const bool wide = rows < columns;
      EXPECT_TRUE(test::Near(V.transpose() * V, MatrixXd::Identity(s, s), wide ? 1e-10 : 1e-13));
      EXPECT_TRUE(test::Near(J * V, system.axes, (wide ? 1e-12 : 1e-14) * sigma_1));
      const MatrixXd off = system.axes.transpose() * system.axes;
      for (Eigen::Index i = 0; i < s; ++i) {
        for (Eigen::Index j = 0; j < i; ++j) {
          EXPECT_LE(std::abs(off(i, j)), 1e-13 * sigma_1 * system.measure.sigma(j));
        }
      }
    }
  }
}

TEST(DecomposeNear, SaysOfLostDirectionsAndBadMatricesWhatDecomposeSays) {
  std::mt19937 random(24);
  MatrixXd J = RandomMatrix(&random, 8, 6);
  const TaskJacobian before = VectorsOf(Decompose(J));
  J.col(5) = J.col(0) - J.col(1);
  EXPECT_EQ(DecomposeNear(J, before).measure.rank, 5);
  EXPECT_EQ(DecomposeNear(MatrixXd::Zero(8, 6), before).measure.w, 0.0);
  J(3, 3) = kNaN;
  EXPECT_EQ(DecomposeNear(J, before).measure.status, MeasureStatus::kNotFinite);
  EXPECT_EQ(DecomposeNear(MatrixXd(0, 6), before).measure.status, MeasureStatus::kEmpty);
  const MatrixXd good = RandomMatrix(&random, 8, 6);
  for (const TaskJacobian& none :
       {TaskJacobian(TaskJacobian::Constant(6, 6, kNaN)), TaskJacobian(0, 0)}) {
    EXPECT_TRUE(test::Near(DecomposeNear(good, none).measure.sigma, Reference(good), 1e-14));
  }
  MatrixXd wide = RandomMatrix(&random, 2, 6);
  const TaskJacobian wide_before = VectorsOf(Decompose(wide));
  wide.row(1) = 2.0 * wide.row(0);
  EXPECT_EQ(DecomposeNear(wide, wide_before).measure.rank, 1);
  EXPECT_TRUE(
      test::Near(DecomposeNear(wide, wide_before).directions, Decompose(wide).directions, 0.0));
}

// From any system before; of arms with as many joints as the task has dimensions, more, and fewer; of an arm that
// has lost a direction too.
TEST(DecomposeComposite, IsTheDecompositionOfJcAndTheVolumeOfJr) {
  std::mt19937 random(25);
  for (const int k : {2, 6, 8, 12, 32}) {
    for (const int n : {2, 5, 6, 7, 9, 16}) {
      for (const bool lost : {false, true}) {
        const FeatureJacobian J_v = 300.0 * RandomMatrix(&random, k, 6);
        ArmJacobian J_r = RandomMatrix(&random, 6, n);
        if (lost) J_r.row(4) = J_r.row(0) - 2.0 * J_r.row(2);
        CompositeSystem composite;
        for (const double step : {0.0, 1e-4, 1e-4, 1e-2}) {
          J_r += step * RandomMatrix(&random, 6, n);
          if (lost) J_r.row(4) = J_r.row(0) - 2.0 * J_r.row(2);
          const TaskJacobian J_c = J_v * J_r;
          DecomposeComposite(J_v, J_r, J_c, &composite);
          const Volume arm = VolumeOf(J_r);
          EXPECT_EQ(composite.arm.rank, arm.rank);
          EXPECT_NEAR(composite.arm.w, arm.w, 1e-12 * arm.w + 1e-14);
          EXPECT_TRUE(lost || std::abs(composite.arm.log_w - arm.log_w) < 1e-11);
          const SingularSystem& system = composite.system;
          const Measure expected = MeasureOf(J_c);
          const double sigma_1 = expected.sigma(0);
          EXPECT_EQ(system.measure.rank, expected.rank);
          EXPECT_TRUE(test::Near(system.measure.sigma, expected.sigma, 2e-14 * sigma_1));
          const auto& V = system.directions;
          EXPECT_TRUE(test::Near(V.transpose() * V, MatrixXd::Identity(V.cols(), V.cols()), 1e-10));
          EXPECT_TRUE(test::Near(J_c * V, system.axes, 1e-12 * sigma_1));
        }
      }
    }
  }
}

TEST_P(EveryShape, PseudoInverseMeetsPenrosesConditions) {
  const auto [rows, columns] = GetParam();
  std::mt19937 random(23);
  MatrixXd J = GradedMatrix(&random, rows, columns, 2.0);
  if (columns > 1) J.col(columns - 1) = J.col(0);  // may lose a rank
  const MatrixXd P = PseudoInverse(Decompose(J, kMaxRows));
  EXPECT_TRUE(test::Near(MatrixXd(J * P * J), J, 1e-9));
  EXPECT_TRUE(test::Near(MatrixXd(P * J * P), P, 1e-9));
  EXPECT_TRUE(test::Near(MatrixXd(J * P), MatrixXd((J * P).transpose()), 1e-9));
  EXPECT_TRUE(test::Near(MatrixXd(P * J), MatrixXd((P * J).transpose()), 1e-9));
}

// The image of the unit sphere of the motions that J sees is the ellipsoid's surface.
TEST_P(EveryShape, EllipsoidIsTheImageOfTheUnitSphere) {
  const auto [rows, columns] = GetParam();
  std::mt19937 random(24);
  const MatrixXd J = GradedMatrix(&random, rows, columns, 1.0);
  const SingularSystem system = Decompose(J, kMaxRows);
  const MatrixXd E = EllipsoidMatrix(system);
  const int s = std::min(rows, columns);
  for (int trial = 0; trial < 20; ++trial) {
    const VectorXd x =
        MatrixXd(system.directions) * VectorXd(RandomMatrix(&random, s, 1)).normalized();
    const VectorXd y = J * x;
    EXPECT_NEAR(y.dot(E * y), 1.0, 1e-10);
  }
}

TEST(Measure, TaskDimensionCapsTheRank) {
  std::mt19937 random(25);
  // Eight features of a 7-joint arm: J_c has rank 6, though it is 8×7.
  const MatrixXd J_v = RandomMatrix(&random, 8, 6);
  const MatrixXd J_r = RandomMatrix(&random, 6, 7);
  const Measure measure = MeasureOf(MatrixXd(J_v * J_r));
  EXPECT_EQ(measure.size(), 6);
  EXPECT_EQ(measure.rank, 6);
  EXPECT_NEAR(measure.w, MeasureOf(J_v).w * MeasureOf(J_r).w, 1e-12 * measure.w);
}

TEST(Measure, KnownDiagonal) {
  MatrixXd J = MatrixXd::Zero(3, 3);
  J.diagonal() << 2.0, -5.0, 0.5;
  const Measure measure = MeasureOf(J);
  EXPECT_TRUE(test::Near(measure.sigma, Vector3d(5.0, 2.0, 0.5), 1e-15));
  EXPECT_NEAR(measure.w, 5.0, 1e-15);
  EXPECT_NEAR(measure.geometric_mean(), std::cbrt(5.0), 1e-14);
  EXPECT_NEAR(measure.inverse_condition(), 0.1, 1e-16);
  EXPECT_NEAR(measure.inverse_trace(), 4.0 + 0.25 + 0.04, 1e-14);
}

TEST(Measure, RankDeficientMatrixHasNoVolume) {
  std::mt19937 random(26);
  const MatrixXd J = RandomMatrix(&random, 8, 4) * RandomMatrix(&random, 4, 6);
  const Measure measure = MeasureOf(J);
  EXPECT_EQ(measure.size(), 6);
  EXPECT_EQ(measure.rank, 4);
  EXPECT_LE(measure.w, 1e-9 * std::pow(measure.sigma(0), 6));
  EXPECT_LE(measure.sigma_min, 1e-14 * measure.sigma(0));
}

TEST(Measure, ZeroMatrix) {
  const MatrixXd J = MatrixXd::Zero(4, 3);
  const SingularSystem system = Decompose(J);
  const Measure& measure = system.measure;
  EXPECT_EQ(measure.status, MeasureStatus::kOk);
  EXPECT_EQ(measure.rank, 0);
  EXPECT_EQ(measure.w, 0.0);
  EXPECT_EQ(measure.log_w, -kInfinity);
  EXPECT_EQ(measure.condition, kInfinity);
  EXPECT_EQ(measure.geometric_mean(), 0.0);
  EXPECT_EQ(measure.inverse_condition(), 0.0);
  EXPECT_EQ(measure.inverse_trace(), kInfinity);
  EXPECT_TRUE(test::Near(MatrixXd(system.directions.transpose() * system.directions),
                         MatrixXd::Identity(3, 3), 1e-15));
  EXPECT_TRUE(test::Near(MatrixXd(PseudoInverse(system)), MatrixXd::Zero(3, 4), 0.0));
}

// The lost directions are still an orthonormal set, and J maps them to 0.
TEST(Measure, DirectionsSpanTheLostMotionsToo) {
  std::mt19937 random(27);
  for (const Shape shape : {Shape{8, 6}, Shape{5, 7}}) {
    MatrixXd J = RandomMatrix(&random, shape.rows, 3) * RandomMatrix(&random, 3, shape.columns);
    J.col(0).setZero();
    const SingularSystem system = Decompose(J);
    const auto s = system.directions.cols();
    EXPECT_TRUE(test::Near(MatrixXd(system.directions.transpose() * system.directions),
                           MatrixXd::Identity(s, s), 1e-10));
    if (shape.rows >= shape.columns) {
      const MatrixXd lost = J * system.directions.rightCols(s - system.measure.rank);
      EXPECT_TRUE(test::Near(lost, MatrixXd::Zero(lost.rows(), lost.cols()), 1e-13));
    }
  }
}

TEST(Measure, ExtremeScalesNeitherOverflowNorVanish) {
  std::mt19937 random(28);
  const MatrixXd J = RandomMatrix(&random, 4, 3);
  const VectorXd expected = Reference(J);
  for (const double scale : {1e-250, 1e-130, 1e130, 1e250}) {
    const Measure measure = MeasureOf(MatrixXd(scale * J));
    EXPECT_TRUE(test::Near(measure.sigma / scale, expected, 1e-14 * expected(0)));
    EXPECT_NEAR(measure.log_w, expected.array().log().sum() + 3 * std::log(scale), 1e-10);
    EXPECT_EQ(measure.rank, 3);
  }
}

void ExpectNothing(const Measure& measure, MeasureStatus status) {
  EXPECT_EQ(measure.status, status);
  EXPECT_EQ(measure.size(), 0);
  EXPECT_EQ(measure.w, 0.0);
  EXPECT_EQ(measure.log_w, -kInfinity);
  EXPECT_EQ(measure.sigma_min, 0.0);
  EXPECT_EQ(measure.condition, kInfinity);
  EXPECT_EQ(measure.rank, 0);
  EXPECT_EQ(measure.geometric_mean(), 0.0);
  EXPECT_EQ(measure.inverse_condition(), 0.0);
  EXPECT_EQ(EllipsoidVolume(measure), 0.0);
}

TEST(Measure, NamesWhatItCannotMeasure) {
  ExpectNothing(MeasureOf(MatrixXd(0, 6)), MeasureStatus::kEmpty);
  ExpectNothing(MeasureOf(MatrixXd(6, 0)), MeasureStatus::kEmpty);
  ExpectNothing(MeasureOf(MatrixXd::Zero(kMaxRows + 1, 6)), MeasureStatus::kTooLarge);
  ExpectNothing(MeasureOf(MatrixXd::Zero(kMaxRows, kMaxJoints + 1)), MeasureStatus::kTooLarge);
  for (const double bad : {kNaN, kInfinity, -kInfinity}) {
    MatrixXd J = MatrixXd::Identity(6, 6);
    J(3, 4) = bad;
    ExpectNothing(MeasureOf(J), MeasureStatus::kNotFinite);
    const SingularSystem system = Decompose(J);
    ExpectNothing(system.measure, MeasureStatus::kNotFinite);
    EXPECT_EQ(system.axes.size(), 0);
    EXPECT_EQ(system.directions.size(), 0);
    EXPECT_EQ(PseudoInverse(system).size(), 0);
    EXPECT_EQ(EllipsoidMatrix(system).size(), 0);
    EXPECT_EQ(BoundErrors(system.measure, 6, 6).upper, kInfinity);
    EXPECT_EQ(CouplingOf(system.measure, system.measure, system.measure).ratio, 0.0);
  }
}

TEST(EllipsoidVolume, OfKnownDimensions) {
  MatrixXd J = MatrixXd::Zero(3, 3);
  J.diagonal() << 2.0, 3.0, 5.0;
  EXPECT_NEAR(EllipsoidVolume(MeasureOf(J)), 4.0 / 3.0 * kPi * 30.0, 1e-12);
  EXPECT_NEAR(EllipsoidVolume(MeasureOf(J.topRows(2))), kPi * 6.0, 1e-13);
  EXPECT_NEAR(EllipsoidVolume(MeasureOf(J.topRows(1))), 2.0 * 2.0, 1e-14);
}

TEST(BoundErrors, HoldForComputedMotions) {
  std::mt19937 random(29);
  for (const Shape shape : {Shape{3, 6}, Shape{6, 6}, Shape{10, 6}}) {
    const MatrixXd J = GradedMatrix(&random, shape.rows, shape.columns, 1.0);
    const SingularSystem system = Decompose(J);
    const ErrorBounds bounds = BoundErrors(system.measure, shape.rows, shape.columns);
    EXPECT_EQ(bounds.lower_needs_range, shape.rows > shape.columns);
    EXPECT_EQ(bounds.upper_needs_minimum_norm, shape.rows < shape.columns);
    const MatrixXd P = PseudoInverse(system);
    for (int trial = 0; trial < 100; ++trial) {
      const VectorXd in_range = J * RandomMatrix(&random, shape.columns, 1);
      const double ratio = (P * in_range).norm() / in_range.norm();
      EXPECT_GE(ratio, bounds.lower * (1 - 1e-12));
      const VectorXd any = RandomMatrix(&random, shape.rows, 1);
      EXPECT_LE((P * any).norm() / any.norm(), bounds.upper * (1 + 1e-12));
    }
    // Both are reached, along the first and the last axis.
    const VectorXd first = system.axes.col(0);
    const VectorXd last = system.axes.rightCols<1>();
    EXPECT_NEAR((P * first).norm() / first.norm(), bounds.lower, 1e-12 * bounds.lower);
    EXPECT_NEAR((P * last).norm() / last.norm(), bounds.upper, 1e-10 * bounds.upper);
  }
}

TEST(BoundErrors, UnboundedWhereAMotionIsLost) {
  MatrixXd J = MatrixXd::Identity(6, 6);
  J.row(5) = J.row(4);
  EXPECT_EQ(BoundErrors(MeasureOf(J), 6, 6).upper, kInfinity);
}

// docs/paper.md, eq. 20: w_c = w_v w_r whenever m <= min(k, n), not for square matrices alone.
TEST(Coupling, IsOneWhereFeaturesAndJointsCoverTheTask) {
  std::mt19937 random(30);
  for (const auto& [k, n] : {std::pair{6, 6}, {8, 6}, {6, 7}, {12, 9}}) {
    const MatrixXd J_v = RandomMatrix(&random, k, 6);
    const MatrixXd J_r = RandomMatrix(&random, 6, n);
    const Coupling coupling =
        CouplingOf(MeasureOf(J_v), MeasureOf(J_r), MeasureOf(MatrixXd(J_v * J_r)));
    EXPECT_NEAR(coupling.ratio, 1.0, 1e-11);
    EXPECT_NEAR(coupling.horn, 1.0, 1e-11);
  }
}

TEST(Coupling, IsTheProductOfPrincipalCosinesWhereSquare) {
  std::mt19937 random(31);
  for (int n = 1; n <= 6; ++n) {
    const MatrixXd J_v = RandomMatrix(&random, n, 6);
    const MatrixXd J_r = RandomMatrix(&random, 6, n);
    const MatrixXd seen =
        MatrixXd(J_v.transpose()).householderQr().householderQ() * MatrixXd::Identity(6, n);
    const MatrixXd done = J_r.householderQr().householderQ() * MatrixXd::Identity(6, n);
    const double cosines = std::abs((seen.transpose() * done).determinant());
    const Coupling coupling =
        CouplingOf(MeasureOf(J_v), MeasureOf(J_r), MeasureOf(MatrixXd(J_v * J_r)));
    EXPECT_NEAR(coupling.ratio, cosines, 1e-10);
    EXPECT_NEAR(coupling.horn, cosines, 1e-10);
  }
}

TEST(Coupling, HornBoundsEveryShape) {
  std::mt19937 random(32);
  for (int k = 1; k <= 9; ++k) {
    for (int n = 1; n <= 9; ++n) {
      const MatrixXd J_v = RandomMatrix(&random, k, 6);
      const MatrixXd J_r = RandomMatrix(&random, 6, n);
      const Measure composite = MeasureOf(MatrixXd(J_v * J_r));
      const Coupling coupling = CouplingOf(MeasureOf(J_v), MeasureOf(J_r), composite);
      EXPECT_GT(coupling.horn, 0.0);
      EXPECT_LE(coupling.horn, 1.0);
    }
  }
}

TEST(Whiten, GivesTheCovarianceOfTheComputedTwist) {
  std::mt19937 random(33);
  const MatrixXd J = RandomMatrix(&random, 8, 6);
  const MatrixXd F = RandomMatrix(&random, 8, 8);
  const MatrixXd C = F * F.transpose() + 0.1 * MatrixXd::Identity(8, 8);
  TaskJacobian whitened = J;
  ASSERT_TRUE(Whiten(C, &whitened));
  // Covariance of the least-squares twist with weights C^-1.
  const MatrixXd covariance = (J.transpose() * C.inverse() * J).inverse();
  EXPECT_NEAR(MeasureOf(whitened).w, 1.0 / std::sqrt(covariance.determinant()),
              1e-10 * MeasureOf(whitened).w);
  EXPECT_NEAR(MeasureOf(whitened).inverse_trace(), covariance.trace(), 1e-9 * covariance.trace());
}

TEST(Whiten, RefusesWhatIsNoCovariance) {
  const TaskJacobian J = MatrixXd::Ones(3, 2);
  MatrixXd indefinite = MatrixXd::Identity(3, 3);
  indefinite(2, 2) = -1.0;
  MatrixXd undefined = MatrixXd::Identity(3, 3);
  undefined(1, 1) = kNaN;
  for (const MatrixXd& C : {indefinite, undefined, MatrixXd(MatrixXd::Zero(3, 3)),
                            MatrixXd(MatrixXd::Identity(2, 2))}) {
    TaskJacobian same = J;
    EXPECT_FALSE(Whiten(C, &same));
    EXPECT_TRUE(test::Near(same, J, 0.0));
  }
}

TEST(Scaling, OfTwistsLeavesTheCompositeAlone) {
  std::mt19937 random(34);
  const FeatureJacobian J_v = RandomMatrix(&random, 5, 6);
  const ArmJacobian J_r = RandomMatrix(&random, 6, 4);
  const MatrixXd scaled = ScaleTwistOfImage(J_v, 0.3) * ScaleTwistOfArm(J_r, 0.3);
  EXPECT_TRUE(test::Near(scaled, MatrixXd(J_v * J_r), 1e-14));
  // For k >= m a change of unit only rescales w_v.
  const FeatureJacobian tall = RandomMatrix(&random, 8, 6);
  EXPECT_NEAR(MeasureOf(ScaleTwistOfImage(tall, 0.3)).w, MeasureOf(tall).w / std::pow(0.3, 3),
              1e-12 * MeasureOf(tall).w / std::pow(0.3, 3));
}

TEST(Scaling, CharacteristicLengthBalancesTheRows) {
  std::mt19937 random(35);
  ArmJacobian J_r = RandomMatrix(&random, 6, 5);
  J_r.topRows<3>() *= 0.25;
  const ArmJacobian scaled = ScaleTwistOfArm(J_r, CharacteristicLength(J_r));
  EXPECT_NEAR(scaled.topRows<3>().norm(), scaled.bottomRows<3>().norm(), 1e-14);
  J_r.bottomRows<3>().setZero();
  EXPECT_EQ(CharacteristicLength(J_r), 1.0);
}

TEST(Scaling, OfJointsScalesColumns) {
  std::mt19937 random(36);
  const TaskJacobian J = RandomMatrix(&random, 4, 3);
  const TaskJacobian scaled = ScaleJoints(J, Vector3d(1.0, 0.5, 2.0));
  EXPECT_TRUE(test::Near(scaled.col(1), J.col(1) * 0.5, 0.0));
  EXPECT_TRUE(test::Near(scaled.col(2), J.col(2) * 2.0, 0.0));
}

// A two-link arm in the plane Wz = 0 (links of 1 m), its tip seen by a camera: J_v of a point with
// focal length 600 px at depth 2 m, looking down, or along the plane.
struct PlanarView {
  ArmJacobian J_r{6, 2};
  MatrixXd J_v{2, 6};
};

PlanarView PlanarCase(double elbow, double tilt) {
  PlanarView view;
  view.J_r.setZero();
  view.J_r.row(0) << -std::sin(elbow), -std::sin(elbow);
  view.J_r.row(1) << 1.0 + std::cos(elbow), std::cos(elbow);
  view.J_r.row(5) << 1.0, 1.0;
  view.J_v.setZero();
  view.J_v(0, 0) = 300.0;
  view.J_v(1, 1) = 300.0 * std::cos(tilt);
  view.J_v(1, 2) = 300.0 * std::sin(tilt);
  return view;
}

// The point is E's origin.
LowCause Cause(const PlanarView& view, int rows_needed, bool low) {
  const MatrixXd J_c = view.J_v * view.J_r;
  return DiagnoseLowMeasure(Decompose(J_c), {PointJacobianOf(view.J_r, Vector3d::Zero())},
                            rows_needed, low);
}

TEST(DiagnoseLowMeasure, FindsTheCause) {
  EXPECT_EQ(Cause(PlanarCase(1.2, 0.0), 2, false), LowCause::kNone);
  EXPECT_EQ(Cause(PlanarCase(1.2, 1.55), 2, true), LowCause::kView);     // grazing view
  EXPECT_EQ(Cause(PlanarCase(1.2, kPi / 2), 2, true), LowCause::kView);  // edge on
  EXPECT_EQ(Cause(PlanarCase(1.2, 0.0), 3, true), LowCause::kFeatures);
  EXPECT_EQ(Cause(PlanarCase(1.2, 0.0), 3, false), LowCause::kFeatures);
}

TEST(DiagnoseLowMeasure, BlamesTheArmForWhatItCannotDo) {
  PlanarView view = PlanarCase(1.2, 0.0);
  view.J_r.col(1) = 0.5 * view.J_r.col(0);  // two joints of one effect
  EXPECT_EQ(Cause(view, 2, true), LowCause::kArm);
  view.J_r(0, 1) += 1e-3;  // nearly
  EXPECT_EQ(Cause(view, 2, true), LowCause::kArm);
}

// Stretched or folded, the planar arm still turns its tip (J_r has rank 2), but its POINT moves across the
// arm alone: no camera sees more of the joints, wherever it stands.
TEST(DiagnoseLowMeasure, BlamesTheArmWhereThePointsStandStill) {
  for (const double elbow : {0.0, kPi, 1e-4}) {
    for (const double tilt : {0.0, 0.7, 1.55}) {
      const PlanarView view = PlanarCase(elbow, tilt);
      EXPECT_EQ(MeasureOf(view.J_r).rank, 2);
      EXPECT_EQ(Cause(view, 2, true), LowCause::kArm) << elbow << " " << tilt;
    }
  }
  EXPECT_EQ(Cause(PlanarCase(0.01, 0.0), 2, true), LowCause::kArm);  // half a degree
  EXPECT_EQ(Cause(PlanarCase(0.01, 1.55), 2, true),
            LowCause::kView);  // and looked at along the arm
  EXPECT_EQ(Cause(PlanarCase(0.3, 0.0), 2, true), LowCause::kView);
  EXPECT_EQ(Cause(PlanarCase(0.3, 1.55), 2, true), LowCause::kView);
}

// With a second point off the tip the stretched arm's turn can be seen: then the view is to blame.
TEST(DiagnoseLowMeasure, ASecondPointShowsWhatTheFirstDoesNot) {
  const PlanarView view = PlanarCase(0.0, kPi / 2);
  const std::vector<PointJacobian> points{PointJacobianOf(view.J_r, Vector3d::Zero()),
                                          PointJacobianOf(view.J_r, Vector3d(0.0, 0.3, 0.0))};
  const SingularSystem composite = Decompose(MatrixXd(view.J_v * view.J_r));
  EXPECT_EQ(DiagnoseLowMeasure(composite, points, 2, true), LowCause::kView);
}

// The view hides one motion and the arm lacks another: no camera makes w_c more than 0.
TEST(DiagnoseLowMeasure, TheArmGoesBeforeTheView) {
  ArmJacobian J_r = ArmJacobian::Zero(6, 3);
  J_r.topLeftCorner<2, 2>().setIdentity();  // third joint: nothing moves
  const PointJacobian point = PointJacobianOf(J_r, Vector3d::Zero());
  Eigen::Matrix3d view = Eigen::Vector3d(500.0, 0.0, 500.0).asDiagonal();  // blind in y
  const SingularSystem composite = Decompose(MatrixXd(view * point));
  EXPECT_EQ(composite.measure.rank, 1);
  EXPECT_EQ(DiagnoseLowMeasure(composite, {point}, 3, true), LowCause::kArm);
}

// Points of one body, however they are given; arms with too few joints, enough and more, near a singularity too.
TEST(DiagnoseLowMeasure, IsTheSameOfPointsOfOneBody) {
  std::mt19937 random(27);
  std::array<int, 4> count{};
  for (int i = 0; i < 400; ++i) {
    const int n = 2 + i % 7;
    ArmJacobian J_r = RandomMatrix(&random, 6, n);
    if (i % 3 == 0) J_r.col(n - 1) = J_r.col(0) * 2.0 + std::pow(10.0, -(i % 5)) * J_r.col(n - 1);
    const MatrixXd J_v = 300.0 * RandomMatrix(&random, 1 + i % 11, 6);
    std::vector<Vector3d> p;
    std::vector<PointJacobian> points;
    for (int j = 0; j < 1 + i % 4; ++j) {
      p.emplace_back(RandomMatrix(&random, 3, 1));
      points.push_back(PointJacobianOf(J_r, p.back()));
    }
    const SingularSystem composite = Decompose(J_v * J_r);
    const LowCause cause = DiagnoseLowMeasure(composite, points, 1, true);
    const ArmJacobian twists = TwistsOf(composite, J_r);
    EXPECT_EQ(DiagnoseLowMeasure(composite, VolumeOf(J_r), J_r, twists, p, 1, true), cause);
    EXPECT_EQ(DiagnoseLowMeasure(composite, VolumeOf(J_r), J_r, twists, p, 1, false),
              LowCause::kNone);
    EXPECT_EQ(DiagnoseLowMeasure(composite, VolumeOf(J_r), J_r, twists, p, 12, true),
              LowCause::kFeatures);
    EXPECT_EQ(DiagnoseLowMeasure(composite, VolumeOf(J_r), J_r, twists, {}, 1, true),
              LowCause::kFeatures);
    ++count[static_cast<std::size_t>(cause)];
  }
  EXPECT_GT(count[static_cast<std::size_t>(LowCause::kArm)], 20);
  EXPECT_GT(count[static_cast<std::size_t>(LowCause::kView)], 20);
}

TEST(DiagnoseLowMeasure, NothingSeenIsForWantOfFeatures) {
  const PlanarView view = PlanarCase(1.2, 0.0);
  const PointJacobian point = PointJacobianOf(view.J_r, Vector3d::Zero());
  const SingularSystem nothing = Decompose(MatrixXd(0, 2));
  EXPECT_EQ(DiagnoseLowMeasure(nothing, {point}, 0, true), LowCause::kFeatures);
  const SingularSystem composite = Decompose(MatrixXd(view.J_v * view.J_r));
  EXPECT_EQ(DiagnoseLowMeasure(composite, {}, 2, true), LowCause::kFeatures);
}

// ∂(log w)/∂J against central differences: tall, wide, square, and capped by the task dimension.
TEST(GradientOfLog, MatchesCentralDifferences) {
  std::mt19937 random(43);
  struct Size {
    int rows, columns, task;
  };
  for (const Size& size : {Size{8, 6, 6}, Size{2, 7, 6}, Size{3, 3, 3}, Size{1, 5, 6},
                           Size{6, 2, 6}, Size{16, 16, 16}}) {
    const MatrixXd J = RandomMatrix(&random, size.rows, size.columns);
    const LogGradient gradient = GradientOfLog(Decompose(J, size.task));
    ASSERT_EQ(gradient.status, GradientStatus::kOk);
    const MatrixXd numeric = test::CentralDifference(
        [&](const VectorXd& step) -> VectorXd {
          const MatrixXd moved = J + Eigen::Map<const MatrixXd>(step.data(), J.rows(), J.cols());
          return Eigen::Vector2d(MeasureOf(moved, size.task).log_w, 0.0);
        },
        2, static_cast<int>(J.size()));
    const MatrixXd by_J =
        Eigen::Map<const MatrixXd>(VectorXd(numeric.row(0)).data(), J.rows(), J.cols());
    EXPECT_TRUE(test::Near(gradient.by_J, by_J, 1e-7 * by_J.cwiseAbs().maxCoeff()));
  }
  // 8×7 of rank 6: along motions that keep the rank at 6.
  const MatrixXd A = RandomMatrix(&random, 8, 6), B = RandomMatrix(&random, 6, 7);
  const MatrixXd dA = RandomMatrix(&random, 8, 6);
  const LogGradient gradient = GradientOfLog(Decompose(MatrixXd(A * B)));
  ASSERT_EQ(gradient.status, GradientStatus::kOk);
  const double h = 1e-6;
  const double numeric =
      (MeasureOf((A + h * dA) * B).log_w - MeasureOf((A - h * dA) * B).log_w) / (2.0 * h);
  EXPECT_NEAR(gradient.by_J.cwiseProduct(dA * B).sum(), numeric, 1e-7 * std::abs(numeric));
}

TEST(GradientOfLog, IsNamedWhereThereIsNone) {
  std::mt19937 random(44);
  MatrixXd J = RandomMatrix(&random, 4, 3);
  J.col(2) = J.col(0) - 2.0 * J.col(1);
  const LogGradient singular = GradientOfLog(Decompose(J));
  EXPECT_EQ(singular.status, GradientStatus::kSingular);
  EXPECT_EQ(singular.by_J.size(), 0);
  EXPECT_EQ(GradientOfLog(Decompose(MatrixXd::Zero(2, 2))).status, GradientStatus::kSingular);
  EXPECT_EQ(GradientOfLog(Decompose(MatrixXd(0, 3))).status, GradientStatus::kNotMeasured);
  J(0, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(GradientOfLog(Decompose(J)).status, GradientStatus::kNotMeasured);
}

TEST(PointJacobian, IsTheVelocityOfARigidBodysPoint) {
  std::mt19937 random(37);
  const ArmJacobian J_r = RandomMatrix(&random, 6, 4);
  const Vector3d p(0.1, -0.2, 0.3);
  const VectorXd qdot = RandomMatrix(&random, 4, 1);
  const Vector3d v = J_r.topRows<3>() * qdot;
  const Vector3d w = J_r.bottomRows<3>() * qdot;
  EXPECT_TRUE(test::Near(PointJacobianOf(J_r, p) * qdot, v + w.cross(p), 1e-14));
}

// No joint motion of one pixel moves a point further, and one moves it as far.
TEST(WorstMillimetresPerPixel, BoundsEveryMotionOfOnePixel) {
  std::mt19937 random(38);
  const MatrixXd J_c = 200.0 * RandomMatrix(&random, 6, 3);
  const std::vector<PointJacobian> points{RandomMatrix(&random, 3, 3), RandomMatrix(&random, 3, 3)};
  const double worst = WorstMillimetresPerPixel(Decompose(J_c), points);
  double seen = 0.0;
  for (int trial = 0; trial < 200000; ++trial) {
    VectorXd dq = RandomMatrix(&random, 3, 1);
    dq /= (J_c * dq).norm();
    for (const PointJacobian& A : points) seen = std::max(seen, 1e3 * (A * dq).norm());
  }
  EXPECT_LE(seen, worst * (1 + 1e-12));
  EXPECT_GE(seen, 0.98 * worst);
}

TEST(WorstMillimetresPerPixel, MatchesTheOperatorNorm) {
  std::mt19937 random(39);
  for (int n = 1; n <= 7; ++n) {
    const MatrixXd J_c = 100.0 * RandomMatrix(&random, 8, n);
    const MatrixXd A = RandomMatrix(&random, 3, n);
    const MatrixXd hidden = A * J_c.completeOrthogonalDecomposition().pseudoInverse();
    const double expected = 1e3 * Eigen::JacobiSVD<MatrixXd>(hidden).singularValues()(0);
    EXPECT_NEAR(WorstMillimetresPerPixel(Decompose(J_c, n), {A}), expected, 1e-7 * expected);
  }
}

TEST(WorstMillimetresPerPixel, UnboundedWhereAPointMovesUnseen) {
  std::mt19937 random(40);
  const MatrixXd J_c = RandomMatrix(&random, 2, 3);
  EXPECT_EQ(WorstMillimetresPerPixel(Decompose(J_c), {RandomMatrix(&random, 3, 3)}), kInfinity);
  EXPECT_EQ(WorstMillimetresPerPixel(Decompose(MatrixXd(0, 3)), {RandomMatrix(&random, 3, 3)}),
            kInfinity);
  EXPECT_EQ(WorstMillimetresPerPixel(Decompose(J_c), {}), 0.0);
}

// Of points on one body both ways give the same, with unseen motions and without.
TEST(WorstMillimetresPerPixel, OfOneBodyIsThatOfItsPoints) {
  std::mt19937 random(44);
  for (int n = 1; n <= 8; ++n) {
    for (const int k : {3, 8}) {
      const ArmJacobian J_r = RandomMatrix(&random, 6, n);
      const SingularSystem system = Decompose(300.0 * RandomMatrix(&random, k, 6) * J_r);
      std::vector<PointJacobian> by_point;
      std::vector<Vector3d> points;
      for (int i = 0; i < 5; ++i) {
        points.push_back(0.2 * RandomMatrix(&random, 3, 1));
        by_point.push_back(PointJacobianOf(J_r, points.back()));
      }
      const double expected = WorstMillimetresPerPixel(system, by_point);
      const double worst = WorstMillimetresPerPixel(system, J_r, TwistsOf(system, J_r), points);
      if (std::isinf(expected)) {
        EXPECT_EQ(worst, expected) << k << "x" << n;
      } else {
        EXPECT_NEAR(worst, expected, 1e-9 * expected) << k << "x" << n;
      }
    }
  }
}

TEST(Volume, IsTheProductOfTheSingularValues) {
  std::mt19937 random(45);
  for (int rows = 1; rows <= 16; ++rows) {
    for (int columns = 1; columns <= 16; ++columns) {
      const MatrixXd J = 300.0 * RandomMatrix(&random, rows, columns);
      const Measure measure = MeasureOf(J, 16);
      const Volume volume = VolumeOf(J);
      EXPECT_EQ(volume.status, MeasureStatus::kOk);
      EXPECT_NEAR(volume.w, measure.w, 1e-11 * measure.condition * measure.w);
      EXPECT_NEAR(volume.log_w, measure.log_w, 1e-11 * measure.condition);
      EXPECT_EQ(volume.rank, measure.rank);
    }
  }
}

TEST(Volume, OfALostDirectionIsZeroAndOfNoNumberNothing) {
  std::mt19937 random(46);
  const MatrixXd J = RandomMatrix(&random, 6, 3) * RandomMatrix(&random, 3, 6);
  EXPECT_EQ(VolumeOf(J).rank, 3);
  EXPECT_LT(VolumeOf(J).w, 1e-40);
  EXPECT_EQ(VolumeOf(MatrixXd(0, 6)).status, MeasureStatus::kEmpty);
  MatrixXd bad = RandomMatrix(&random, 6, 6);
  bad(3, 2) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(VolumeOf(bad).status, MeasureStatus::kNotFinite);
  EXPECT_EQ(VolumeOf(bad).w, 0.0);
  EXPECT_EQ(VolumeOf(bad).log_w, -kInfinity);
}

// Pivots of 1 and 1, or rows of which enough is left, say nothing of the rank; a wider tolerance is heeded.
TEST(Volume, KnowsTheRankOfMatricesWhosePivotsHideIt) {
  MatrixXd J(2, 2);
  J << 1.0, 1.0, 1e6, 1e6 + 1.0;
  EXPECT_EQ(VolumeOf(J).rank, 1);
  EXPECT_EQ(VolumeOf(J.transpose()).rank, 1);
  MatrixXd wide = MatrixXd::Zero(3, 4);
  wide.row(0) << 1.0, 0.0, 0.0, 0.0;
  wide.row(1) << 1e5, 1.0, 0.0, 0.0;
  wide.row(2) << 0.0, 1e5, 1.0, 0.0;
  EXPECT_EQ(VolumeOf(wide).rank, MeasureOf(wide).rank);
  const MatrixXd plain = Eigen::Vector3d(1.0, 1.0, 0.05).asDiagonal();
  EXPECT_EQ(VolumeOf(plain).rank, 3);
  EXPECT_EQ(VolumeOf(plain, 0.1).rank, 2);
}

// The self-motion of a redundant arm moves no point on the end effector: it hides nothing.
TEST(WorstMillimetresPerPixel, SelfMotionOfARedundantArmCostsNothing) {
  std::mt19937 random(41);
  const ArmJacobian J_r = RandomMatrix(&random, 6, 7);
  const MatrixXd J_c = RandomMatrix(&random, 8, 6) * J_r;
  const double worst =
      WorstMillimetresPerPixel(Decompose(J_c), {PointJacobianOf(J_r, Vector3d(0.1, 0.0, 0.2))});
  EXPECT_GT(worst, 0.0);
  EXPECT_LT(worst, 1e6);
}

TEST(Measures, DoNotAllocate) {
  if (!test::AllocationGuard::kSupported) GTEST_SKIP();
  std::mt19937 random(42);
  const FeatureJacobian J_v = RandomMatrix(&random, 8, 6);
  const ArmJacobian J_r = RandomMatrix(&random, 6, 7);
  const std::vector<PointJacobian> points(4, PointJacobianOf(J_r, Vector3d(0.1, 0.0, 0.2)));
  const Eigen::Matrix<double, 8, 8> C = Eigen::Matrix<double, 8, 8>::Identity();
  const JointVector ones = JointVector::Ones(7);

  const test::AllocationGuard guard;
  TaskJacobian J_c = J_v * J_r;
  const Measure view = MeasureOf(J_v);
  const Measure arm = MeasureOf(J_r);
  const SingularSystem composite = Decompose(J_c);
  const SingularSystem wide = Decompose(J_r);
  const Measure block = MeasureOf(J_c.topRows(3));
  const PseudoInverseMatrix P = PseudoInverse(composite);
  const PseudoInverseMatrix E = EllipsoidMatrix(composite);
  const double volume = EllipsoidVolume(composite.measure);
  const ErrorBounds bounds = BoundErrors(composite.measure, 8, 7);
  const Coupling coupling = CouplingOf(view, arm, composite.measure);
  const LowCause cause = DiagnoseLowMeasure(composite, points, 6, true);
  const LogGradient gradient = GradientOfLog(composite);
  const double worst = WorstMillimetresPerPixel(composite, points);
  const double length = CharacteristicLength(J_r);
  const Measure scaled = MeasureOf(ScaleTwistOfArm(J_r, length));
  const bool white = Whiten(C, &J_c);
  const Measure joints = MeasureOf(ScaleJoints(J_c, ones));
  EXPECT_EQ(guard.count(), 0u);

  EXPECT_TRUE(white);
  EXPECT_EQ(P.rows() + E.rows(), 15);
  EXPECT_EQ(wide.axes.cols() + block.size() + scaled.size(), 15);
  EXPECT_NEAR(joints.w, composite.measure.w, 1e-12 * joints.w);
  EXPECT_GT(volume * bounds.upper * coupling.ratio * worst, 0.0);
  EXPECT_EQ(cause, LowCause::kArm);  // one and the same point moves in three directions, not six
  EXPECT_EQ(gradient.status, GradientStatus::kOk);
}

}  // namespace
}  // namespace vantage
