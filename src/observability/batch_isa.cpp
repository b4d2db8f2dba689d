#include "vantage/observability/batch.h"

namespace vantage {

std::vector<BatchIsa> AvailableIsas() {
  std::vector<BatchIsa> isas{BatchIsa::kBaseline};
#ifdef VANTAGE_BATCH_X86
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) {
    isas.push_back(BatchIsa::kAvx2);
  }
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512cd") &&
      __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx2") &&
      __builtin_cpu_supports("fma")) {
    isas.push_back(BatchIsa::kAvx512);
  }
#endif
  return isas;
}

std::string Name(BatchIsa isa) {
  switch (isa) {
    case BatchIsa::kAvx512:
      return "AVX-512";
    case BatchIsa::kAvx2:
      return "AVX2";
    case BatchIsa::kBaseline:
      break;
  }
#ifdef VANTAGE_BATCH_X86
  return "SSE2";
#else
  return "baseline";
#endif
}

}  // namespace vantage
