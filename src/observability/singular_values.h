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

/// A tall matrix of few columns, column by column, each in the lanes of few registers.
struct ColumnMatrix {
  static constexpr int kMaxColumns = 6;
  int rows{0};     ///< At most kMaxRows.
  int columns{0};  ///< At most kMaxColumns and rows.
  /// column[j][i]; from `rows` to the next of 8, 16 and kMaxRows the entries are 0.
  alignas(64) double column[kMaxColumns][kMaxRows];
};

/// Number of rows in use of a ColumnMatrix and of the images of its NearSystem, zeros included.
[[nodiscard]] constexpr int PaddedRows(int rows) noexcept {
  return rows <= 8 ? 8 : (rows <= 16 ? 16 : kMaxRows);
}

/// What is near the singular system that is looked for, and what was found.
struct NearSystem {
  static constexpr int kMaxColumns = ColumnMatrix::kMaxColumns;
  static constexpr int kVectorRows = 8;  ///< Columns and zeros.
  /// In: near v_i, nearly orthonormal. Out: v_i. vector[i][j] is entry j; from `columns` on 0.
  alignas(64) double vector[kMaxColumns][kVectorRows];
  /// Out: σ_i u_i.
  alignas(64) double image[kMaxColumns][kMaxRows];
  double sigma[kMaxColumns];  ///< Out, descending.
};

/// One-sided Jacobi rotations on A times the given vectors: from those of a similar matrix two or three sweeps
/// do, of small rotations, and no triangle is needed. The result is as exact as SolveRightSystem()'s
/// whatever the vectors are.
///
/// @return false when the vectors are not nearly orthonormal or too many sweeps are needed: *system is then
///   of no use.
/// @pre as SolveRightSystem().
/// Real-time safe.
[[nodiscard]] bool SolveNear(const ColumnMatrix& A, NearSystem* system) noexcept;

/// The rows of a wide matrix in an orthonormal basis of their span.
struct RowBasis {
  static constexpr int kMaxVectors = 6;
  int rows{0};     ///< At most kMaxVectors and columns.
  int columns{0};  ///< At most kMaxJoints.
  /// In: the matrix, row by row, zeros from `columns` on. Out: q_i.
  alignas(64) double vector[kMaxVectors][kMaxJoints];
  double part[kMaxVectors][kMaxVectors];  ///< Out: row i is the sum over j <= i of part[i][j] q_j.
};

/// Gram-Schmidt orthogonalisation, each row twice: orthonormal to rounding.
///
/// @return false where a row is hardly more than a sum of those before it: *basis is then of no use.
/// @pre every entry is finite and at most 1e150 in size.
/// Real-time safe.
[[nodiscard]] bool FindRowBasis(RowBasis* basis) noexcept;

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

/// Moduli of the pivots of Gaussian elimination with pivoting by rows of a square matrix, `columns` of them: the
/// product is that of the singular values. A third of TriangleDiagonal()'s time, but the pivots do not tell the
/// rank.
///
/// @param A  Overwritten. @pre rows == columns <= TallMatrix::kLanes; entries as above.
/// Real-time safe.
void Pivots(TallMatrix* A, double pivots[TallMatrix::kLanes]) noexcept;

/// What one instruction set offers.
struct SingularKernels {
  void (*solve)(TallMatrix* A, RightSystem* system) noexcept;
  void (*diagonal)(TallMatrix* A, double* diagonal) noexcept;
  bool (*near)(const ColumnMatrix& A, NearSystem* system) noexcept;
  void (*pivots)(TallMatrix* A, double* pivots) noexcept;
  bool (*row_basis)(RowBasis* basis) noexcept;
};
[[nodiscard]] const SingularKernels& BaselineSingularKernels() noexcept;
#ifdef VANTAGE_BATCH_X86
[[nodiscard]] const SingularKernels& Avx2SingularKernels() noexcept;
[[nodiscard]] const SingularKernels& Avx512SingularKernels() noexcept;
#endif

}  // namespace vantage
