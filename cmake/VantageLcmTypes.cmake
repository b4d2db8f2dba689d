# LCM and what is generated from lcm_types/*.lcm: C++ bindings, layouts for checking bytes from outside,
# and the jar that shows the types in lcm-spy.

# Of the LCM that is linked, first: vantage_find_external() has found it as a CMake package or by pkg-config.
set(hints "")
if(lcm_DIR)
  list(APPEND hints ${lcm_DIR}/../../../bin ${lcm_DIR}/../../../../bin)
endif()
if(LCM_PREFIX)
  list(APPEND hints ${LCM_PREFIX}/bin)
endif()
find_program(LCM_GEN lcm-gen HINTS ${hints} REQUIRED)
unset(hints)

# vantage_add_lcm_types(<name> TYPES <file.lcm>...)
#
# Interface library vantage_<name> (alias vantage::<name>) with lcm-gen's C++ bindings as system headers (<package>/<type>.hpp), and
# "vantage_lcm/layouts.h": the layout of every type as a table (vantage/messaging/message_layout.h). A type
# comes after the types it contains.
function(vantage_add_lcm_types name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "TYPES")
  set(out ${CMAKE_CURRENT_BINARY_DIR}/generated)
  set(files "")
  set(headers "")
  set(packages "")
  foreach(type IN LISTS arg_TYPES)
    set(file ${CMAKE_CURRENT_SOURCE_DIR}/${type})
    cmake_path(GET type STEM stem)
    file(STRINGS ${file} package REGEX "^package ")
    string(REGEX REPLACE "^package +([A-Za-z0-9_]+).*" "\\1" package "${package}")
    set(header ${out}/${package}/${stem}.hpp)
    add_custom_command(
      OUTPUT ${header}
      COMMAND ${LCM_GEN} --cpp --cpp-std c++11 --cpp-hpath ${out} ${file}
      DEPENDS ${file}
      VERBATIM)
    list(APPEND headers ${header})
    list(APPEND files ${file})
    list(APPEND packages ${package})
  endforeach()
  list(REMOVE_DUPLICATES packages)
  set(layouts ${out}/vantage_lcm/layouts.h)
  add_custom_command(
    OUTPUT ${layouts}
    COMMAND ${CMAKE_COMMAND} -DLCM_GEN=${LCM_GEN} -DOUT=${layouts} "-DTYPES=${files}"
            -P ${PROJECT_SOURCE_DIR}/cmake/VantageLcmLayouts.cmake
    DEPENDS ${files} ${PROJECT_SOURCE_DIR}/cmake/VantageLcmLayouts.cmake
    VERBATIM)
  add_library(vantage_${name} INTERFACE ${headers} ${layouts})
  add_library(vantage::${name} ALIAS vantage_${name})
  target_include_directories(vantage_${name} SYSTEM INTERFACE
    $<BUILD_INTERFACE:${out}> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  target_link_libraries(vantage_${name} INTERFACE vantage_lcm)
  vantage_install_module(${name} DEPENDS vantage_lcm)
  foreach(package IN LISTS packages)
    install(DIRECTORY ${out}/${package} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT dev FILES_MATCHING PATTERN "*.hpp")
  endforeach()
endfunction()

# vantage_add_lcm_jar(<target> TYPES <file.lcm>... PLUGINS <file.java>...)
#
# build/<preset>/share/vantage_types.jar: the Java bindings and plugins for lcm-spy (tools/spy) and other Java tools.
# Left out with a message where there is no JDK or no lcm.jar: nothing else needs it.
function(vantage_add_lcm_jar target)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "TYPES;PLUGINS")
  find_package(Java QUIET COMPONENTS Development)
  find_file(VANTAGE_LCM_JAR lcm.jar PATHS /usr/share/java /usr/local/share/java)
  if(NOT Java_Development_FOUND OR NOT VANTAGE_LCM_JAR)
    message(STATUS "No vantage_types.jar, so lcm-spy will not decode our types: needs a JDK (default-jdk-headless) "
                   "and lcm.jar (liblcm-java)")
    return()
  endif()
  list(TRANSFORM arg_TYPES PREPEND ${CMAKE_CURRENT_SOURCE_DIR}/ OUTPUT_VARIABLE files)
  set(jar ${CMAKE_BINARY_DIR}/share/vantage_types.jar)
  add_custom_command(
    OUTPUT ${jar}
    COMMAND ${CMAKE_COMMAND} -DLCM_GEN=${LCM_GEN} -DJAVAC=${Java_JAVAC_EXECUTABLE} -DJAR=${Java_JAR_EXECUTABLE}
            -DLCM_JAR=${VANTAGE_LCM_JAR} -DWORK=${CMAKE_CURRENT_BINARY_DIR}/java -DOUT=${jar} "-DTYPES=${files}"
            "-DPLUGINS=${arg_PLUGINS}" -P ${PROJECT_SOURCE_DIR}/cmake/VantageLcmJar.cmake
    DEPENDS ${files} ${arg_PLUGINS} ${PROJECT_SOURCE_DIR}/cmake/VantageLcmJar.cmake
    VERBATIM)
  add_custom_target(${target} ALL DEPENDS ${jar})
  install(FILES ${jar} DESTINATION ${CMAKE_INSTALL_DATADIR}/vantage COMPONENT runtime)
endfunction()
