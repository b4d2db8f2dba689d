#include "singular_values_impl.h"

namespace vantage {

const SingularKernels& BaselineSingularKernels() noexcept {
  static constexpr SingularKernels kKernels = MakeSingularKernels<2>();
  return kKernels;
}

}  // namespace vantage
