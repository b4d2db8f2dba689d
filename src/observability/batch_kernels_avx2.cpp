#include "batch_kernels_impl.h"

namespace vantage::batch {

const KernelTable& Avx2Kernels() {
  static constexpr KernelTable kTable = MakeTable<xsimd::fma3<xsimd::avx2>>();
  return kTable;
}

}  // namespace vantage::batch
