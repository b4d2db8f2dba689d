# vantage_add_module(<name> SOURCES <file>... [DEPENDS <target>...] [PRIVATE_DEPENDS <target>...])
#
# Static library vantage_<name> (alias vantage::<name>). DEPENDS is the module's place in the layer graph
# of docs/architecture.md; tools/check_layers.py holds the #include lines to it.
function(vantage_add_module name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "SOURCES;DEPENDS;PRIVATE_DEPENDS")
  add_library(vantage_${name} STATIC ${arg_SOURCES})
  add_library(vantage::${name} ALIAS vantage_${name})
  target_include_directories(vantage_${name} PUBLIC
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  target_compile_features(vantage_${name} PUBLIC cxx_std_17)
  target_link_libraries(vantage_${name}
    PUBLIC ${arg_DEPENDS} PRIVATE ${arg_PRIVATE_DEPENDS} $<BUILD_INTERFACE:vantage_warnings>)
  vantage_install_module(${name} DEPENDS ${arg_DEPENDS} ${arg_PRIVATE_DEPENDS})
endfunction()

# A test's own code is run once: compile it quickly. What it tests is optimised.
# -pthread, which LCM's headers ask for, has to be the same in all that share a precompiled header.
set(VANTAGE_TEST_OPTIONS -pthread $<$<CONFIG:Release>:-O1>)

# vantage_add_test(<module>/<unit>_test [SERIAL] [DEPENDS <target>...]): one executable and ctest entries per file,
# labelled with the module; part of target tests_<module>. SERIAL: nothing else runs beside it.
function(vantage_add_test path)
  cmake_parse_arguments(PARSE_ARGV 1 arg "SERIAL" "" "DEPENDS")
  set(serial FALSE)
  if(arg_SERIAL)
    set(serial TRUE)
  endif()
  cmake_path(GET path FILENAME name)
  cmake_path(GET path PARENT_PATH module)
  add_executable(${name} ${PROJECT_SOURCE_DIR}/tests/${path}.cpp)
  add_dependencies(tests_${module} ${name})
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR}/tests/support)
  target_compile_definitions(${name} PRIVATE VANTAGE_TEST_DATA="${PROJECT_SOURCE_DIR}/tests/data")
  target_link_libraries(${name} PRIVATE ${arg_DEPENDS} vantage_warnings GTest::gtest_main)
  target_precompile_headers(${name} REUSE_FROM vantage_test_headers)
  target_compile_options(${name} PRIVATE ${VANTAGE_TEST_OPTIONS})
  gtest_discover_tests(${name} NO_PRETTY_VALUES DISCOVERY_TIMEOUT 60 PROPERTIES LABELS ${module} RUN_SERIAL ${serial})
endfunction()

# vantage_add_bench(<area> DEPENDS <target>...): executable bench_<area> from bench/<area>_bench.cpp.
function(vantage_add_bench area)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "DEPENDS")
  add_executable(bench_${area} ${PROJECT_SOURCE_DIR}/bench/${area}_bench.cpp)
  target_link_libraries(bench_${area} PRIVATE ${arg_DEPENDS} vantage_warnings benchmark::benchmark)
endfunction()
