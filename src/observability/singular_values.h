#pragma once

#include <array>

#include "vantage/math/sizes.h"

/// @file
/// Singular values of small matrices on storage of fixed size.

namespace vantage {

/// A tall matrix (rows >= columns) in columns of fixed stride.
struct TallMatrix {
  static constexpr int kMaxColumns = kMaxJoints;
  int rows{0};     ///< At most kMaxRows.
  int columns{0};  ///< At most kMaxColumns and rows.
  alignas(16) double column[kMaxColumns][kMaxRows];
};

/// Singular values and right singular vectors of a tall matrix.
struct RightSystem {
  std::array<double, TallMatrix::kMaxColumns> sigma;  ///< Descending; `columns` of them.
  /// vector[i][j]: entry j of v_i. Where σ_i is 0 the vector may be 0.
  alignas(16) double vector[TallMatrix::kMaxColumns][TallMatrix::kMaxColumns];
};

/// One-sided Jacobi rotations on the transposed triangle of a QR decomposition with column pivoting: the
/// triangle's rows are nearly orthogonal and sorted, so that three or four sweeps do.
///
/// @param A  Overwritten.
/// @pre every entry is finite and at most 1e150 in size.
/// @see Z. Drmač, K. Veselić, "New fast and accurate Jacobi SVD algorithm I", SIAM J. Matrix Anal. Appl.
///   29(4), 2008.
/// Real-time safe.
void SolveRightSystem(TallMatrix* A, RightSystem* system) noexcept;

}  // namespace vantage
