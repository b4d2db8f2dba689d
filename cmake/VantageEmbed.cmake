# vantage_embed_configs(<target> KINDS <folder>...)
#
# Compiles config/<folder>/*.yaml into <target> as src/config/embedded.h declares them, so that programs
# find their defaults from anywhere. New files are picked up by the next build.
#
# Run as a script (cmake -P) by that build with OUTPUT, ROOT and FILES, this file writes the source.
if(CMAKE_SCRIPT_MODE_FILE)
  set(entries "")
  foreach(file IN LISTS FILES)
    cmake_path(GET file PARENT_PATH folder)
    cmake_path(GET file STEM LAST_ONLY name)
    file(READ ${ROOT}/${file} text)
    string(APPEND entries "    {\"${folder}\", \"${name}\", R\"vantage_yaml(${text})vantage_yaml\"},\n")
  endforeach()
  file(WRITE ${OUTPUT} "// Made by cmake/VantageEmbed.cmake from the files of config/.
#include \"embedded.h\"

namespace vantage {

const std::vector<EmbeddedConfig>& EmbeddedConfigs() {
  static const std::vector<EmbeddedConfig> configs{
${entries}  };
  return configs;
}

}  // namespace vantage
")
  return()
endif()

function(vantage_embed_configs target)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "KINDS")
  set(root ${PROJECT_SOURCE_DIR}/config)
  set(patterns "")
  foreach(kind IN LISTS arg_KINDS)
    list(APPEND patterns ${root}/${kind}/*.yaml)
  endforeach()
  file(GLOB paths CONFIGURE_DEPENDS RELATIVE ${root} ${patterns})
  set(depends ${paths})
  list(TRANSFORM depends PREPEND ${root}/)
  set(output ${CMAKE_CURRENT_BINARY_DIR}/embedded.cpp)
  set(script ${PROJECT_SOURCE_DIR}/cmake/VantageEmbed.cmake)
  add_custom_command(
    OUTPUT ${output}
    COMMAND ${CMAKE_COMMAND} "-DOUTPUT=${output}" "-DROOT=${root}" "-DFILES=${paths}" -P ${script}
    DEPENDS ${depends} ${script}
    COMMENT "Embedding config/*.yaml"
    VERBATIM)
  target_sources(${target} PRIVATE ${output})
  target_include_directories(${target} PRIVATE ${CMAKE_CURRENT_SOURCE_DIR})
endfunction()
