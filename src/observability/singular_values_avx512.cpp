#include "singular_values_impl.h"

namespace vantage {

const SingularKernels& Avx512SingularKernels() noexcept {
  static constexpr SingularKernels kKernels = MakeSingularKernels<8>();
  return kKernels;
}

}  // namespace vantage
