#include "vantage/observability/paper_product.h"

#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "eigen_matchers.h"

namespace vantage {
namespace {

using Eigen::MatrixXd;

MatrixXd RandomMatrix(std::mt19937* random, int rows, int columns) {
  std::normal_distribution<double> normal;
  MatrixXd J(rows, columns);
  for (Eigen::Index i = 0; i < J.size(); ++i) J(i) = normal(*random);
  return J;
}

TEST(ComputePaperProduct, IsExactWhereNoFeatureSeesTheTurn) {
  std::mt19937 random(81);
  FeatureJacobian J_v = RandomMatrix(&random, 4, 6);
  const ArmJacobian J_r = RandomMatrix(&random, 6, 3);
  EXPECT_FALSE(ComputePaperProduct(J_v, J_r).exact);
  J_v.rightCols<3>().setZero();
  const PaperProduct paper = ComputePaperProduct(J_v, J_r);
  EXPECT_TRUE(paper.exact);
  EXPECT_NEAR(paper.product, MeasureOf(MatrixXd(J_v * J_r)).w, 1e-12 * paper.product);
}

TEST(ImageJacobianAlongArm, TimesTheArmIsTheComposite) {
  std::mt19937 random(82);
  const FeatureJacobian J_v = RandomMatrix(&random, 5, 6);
  const ArmJacobian J_r = RandomMatrix(&random, 6, 3);
  const AlongArm along = ImageJacobianAlongArm(J_v, J_r);
  ASSERT_EQ(along.status, AlongArmStatus::kOk);
  EXPECT_TRUE(test::Near(along.J_v * J_r.topRows<3>(), J_v * J_r, 1e-12));
}

TEST(ImageJacobianAlongArm, NamesWhatItCannotDo) {
  std::mt19937 random(83);
  const FeatureJacobian J_v = RandomMatrix(&random, 5, 6);
  const ArmJacobian J_r = RandomMatrix(&random, 6, 3);
  EXPECT_EQ(ImageJacobianAlongArm(FeatureJacobian(0, 6), J_r).status, AlongArmStatus::kEmpty);
  EXPECT_EQ(ImageJacobianAlongArm(J_v, J_r, 2).status, AlongArmStatus::kNotSquare);
  ArmJacobian lost = J_r;
  lost.topRows<3>().col(2) = lost.topRows<3>().col(0);
  EXPECT_EQ(ImageJacobianAlongArm(J_v, lost).status, AlongArmStatus::kSingular);
  FeatureJacobian bad = J_v;
  bad(1, 4) = std::numeric_limits<double>::quiet_NaN();
  const AlongArm along = ImageJacobianAlongArm(bad, J_r);
  EXPECT_EQ(along.status, AlongArmStatus::kNotFinite);
  EXPECT_EQ(along.J_v.size(), 0);
  EXPECT_EQ(along.view.size(), 0);
}

}  // namespace
}  // namespace vantage
