# cmake -DPROGRAM= -DWRITE_CORPUS= -DWORK= -DRUNS= [-DSECONDS=] -P run_fuzzer.cmake
#
# Runs a fuzz target from a fresh corpus: RUNS inputs from a fixed seed, or SECONDS from any.
cmake_minimum_required(VERSION 3.25)
file(REMOVE_RECURSE ${WORK})
file(MAKE_DIRECTORY ${WORK}/decode_fuzz ${WORK}/tcpq_fuzz)
execute_process(COMMAND ${WRITE_CORPUS} ${WORK}/decode_fuzz ${WORK}/tcpq_fuzz COMMAND_ERROR_IS_FATAL ANY)
cmake_path(GET PROGRAM FILENAME name)
if(DEFINED SECONDS)
  set(bound -max_total_time=${SECONDS})
else()
  set(bound -runs=${RUNS} -seed=1)
endif()
execute_process(
  COMMAND ${PROGRAM} ${bound} -max_len=4096 -rss_limit_mb=1024 -malloc_limit_mb=64 -timeout=10 -print_final_stats=1
          -artifact_prefix=${WORK}/ ${WORK}/${name}
  RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
string(REGEX MATCHALL "stat::[^\n]+" statistics "${output}")
list(JOIN statistics "\n" statistics)
message("${name}\n${statistics}")
if(NOT result EQUAL 0)
  message("${output}")
  message(FATAL_ERROR "${name} found an input that breaks it: see ${WORK}")
endif()
