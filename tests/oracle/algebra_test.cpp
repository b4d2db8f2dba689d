// Measures of given matrices.
#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include "oracle_file.h"

namespace vantage::test {
namespace {

class Algebra : public ::testing::TestWithParam<Entry> {};

GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(Algebra);
INSTANTIATE_TEST_SUITE_P(Oracle, Algebra, ::testing::ValuesIn(Entries("/algebra")), NameOf);

// The note of entries whose rank is to be told by another tolerance names it.
double RankTolerance(const Node& expected) {
  const std::string note = expected.raw().value("note", "");
  return note.find("rank tolerance 1e-6*sigma_1") == std::string::npos ? kRankTolerance : 1e-6;
}

TEST_P(Algebra, MeasuresAndEllipsoid) {
  const Node& entry = GetParam().node;
  const Node expected = entry.at("expected");
  const Eigen::MatrixXd J = Matrix(entry.at("J"));
  ASSERT_EQ(J.rows(), entry.at("k").get<int>());
  ASSERT_EQ(J.cols(), entry.at("m").get<int>());
  const int task_dimension = std::max(1, static_cast<int>(J.cols()));
  const SingularSystem system = Decompose(J, task_dimension, RankTolerance(expected));
  const Measure& measure = system.measure;
  EXPECT_EQ(measure.size(), expected.at("s").get<int>());
  EXPECT_EQ(measure.rank, expected.at("rank").get<int>());
  EXPECT_TRUE(SigmaNear(measure, expected.at("singular_values")));
  EXPECT_TRUE(WNear(measure, expected.at("w").get<double>()));
  // The pseudo-inverse is good to ε cond², its norm is 1/σ_s: of well conditioned matrices all the
  // digits of a Jacobian are asked for.
  EXPECT_TRUE(JacobianNear(PseudoInverse(system), Matrix(expected.at("pinv"))));
  EXPECT_TRUE(JacobianNear(EllipsoidMatrix(system), Matrix(expected.at("ellipsoid_matrix"))));

  const bool full = measure.rank == measure.size();
  const auto volume = expected.at("volume").get<double>();
  if (full) {
    EXPECT_TRUE(RelativelyNear(EllipsoidVolume(measure), volume, kMeasureTolerance));
  } else {
    EXPECT_EQ(volume, 0.0);
    EXPECT_LE(EllipsoidVolume(measure),
              6.0 * kZeroTolerance * std::pow(measure.sigma(0), measure.size()));
  }
  const ErrorBounds bounds =
      BoundErrors(measure, static_cast<int>(J.rows()), static_cast<int>(J.cols()));
  EXPECT_TRUE(
      RelativelyNear(bounds.lower, expected.at("bound_lower").get<double>(), kMeasureTolerance));
  EXPECT_EQ(bounds.lower_needs_range, J.rows() > J.cols());
  EXPECT_EQ(bounds.upper_needs_minimum_norm, J.rows() < J.cols());
  ASSERT_EQ(expected.at("bound_upper").is_null(), !full);
  ASSERT_EQ(expected.at("cond").is_null(), !full);
  if (full) {
    EXPECT_TRUE(
        RelativelyNear(bounds.upper, expected.at("bound_upper").get<double>(), kMeasureTolerance));
    EXPECT_TRUE(
        RelativelyNear(measure.condition, expected.at("cond").get<double>(), kMeasureTolerance));
  } else {
    EXPECT_TRUE(std::isinf(bounds.upper));
    EXPECT_GT(measure.condition, 1.0 / RankTolerance(expected));
  }
  // Eq. 5 as printed, det(J Jᵀ), is 0 for more rows than columns; the other order for fewer.
  if (expected.contains("sqrt_det_JJt")) {
    EXPECT_EQ(expected.at("sqrt_det_JJt").get<double>() == 0.0, J.rows() > J.cols());
  }
  if (expected.contains("sqrt_det_JtJ")) {
    EXPECT_EQ(expected.at("sqrt_det_JtJ").get<double>() == 0.0, J.cols() > J.rows());
  }
  for (const char* name : {"sqrt_det_JJt", "sqrt_det_JtJ"}) {
    if (!expected.contains(name) || expected.at(name).get<double>() == 0.0) continue;
    EXPECT_TRUE(RelativelyNear(measure.w, expected.at(name).get<double>(), kMeasureTolerance))
        << name;
  }
}

class CompositeAlgebra : public ::testing::TestWithParam<Entry> {};

GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(CompositeAlgebra);
INSTANTIATE_TEST_SUITE_P(Oracle, CompositeAlgebra,
                         ::testing::ValuesIn(Entries("/composite_algebra")), NameOf);

TEST_P(CompositeAlgebra, ProductRuleAndHornsBound) {
  const Node& entry = GetParam().node;
  const Node expected = entry.at("expected");
  const Eigen::MatrixXd J_v = Matrix(entry.at("J_v"));
  const Eigen::MatrixXd J_r = Matrix(entry.at("J_r"));
  const int k = entry.at("k").get<int>();
  const int m = entry.at("m").get<int>();
  const int n = entry.at("n").get<int>();
  ASSERT_EQ(J_v.rows(), k);
  ASSERT_EQ(J_v.cols(), m);
  ASSERT_EQ(J_r.rows(), m);
  ASSERT_EQ(J_r.cols(), n);
  const Measure view = MeasureOf(J_v, m);
  const Measure arm = MeasureOf(J_r, m);
  const Measure composite = MeasureOf(Eigen::MatrixXd(J_v * J_r), m);
  EXPECT_EQ(composite.size(), expected.at("s").get<int>());
  EXPECT_TRUE(WNear(view, expected.at("w_v").get<double>()));
  EXPECT_TRUE(WNear(arm, expected.at("w_r").get<double>()));
  EXPECT_TRUE(WNear(composite, expected.at("w_c").get<double>()));

  const Coupling coupling = CouplingOf(view, arm, composite);
  EXPECT_TRUE(
      RelativelyNear(coupling.ratio, expected.at("ratio").get<double>(), kMeasureTolerance));
  const bool holds = expected.at("product_rule_holds").get<bool>();
  EXPECT_EQ(m <= std::min(k, n), holds);
  EXPECT_EQ(std::abs(coupling.ratio - 1.0) <= kMeasureTolerance, holds);
  EXPECT_TRUE(RelativelyNear(composite.w / coupling.horn, expected.at("upper_bound").get<double>(),
                             kMeasureTolerance));
  EXPECT_LE(coupling.horn, 1.0);
}

}  // namespace
}  // namespace vantage::test
