#pragma once

#include <cstddef>

/// @file
/// Measures the heap memory that operator new hands to this thread, under sanitizers too. Link
/// allocation_meter.cpp, which replaces operator new and delete.

namespace vantage::test {

/// Starts counting from zero.
void ResetAllocated() noexcept;
/// Bytes handed out since then, all allocations added up.
[[nodiscard]] std::size_t Allocated() noexcept;

}  // namespace vantage::test
