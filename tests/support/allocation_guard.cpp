#include "allocation_guard.h"

#include <cstdlib>

// glibc's own names for the allocator: the replacements below count and pass on. Eigen calls malloc,
// C++ calls operator new, which calls malloc: one count covers both.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define VANTAGE_COUNTS_ALLOCATIONS 0
#else
#define VANTAGE_COUNTS_ALLOCATIONS 1
#endif

namespace {
thread_local std::size_t allocations = 0;
}

#if VANTAGE_COUNTS_ALLOCATIONS
extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);

void* malloc(std::size_t size) {
  ++allocations;
  return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) {
  ++allocations;
  return __libc_calloc(count, size);
}
void* realloc(void* old, std::size_t size) {
  ++allocations;
  return __libc_realloc(old, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  ++allocations;
  return __libc_memalign(alignment, size);
}
}
#endif

namespace vantage::test {

const bool AllocationGuard::kSupported = VANTAGE_COUNTS_ALLOCATIONS != 0;

AllocationGuard::AllocationGuard() noexcept : start_(allocations) {}

std::size_t AllocationGuard::count() const noexcept {
  return allocations - start_;
}

}  // namespace vantage::test
