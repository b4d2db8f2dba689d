#include "singular_values.h"

#include "vantage/observability/batch.h"

namespace vantage {
namespace {

const SingularKernels& BestKernels() noexcept {
#ifdef VANTAGE_BATCH_X86
  const BatchIsa isa = AvailableIsas().back();
  if (isa == BatchIsa::kAvx512) return Avx512SingularKernels();
  if (isa == BatchIsa::kAvx2) return Avx2SingularKernels();
#endif
  return BaselineSingularKernels();
}

// Before main(): the control period must not be the first to ask.
const SingularKernels& kernels = BestKernels();

}  // namespace

void SolveRightSystem(TallMatrix* A, RightSystem* system) noexcept {
  kernels.solve(A, system);
}

bool SolveNear(const ColumnMatrix& A, NearSystem* system) noexcept {
  return kernels.near(A, system);
}

void TriangleDiagonal(TallMatrix* A, double diagonal[TallMatrix::kMaxColumns]) noexcept {
  kernels.diagonal(A, diagonal);
}

void Pivots(TallMatrix* A, double pivots[TallMatrix::kLanes]) noexcept {
  kernels.pivots(A, pivots);
}

bool FindRowBasis(RowBasis* basis) noexcept {
  return kernels.row_basis(basis);
}

}  // namespace vantage
