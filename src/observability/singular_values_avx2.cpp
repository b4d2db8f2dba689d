#include "singular_values_impl.h"

namespace vantage {

const SingularKernels& Avx2SingularKernels() noexcept {
  static constexpr SingularKernels kKernels = MakeSingularKernels<4>();
  return kKernels;
}

}  // namespace vantage
