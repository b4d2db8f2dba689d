#pragma once

/// @file
/// Loops over vertices are compiled for vectors of 128, 256 and 512 bits, and the processor's are chosen at run time.
/// Without fused operations the results are the same to the bit. Sanitisers are not at work yet when the choice is made, and
/// clang wants the attribute at a member's first declaration: they make do with the vectors of the build.

#if defined(__x86_64__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)
// NOLINTNEXTLINE(cppcoreguidelines-macro-usage): an attribute has no other name.
#define VANTAGE_CLONED __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define VANTAGE_CLONED
#endif
