# SPDX-License-Identifier: Apache-2.0
# Builds a small project of three .idl files, of which one includes another:
#   cmake -DIDL_SOURCE_DIR=dir -DWORK_DIR=dir -DGENERATOR=name -P generation_test.cmake
# Touching a file must regenerate that file alone, and a file that cannot be generated must fail the
# build with a message that names it.
cmake_minimum_required(VERSION 3.22)

set(source "${WORK_DIR}/source")
set(build "${WORK_DIR}/build")
set(leaf builtin_interfaces/msg/Time)
set(dependant std_msgs/msg/Header)
set(unrelated std_msgs/msg/Bool)

file(REMOVE_RECURSE "${WORK_DIR}")
file(COPY "${IDL_SOURCE_DIR}/cmake" DESTINATION "${source}")
foreach(base IN ITEMS ${leaf} ${dependant} ${unrelated})
  configure_file("${IDL_SOURCE_DIR}/${base}.idl" "${source}/${base}.idl" COPYONLY)
endforeach()
file(WRITE "${source}/CMakeLists.txt" "
cmake_minimum_required(VERSION 3.22)
project(generation LANGUAGES NONE)
include(cmake/idl_generation.cmake)
set(bases ${leaf} ${dependant} ${unrelated})
list(TRANSFORM bases APPEND .idl OUTPUT_VARIABLE files)
idl_generate(OUTPUT_DIR \${CMAKE_BINARY_DIR} IDL_DIR \${CMAKE_SOURCE_DIR} FILES \${files})
list(TRANSFORM bases PREPEND \${CMAKE_BINARY_DIR}/)
list(TRANSFORM bases APPEND .h)
add_custom_target(generate ALL DEPENDS \${bases})
")

# Builds; sets `generated` to the sorted list of the types that were, `result` and `output`.
function(build)
  execute_process(COMMAND "${CMAKE_COMMAND}" --build "${build}" RESULT_VARIABLE result
                  OUTPUT_VARIABLE output ERROR_VARIABLE output)
  string(REGEX MATCHALL "Generating [A-Za-z0-9_/]+" generated "${output}")
  list(TRANSFORM generated REPLACE "Generating " "")
  list(SORT generated)
  foreach(variable IN ITEMS result output generated)
    set(${variable} "${${variable}}" PARENT_SCOPE)
  endforeach()
endfunction()

function(expect_generated)
  build()
  if(NOT result EQUAL 0 OR NOT generated STREQUAL "${ARGN}")
    message(FATAL_ERROR "generated '${generated}', expected '${ARGN}'\n${output}")
  endif()
endfunction()

# Replaces a file's content for one build, which must fail with that text in its output.
function(expect_failure base content text)
  file(READ "${source}/${base}.idl" original)
  file(WRITE "${source}/${base}.idl" "${content}")
  build()
  file(WRITE "${source}/${base}.idl" "${original}")
  string(FIND "${output}" "${text}" position)
  if(result EQUAL 0 OR position EQUAL -1)
    message(FATAL_ERROR "expected a failure with '${text}', got ${result}\n${output}")
  endif()
endfunction()

execute_process(COMMAND "${CMAKE_COMMAND}" -G "${GENERATOR}" -S "${source}" -B "${build}"
                COMMAND_ERROR_IS_FATAL ANY OUTPUT_QUIET)
expect_generated(${leaf} ${unrelated} ${dependant})
expect_generated()
file(TOUCH "${source}/${leaf}.idl")
expect_generated(${leaf})
file(TOUCH "${source}/${dependant}.idl")
expect_generated(${dependant})
expect_generated()

set(before "module std_msgs { module msg {\n")
set(after "\n}; };\n")
expect_failure(${unrelated} "${before}struct Bool { no_such_type data; };${after}"
               "std_msgs/msg/Bool.idl:2")
expect_failure(${unrelated} "${before}struct Boolean { boolean data; };${after}"
               "std_msgs::msg::dds_::Bool_")
expect_failure(${unrelated} "${before}struct Bool { string<8> data; };${after}" "bounded string")
expect_failure(${unrelated} "${before}enum Kind { A };\nstruct Bool { Kind data; };${after}"
               "enum is not supported")
expect_generated(${unrelated})
