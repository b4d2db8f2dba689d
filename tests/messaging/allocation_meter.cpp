#include "allocation_meter.h"

#include <cstdlib>
#include <new>

namespace {
thread_local std::size_t allocated = 0;
}

void* operator new(std::size_t size) {
  allocated += size;
  if (void* memory = std::malloc(size > 0 ? size : 1)) return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}

namespace vantage::test {

void ResetAllocated() noexcept {
  allocated = 0;
}
std::size_t Allocated() noexcept {
  return allocated;
}

}  // namespace vantage::test
