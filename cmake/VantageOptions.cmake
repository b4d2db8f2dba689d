# Build options, warnings and sanitizers of every target of the project.
option(VANTAGE_BUILD_BENCH "Build the benchmark programs (Google Benchmark)" OFF)
find_package(MPI QUIET COMPONENTS CXX)
option(VANTAGE_WITH_MPI "Build vantage-plan-mpi, whose sweeps run under mpirun" ${MPI_CXX_FOUND})
set(VANTAGE_SANITIZE "" CACHE STRING "Sanitizers of the build: empty, address,undefined or thread")

# Every compiler warns of something new, some of it wrongly: only the one that is worked with is strict.
set(strict OFF)
if(CMAKE_CXX_COMPILER_ID STREQUAL GNU AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
  set(strict ON)
endif()
option(VANTAGE_WERROR "Warnings are errors" ${strict})

add_library(vantage_warnings INTERFACE)
target_compile_options(vantage_warnings INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion -Wnon-virtual-dtor $<$<BOOL:${VANTAGE_WERROR}>:-Werror>)

if(VANTAGE_SANITIZE)
  add_compile_options(-fsanitize=${VANTAGE_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  add_link_options(-fsanitize=${VANTAGE_SANITIZE})
  # GCC warns of each fence, which its ThreadSanitizer does not know: readerwriterqueue's (tests/apps/tsan_suppressions.txt).
  if(VANTAGE_SANITIZE STREQUAL "thread" AND CMAKE_CXX_COMPILER_ID STREQUAL GNU)
    add_compile_options(-Wno-tsan)
  endif()
endif()
