# SPDX-License-Identifier: Apache-2.0
# A definition that changes must change the files that are made from it and no others:
#   cmake -DGENERATOR=program -DDEFINITIONS=dir -DWORK_DIR=dir -P generation_test.cmake
cmake_minimum_required(VERSION 3.22)

file(REMOVE_RECURSE "${WORK_DIR}")
file(COPY "${DEFINITIONS}/std_msgs" DESTINATION "${WORK_DIR}/source")

function(generate)
  execute_process(
    COMMAND "${GENERATOR}" cpp --package std_msgs --folder "${WORK_DIR}/source/std_msgs"
            --root "${DEFINITIONS}" --output "${WORK_DIR}/out"
            msg/Bool.idl msg/Header.idl msg/String.idl
    RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  set(result "${result}" PARENT_SCOPE)
  set(output "${output}" PARENT_SCOPE)
endfunction()

# The names of the files that are newer than the mark.
function(changed result)
  file(GLOB_RECURSE files RELATIVE "${WORK_DIR}/out/std_msgs" "${WORK_DIR}/out/*.?pp")
  set(newer)
  foreach(file IN LISTS files)
    if(NOT "${WORK_DIR}/mark" IS_NEWER_THAN "${WORK_DIR}/out/std_msgs/${file}")
      list(APPEND newer "${file}")
    endif()
  endforeach()
  list(SORT newer)
  set(${result} "${newer}" PARENT_SCOPE)
endfunction()

function(expect_changed)
  # What was written before is as old as the mark at most.
  file(GLOB_RECURSE files "${WORK_DIR}/out/*.?pp")
  if(files)
    execute_process(COMMAND touch -d "2001-01-01" ${files} COMMAND_ERROR_IS_FATAL ANY)
  endif()
  execute_process(COMMAND touch -d "2001-01-02" "${WORK_DIR}/mark" COMMAND_ERROR_IS_FATAL ANY)
  generate()
  changed(newer)
  if(NOT result EQUAL 0 OR NOT newer STREQUAL "${ARGN}")
    message(FATAL_ERROR "written '${newer}', expected '${ARGN}'\n${output}")
  endif()
endfunction()

expect_changed(msg/bool.hpp msg/header.hpp msg/string.hpp type_support.cpp)
expect_changed()
file(READ "${WORK_DIR}/source/std_msgs/msg/Bool.idl" bool)
string(REPLACE "boolean data" "boolean datum" other "${bool}")
file(WRITE "${WORK_DIR}/source/std_msgs/msg/Bool.idl" "${other}")
expect_changed(msg/bool.hpp type_support.cpp)

# What is wrong is said with file, line and name, and leaves what there is.
string(REPLACE "boolean data" "Nothing data" wrong "${bool}")
file(WRITE "${WORK_DIR}/source/std_msgs/msg/Bool.idl" "${wrong}")
generate()
if(result EQUAL 0 OR NOT output MATCHES "std_msgs/msg/Bool.idl:[0-9]+: data: unknown type std_msgs/msg/Nothing")
  message(FATAL_ERROR "expected an unknown type, got ${result}: ${output}")
endif()
