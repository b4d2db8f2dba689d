#include "vantage/observability/paper_product.h"

#include <cassert>

namespace vantage {
namespace {

using TranslationRows =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, 3, kMaxJoints>;

// Entries of two Jacobians are the same when they differ by less than this share of the largest.
constexpr double kSame = 1e-11;

}  // namespace

PaperProduct ComputePaperProduct(const FeatureJacobian& J_v, const ArmJacobian& J_r,
                                 int dimension) noexcept {
  assert(dimension >= 1 && dimension <= 3);
  const TranslationRows arm = J_r.topRows(dimension);
  PaperProduct result;
  result.J_v = J_v.leftCols(dimension);
  result.view = MeasureOf(result.J_v, dimension);
  result.arm = MeasureOf(arm, dimension);
  result.product = result.view.w * result.arm.w;
  if (result.view.status == MeasureStatus::kOk && result.arm.status == MeasureStatus::kOk) {
    const TaskJacobian J_c = J_v.lazyProduct(J_r);
    const TaskJacobian rest = J_c - result.J_v.lazyProduct(arm);
    result.exact = rest.cwiseAbs().maxCoeff() <= kSame * J_c.cwiseAbs().maxCoeff();
  }
  return result;
}

AlongArm ImageJacobianAlongArm(const FeatureJacobian& J_v, const ArmJacobian& J_r,
                               int dimension) noexcept {
  assert(dimension >= 1 && dimension <= 3);
  AlongArm result;
  result.J_v.resize(0, 0);
  result.view = MeasureOf(result.J_v, dimension);
  if (J_v.rows() == 0) return result;
  if (J_r.cols() != dimension) {
    result.status = AlongArmStatus::kNotSquare;
    return result;
  }
  const TranslationRows arm = J_r.topRows(dimension);
  const SingularSystem system = Decompose(arm, dimension);
  if (system.measure.status != MeasureStatus::kOk || !J_v.allFinite() || !J_r.allFinite()) {
    result.status = AlongArmStatus::kNotFinite;
    return result;
  }
  if (system.measure.rank < dimension) {
    result.status = AlongArmStatus::kSingular;
    return result;
  }
  const TaskJacobian J_c = J_v.lazyProduct(J_r);
  result.J_v = J_c.lazyProduct(PseudoInverse(system));
  result.view = MeasureOf(result.J_v, dimension);
  result.status = AlongArmStatus::kOk;
  return result;
}

}  // namespace vantage
