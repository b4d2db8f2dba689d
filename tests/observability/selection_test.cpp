#include "vantage/observability/selection.h"

#include <algorithm>
#include <limits>
#include <random>

#include <Eigen/SVD>
#include <gtest/gtest.h>

namespace vantage {
namespace {

using Eigen::MatrixXd;
using Rows = std::vector<int>;

// Rows as point features have them: some lie far from the axis and say much, some little.
TaskJacobian RandomCandidates(std::mt19937* random, int m, int n) {
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> size(0.1, 1.0);
  TaskJacobian J(m, n);
  for (int i = 0; i < m; ++i) {
    const double scale = size(*random);
    for (int j = 0; j < n; ++j) J(i, j) = scale * normal(*random);
  }
  return J;
}

// The criterion by another route.
double ValueBySvd(const TaskJacobian& J, const Rows& rows, SelectionCriterion criterion) {
  MatrixXd chosen(rows.size(), J.cols());
  for (std::size_t i = 0; i < rows.size(); ++i) chosen.row(i) = J.row(rows[i]);
  const Eigen::VectorXd sigma = Eigen::JacobiSVD<MatrixXd>(chosen).singularValues();
  const Eigen::Index s = std::min<Eigen::Index>(6, sigma.size());
  if (criterion == SelectionCriterion::kW) return sigma.head(s).prod();
  if (criterion == SelectionCriterion::kSigmaMin) return sigma(s - 1);
  return 1.0 / sigma.head(s).array().square().inverse().sum();
}

// Every set of k of m, as bits.
template <typename Use>
void ForEverySet(int m, int k, Use&& use) {
  for (unsigned bits = 0; bits < 1U << m; ++bits) {
    Rows rows;
    for (int i = 0; i < m; ++i) {
      if ((bits >> i & 1U) != 0) rows.push_back(i);
    }
    if (static_cast<int>(rows.size()) == k) use(rows);
  }
}

constexpr SelectionCriterion kAll[] = {SelectionCriterion::kW, SelectionCriterion::kSigmaMin,
                                       SelectionCriterion::kTrace};

TEST(SelectFeatures, FindsTheBestOfAllSets) {
  std::mt19937 random(71);
  for (const SelectionCriterion criterion : kAll) {
    for (const auto& [m, n, k] : {std::array{9, 6, 6}, std::array{8, 3, 2}, std::array{8, 7, 7},
                                  std::array{10, 6, 8}, std::array{5, 6, 5}, std::array{6, 2, 1}}) {
      const TaskJacobian J = RandomCandidates(&random, m, n);
      SelectionOptions options;
      options.criterion = criterion;
      const Selection selection = SelectFeatures({J}, k, options);
      ASSERT_EQ(selection.status, SelectionStatus::kOk);
      EXPECT_TRUE(selection.exhaustive);
      double best = 0.0;
      std::int64_t sets = 0;
      Rows best_rows;
      ForEverySet(m, k, [&](const Rows& rows) {
        ++sets;
        const double value = ValueBySvd(J, rows, criterion);
        if (value > best) {
          best = value;
          best_rows = rows;
        }
      });
      EXPECT_EQ(selection.rows, best_rows);
      EXPECT_NEAR(selection.value, best, 1e-9 * best);
      EXPECT_EQ(selection.sets, sets);
    }
  }
}

// Exchange, where all sets can be tried too: how often is it as good, and how bad when it is not?
TEST(SelectFeatures, ExchangeIsAsGoodAsTryingAll) {
  std::mt19937 random(72);
  for (const SelectionCriterion criterion : kAll) {
    int found = 0;
    double worst = 1.0;
    constexpr int kTrials = 60;
    for (int trial = 0; trial < kTrials; ++trial) {
      const int k = 5 + trial % 4;
      const TaskJacobian J = RandomCandidates(&random, 14, 6);
      SelectionOptions options;
      options.criterion = criterion;
      const Selection all = SelectFeatures({J}, k, options);
      options.exhaustive_limit = 0;
      const Selection exchange = SelectFeatures({J}, k, options);
      ASSERT_EQ(exchange.status, SelectionStatus::kOk);
      EXPECT_FALSE(exchange.exhaustive);
      EXPECT_EQ(static_cast<int>(exchange.rows.size()), k);
      EXPECT_LT(exchange.sets, all.sets * 3);
      EXPECT_LE(exchange.value, all.value * (1.0 + 1e-9));
      found += exchange.value >= all.value * (1.0 - 1e-9) ? 1 : 0;
      worst = std::min(worst, exchange.value / all.value);
    }
    EXPECT_GE(found, kTrials * 95 / 100);
    EXPECT_GE(worst, 0.8);
  }
}

// 32 candidates, of which 16: 6e8 sets.
TEST(SelectFeatures, ExchangeTakesWhatIsTooManyToTry) {
  std::mt19937 random(73);
  const TaskJacobian J = RandomCandidates(&random, 32, 6);
  const Selection selection = SelectFeatures({J}, 16);
  ASSERT_EQ(selection.status, SelectionStatus::kOk);
  EXPECT_FALSE(selection.exhaustive);
  EXPECT_TRUE(std::is_sorted(selection.rows.begin(), selection.rows.end()));
  EXPECT_LT(selection.sets, 200000);
  // No swap of one row helps.
  for (const int out : selection.rows) {
    for (int in = 0; in < 32; ++in) {
      if (std::count(selection.rows.begin(), selection.rows.end(), in) != 0) continue;
      Rows swapped = selection.rows;
      std::replace(swapped.begin(), swapped.end(), out, in);
      EXPECT_LE(SelectionValue({J}, swapped), selection.value * (1.0 + 1e-9));
    }
  }
  EXPECT_LT(selection.value, selection.value_of_all);
}

// Two configurations. Rows 0 and 1 are best at the first and blind at the second, rows 2 and 3 are fair at
// both.
TEST(SelectFeatures, AlongATrajectoryMeanAndWorstDiffer) {
  TaskJacobian first(4, 2);
  first << 10, 0, 0, 10, 2, 0, 0, 2;
  TaskJacobian second(4, 2);
  second << 0, 0, 0, 0, 2, 0, 0, 2;
  SelectionOptions options;
  const Selection mean = SelectFeatures({first, second}, 2, options);
  EXPECT_EQ(mean.rows, (Rows{0, 1}));
  EXPECT_NEAR(mean.value, 50.0, 1e-12);
  options.over = SelectionOver::kWorst;
  const Selection worst = SelectFeatures({first, second}, 2, options);
  EXPECT_EQ(worst.rows, (Rows{2, 3}));
  EXPECT_NEAR(worst.value, 4.0, 1e-12);
  EXPECT_NEAR(worst.value_of_all, 4.0, 1e-12);
}

TEST(SelectFeatures, OfEqualRowsTheFirst) {
  TaskJacobian J(4, 2);
  J << 0, 1, 1, 0, 0, 1, 1, 0;
  EXPECT_EQ(SelectFeatures({J}, 2).rows, (Rows{0, 1}));
  SelectionOptions options;
  options.exhaustive_limit = 0;
  EXPECT_EQ(SelectFeatures({J}, 2, options).rows, (Rows{0, 1}));
}

TEST(SelectFeatures, NamesWhatItCannotDo) {
  std::mt19937 random(74);
  const TaskJacobian J = RandomCandidates(&random, 5, 3);
  EXPECT_EQ(SelectFeatures({}, 2).status, SelectionStatus::kEmpty);
  EXPECT_EQ(SelectFeatures({TaskJacobian(0, 3)}, 1).status, SelectionStatus::kEmpty);
  EXPECT_EQ(SelectFeatures({J}, 0).status, SelectionStatus::kBadCount);
  EXPECT_EQ(SelectFeatures({J}, 6).status, SelectionStatus::kBadCount);
  EXPECT_EQ(SelectFeatures({J, J.topRows(4)}, 2).status, SelectionStatus::kUneven);
  TaskJacobian bad = J;
  bad(1, 1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(SelectFeatures({J, bad}, 2).status, SelectionStatus::kNotFinite);
  // A joint that no feature sees: no three rows have three directions.
  TaskJacobian blind = J;
  blind.col(2).setZero();
  for (const std::int64_t limit : {0, 1000}) {
    SelectionOptions options;
    options.exhaustive_limit = limit;
    const Selection selection = SelectFeatures({blind}, 3, options);
    EXPECT_EQ(selection.status, SelectionStatus::kSingular);
    EXPECT_TRUE(selection.rows.empty());
    EXPECT_EQ(selection.value, 0.0);
  }
  EXPECT_EQ(SelectFeatures({blind}, 2).status, SelectionStatus::kOk);
}

}  // namespace
}  // namespace vantage
