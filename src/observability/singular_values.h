#pragma once

#include "vantage/math/capacity.h"

/// @file
/// Singular values of small matrices on storage of fixed size. The kernels are compiled once for each
/// instruction set and the best that the machine runs is chosen at run time: so nothing here may bring
/// inline code that the linker could choose for the rest of the program (no Eigen, no containers).

namespace vantage {

/// A tall matrix (rows >= columns), row by row: what is done to all columns of a row is done in lanes.
struct TallMatrix {
  static constexpr int kMaxColumns = kMaxJoints;
  static constexpr int kLanes = 8;  ///< Of the widest registers.
  int rows{0};                      ///< At most kMaxRows.
  int columns{0};                   ///< At most kMaxColumns and rows.
  /// row[i][j]; from `columns` to the next multiple of kLanes the entries are 0.
  alignas(64) double row[kMaxRows][kMaxColumns];
};

/// Singular values and right singular vectors of a tall matrix.
struct RightSystem {
  double sigma[TallMatrix::kMaxColumns];  ///< Descending; `columns` of them.
  /// vector[i][j]: entry j of v_i. Where σ_i is 0 the vector may be 0.
  alignas(64) double vector[TallMatrix::kMaxColumns][TallMatrix::kMaxColumns];
};

/// A matrix of few rows, column by column, each in the lanes of few registers.
struct ShortMatrix {
  static constexpr int kMaxRows = 8;
  static constexpr int kMaxColumns = 8;
  int columns{0};
  /// column[j][i]; rows from the matrix' own to kMaxRows are 0.
  alignas(64) double column[kMaxColumns][kMaxRows];
};

/// What is near the singular system that is looked for, and what was found.
struct NearSystem {
  /// In: near v_i, nearly orthonormal. Out: v_i. vector[i][j] is entry j; from `columns` on 0.
  alignas(64) double vector[ShortMatrix::kMaxColumns][ShortMatrix::kMaxRows];
  /// Out: σ_i u_i.
  alignas(64) double image[ShortMatrix::kMaxColumns][ShortMatrix::kMaxRows];
  double sigma[ShortMatrix::kMaxColumns];  ///< Out, descending.
};

/// One-sided Jacobi rotations on A times the given vectors: from those of a similar matrix two or three sweeps
/// do, of small rotations, and no triangle is needed. The result is as exact as SolveRightSystem()'s
/// whatever the vectors are.
///
/// @return false when the vectors are not nearly orthonormal or too many sweeps are needed: *system is then
///   of no use.
/// @pre as SolveRightSystem(); columns are at most the rows of A.
/// Real-time safe.
[[nodiscard]] bool SolveNear(const ShortMatrix& A, NearSystem* system) noexcept;

/// One-sided Jacobi rotations on the transposed triangle of a QR decomposition with column pivoting: the
/// triangle's rows are nearly orthogonal and sorted, so that three or four sweeps do.
///
/// @param A  Overwritten.
/// @pre every entry is finite and at most 1e150 in size.
/// @see Z. Drmač, K. Veselić, "New fast and accurate Jacobi SVD algorithm I", SIAM J. Matrix Anal. Appl.
///   29(4), 2008.
/// Real-time safe.
void SolveRightSystem(TallMatrix* A, RightSystem* system) noexcept;

/// Moduli of the diagonal of the triangle of a QR decomposition with column pivoting, `columns` of them:
/// their product is that of the singular values. A fraction of SolveRightSystem()'s time.
///
/// @param A  Overwritten. @pre as above.
/// Real-time safe.
void TriangleDiagonal(TallMatrix* A, double diagonal[TallMatrix::kMaxColumns]) noexcept;

/// What one instruction set offers.
struct SingularKernels {
  void (*solve)(TallMatrix* A, RightSystem* system) noexcept;
  void (*diagonal)(TallMatrix* A, double* diagonal) noexcept;
  bool (*near)(const ShortMatrix& A, NearSystem* system) noexcept;
};
[[nodiscard]] const SingularKernels& BaselineSingularKernels() noexcept;
#ifdef VANTAGE_BATCH_X86
[[nodiscard]] const SingularKernels& Avx2SingularKernels() noexcept;
[[nodiscard]] const SingularKernels& Avx512SingularKernels() noexcept;
#endif

}  // namespace vantage
