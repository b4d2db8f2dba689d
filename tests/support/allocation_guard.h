#pragma once

#include <cstddef>

/// @file
/// Counts heap allocations of this thread. Link vantage_test_allocation (allocation_guard.cpp replaces
/// operator new and malloc's front ends) into tests that use it.

namespace vantage::test {

/// Allocations by this thread since the guard was made.
class AllocationGuard {
 public:
  AllocationGuard() noexcept;
  [[nodiscard]] std::size_t count() const noexcept;

  /// False under sanitizers, which own the allocator.
  static const bool kSupported;

 private:
  std::size_t start_;
};

}  // namespace vantage::test
