#include "batch_kernels_impl.h"

namespace vantage::batch {

const KernelTable& Avx512Kernels() {
  static constexpr KernelTable kTable = MakeTable<xsimd::avx512f>();
  return kTable;
}

}  // namespace vantage::batch
