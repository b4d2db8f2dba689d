# cmake -DLCM_GEN= -DOUT= -DTYPES=<list> -P VantageLcmLayouts.cmake
#
# Writes the layout of each type as constexpr tables, from what lcm-gen's own parser understood of the
# files (lcm-gen --debug). That the tables are right is proved by a test: the fingerprint computed from a
# table must be the one in lcm-gen's C++ binding.
#
# Lines read:   struct package.name [hash=...]
#               <tab>type  member [ (var) size_member ] [ (const) 3 ]
cmake_minimum_required(VERSION 3.25)

execute_process(COMMAND ${LCM_GEN} --debug ${TYPES} RESULT_VARIABLE result OUTPUT_VARIABLE dump)
if(NOT result EQUAL 0)
  message(FATAL_ERROR "lcm-gen --debug failed:\n${dump}")
endif()

# Brackets would be taken for list syntax.
string(REPLACE "[" "<" dump "${dump}")
string(REPLACE "]" ">" dump "${dump}")
string(REGEX MATCHALL "[^\n]+" lines "${dump}")

set(primitives int8_t int16_t int32_t int64_t byte boolean float double string)
set(tables "")
set(specialisations "")
set(all "")
set(type "")

macro(finish_type)
  if(type)
    string(APPEND tables
      "inline constexpr FieldLayout ${id}_fields[] = {\n${fields}};\n"
      "inline constexpr MessageLayout ${id}{\"${type}\", ${id}_fields, ${count}};\n\n")
    string(REPLACE "." ";" parts "${type}")
    list(GET parts 0 package)
    list(GET parts 1 name)
    string(APPEND all "    &${id},\n")
    string(APPEND declarations "namespace ${package} {\nclass ${name};\n}\n")
    string(APPEND specialisations
      "template <>\ninline constexpr const MessageLayout* kLayoutOf<${package}::${name}> = &layouts::${id};\n")
  endif()
endmacro()

foreach(line IN LISTS lines)
  if(line MATCHES "^struct ([A-Za-z0-9_]+[.][A-Za-z0-9_]+) ")
    finish_type()
    set(type ${CMAKE_MATCH_1})
    string(REPLACE "." "_" id ${type})
    set(fields "")
    set(members "")
    set(count 0)
  elseif(line MATCHES "^\t([A-Za-z0-9_.]+) +([A-Za-z0-9_]+)(.*)$")
    set(member_type ${CMAKE_MATCH_1})
    set(member ${CMAKE_MATCH_2})
    set(rest "${CMAKE_MATCH_3}")
    if(member_type IN_LIST primitives)
      string(REGEX REPLACE "_t$" "" enumerator ${member_type})
      string(SUBSTRING ${enumerator} 0 1 first)
      string(TOUPPER ${first} first)
      string(SUBSTRING ${enumerator} 1 -1 others)
      set(kind "FieldKind::k${first}${others}, nullptr")
    else()
      string(REPLACE "." "_" nested ${member_type})
      set(kind "FieldKind::kNested, &${nested}")
    endif()
    set(dimensions "")
    set(num_dimensions 0)
    string(REGEX MATCHALL "<[^>]+>" brackets "${rest}")
    foreach(bracket IN LISTS brackets)
      if(bracket MATCHES "\\(var\\) ([A-Za-z0-9_]+)")
        list(FIND members ${CMAKE_MATCH_1} index)
        string(APPEND dimensions "{${index}, 0, \"${CMAKE_MATCH_1}\"}, ")
      elseif(bracket MATCHES "\\(const\\) ([0-9]+)")
        string(APPEND dimensions "{-1, ${CMAKE_MATCH_1}, \"${CMAKE_MATCH_1}\"}, ")
      else()
        message(FATAL_ERROR "lcm-gen --debug: cannot read '${line}'")
      endif()
      math(EXPR num_dimensions "${num_dimensions} + 1")
    endforeach()
    string(APPEND fields "    {\"${member}\", ${kind}, ${num_dimensions}, {${dimensions}}},\n")
    list(APPEND members ${member})
    math(EXPR count "${count} + 1")
  else()
    message(FATAL_ERROR "lcm-gen --debug: cannot read '${line}'")
  endif()
endforeach()
finish_type()

file(CONFIGURE OUTPUT ${OUT} @ONLY CONTENT [[
// Generated from lcm_types/*.lcm by cmake/VantageLcmLayouts.cmake.
#pragma once

#include "vantage/messaging/message_layout.h"

@declarations@
namespace vantage {
namespace layouts {

@tables@inline constexpr const MessageLayout* kAll[] = {
@all@};

}  // namespace layouts

@specialisations@
}  // namespace vantage
]])
