# What `cmake --install` puts where: programs and shared files (component runtime), and the modules as a CMake
# package with one component each (component dev): find_package(vantage COMPONENTS observability).
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
set(VANTAGE_CMAKE_DIR ${CMAKE_INSTALL_LIBDIR}/cmake/vantage)

# vantage_install_module(<name> DEPENDS <target>...): exports target vantage_<name> as vantage::<name>, with a file
# that says what it needs. A module is exported by itself, so that whoever takes one needs no more than its packages.
function(vantage_install_module name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "DEPENDS")
  set_target_properties(vantage_${name} PROPERTIES EXPORT_NAME ${name})
  install(TARGETS vantage_${name} EXPORT vantage-${name} ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT dev)
  install(EXPORT vantage-${name} NAMESPACE vantage:: DESTINATION ${VANTAGE_CMAKE_DIR} COMPONENT dev)
  if(IS_DIRECTORY ${PROJECT_SOURCE_DIR}/include/vantage/${name})
    install(DIRECTORY ${PROJECT_SOURCE_DIR}/include/vantage/${name} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/vantage COMPONENT dev)
  endif()
  set(modules ${arg_DEPENDS})
  list(FILTER modules INCLUDE REGEX "^vantage::")
  list(TRANSFORM modules REPLACE "^vantage::" "")
  set(externals ${arg_DEPENDS})
  list(FILTER externals EXCLUDE REGEX "^vantage::")
  file(CONFIGURE OUTPUT ${CMAKE_CURRENT_BINARY_DIR}/vantage-${name}-needs.cmake @ONLY
       CONTENT "set(vantage_modules @modules@)\nset(vantage_externals @externals@)\n")
  install(FILES ${CMAKE_CURRENT_BINARY_DIR}/vantage-${name}-needs.cmake DESTINATION ${VANTAGE_CMAKE_DIR} COMPONENT dev)
endfunction()

function(vantage_install_package)
  set(work ${PROJECT_BINARY_DIR}/install)
  configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/vantageConfig.cmake.in ${work}/vantageConfig.cmake
    INSTALL_DESTINATION ${VANTAGE_CMAKE_DIR})
  write_basic_package_version_file(${work}/vantageConfigVersion.cmake COMPATIBILITY SameMinorVersion)
  install(FILES ${work}/vantageConfig.cmake ${work}/vantageConfigVersion.cmake ${PROJECT_SOURCE_DIR}/cmake/VantageExternals.cmake
    DESTINATION ${VANTAGE_CMAKE_DIR} COMPONENT dev)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/lcm_types/ DESTINATION ${CMAKE_INSTALL_DATADIR}/vantage/lcm_types
    COMPONENT dev FILES_MATCHING PATTERN "*.lcm")
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/config/ DESTINATION ${CMAKE_INSTALL_DATADIR}/vantage/config COMPONENT runtime
    PATTERN "*.py" EXCLUDE)
  install(FILES ${PROJECT_SOURCE_DIR}/README.md ${PROJECT_SOURCE_DIR}/CHANGELOG.md DESTINATION ${CMAKE_INSTALL_DOCDIR}
    COMPONENT runtime)
endfunction()
