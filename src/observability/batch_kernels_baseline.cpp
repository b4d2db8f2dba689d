#include "batch_kernels_impl.h"

namespace vantage::batch {

const KernelTable& BaselineKernels() {
  static constexpr KernelTable kTable = MakeTable<xsimd::default_arch>();
  return kTable;
}

}  // namespace vantage::batch
