#pragma once

#include "vantage/math/sizes.h"
#include "vantage/observability/measures.h"

/// @file
/// The product w_v w_r of the paper's two examples (sections 6 and 7), which leave the end effector's
/// rotation out. It is the composite w_c only where no feature depends on that rotation: it is offered
/// under this name beside the exact w_c, and never instead of it.

namespace vantage {

/// k×m image Jacobian of the translation of E's origin, m <= 3.
using TranslationJacobian =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMaxRows, 3>;

/// Translation-only measures of an arm that is to place a point.
struct PaperProduct {
  TranslationJacobian J_v;  ///< k×m: ∂v/∂(position of E's origin) [1/m], its orientation frozen.
  Measure view;             ///< Of J_v: the paper's w_v.
  Measure arm;              ///< Of the first m rows of J_r: the paper's w_r.
  double product{0.0};      ///< w_v w_r; 0 where one of them could not be measured.
  /// J_v times those rows of J_r is J_c: what the features see of the motion is all translation. With
  /// m <= min(k, n) the product is w_c then.
  bool exact{false};
};

/// @param dimension  m: 3 for arms in space, 2 for planar ones (axes x and y of W).
/// @pre dimension is 1, 2 or 3.
/// Real-time safe.
[[nodiscard]] PaperProduct ComputePaperProduct(const FeatureJacobian& J_v, const ArmJacobian& J_r,
                                               int dimension = 3) noexcept;

/// What became of an image Jacobian along the arm's motions.
enum class AlongArmStatus : int {
  kOk = 0,
  kEmpty = 1,      ///< No rows.
  kNotSquare = 2,  ///< The arm has more or fewer joints than m.
  kSingular = 3,   ///< The arm cannot move E's origin in all m directions.
  kNotFinite = 4,  ///< An entry is NaN or infinite.
};

/// Image Jacobian along the motions the arm can make: J_c inv(first m rows of J_r), k×m. Its w_v times
/// w_r is w_c for every k: the exact counterpart of the paper's J_v, since the end effector turns as its
/// origin moves.
struct AlongArm {
  AlongArmStatus status{AlongArmStatus::kEmpty};  ///< kOk: J_v and its measure have a meaning.
  TranslationJacobian J_v;                        ///< 0×0 where the status is not kOk.
  Measure view;                                   ///< Of J_v: w_v.
};

/// @pre dimension is 1, 2 or 3; J_v is k×6.
/// Real-time safe.
[[nodiscard]] AlongArm ImageJacobianAlongArm(const FeatureJacobian& J_v, const ArmJacobian& J_r,
                                             int dimension = 3) noexcept;

}  // namespace vantage
