# SPDX-License-Identifier: Apache-2.0

# pipescout_enable_warnings(<target>)
#
# The warnings that every target of the project compiles with.
function(pipescout_enable_warnings target)
  # Designated initialisers leave fields to their defaults on purpose.
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic -Wconversion -Wshadow
    -Wno-missing-field-initializers)
  # GCC 12 takes `"text" + std::to_string(n)` for overlapping copies (GCC bug 105651).
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
    target_compile_options(${target} PRIVATE -Wno-restrict)
  endif()
endfunction()

# pipescout_precompile(<target> <header>...)
#
# Compiles headers once for all sources of the target: <vector> of the standard or of another package,
# never one of the target's own that is still worked on. Pays where parsing them costs more than half
# of the target's time and three sources or more include them; measure before and after.
function(pipescout_precompile target)
  if(NOT ARGN)
    message(FATAL_ERROR "pipescout_precompile(${target}): no headers")
  endif()
  target_precompile_headers(${target} PRIVATE ${ARGN})
endfunction()

# pipescout_compile_together(<target> [<number>])
#
# Compiles sources of the target as one, up to four or that number at a time: for many small sources that include the
# same large headers, where parsing costs more than all the rest. Names in anonymous namespaces must
# then differ between them. What is compiled beforehand pays from six compilations on here too.
function(pipescout_compile_together target)
  set(at_once 4)
  if(ARGC GREATER 1)
    set(at_once ${ARGV1})
  endif()
  get_target_property(sources ${target} SOURCES)
  list(LENGTH sources count)
  if(count LESS_EQUAL 20)
    set_target_properties(${target} PROPERTIES DISABLE_PRECOMPILE_HEADERS ON)
  endif()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE ${at_once})
  # GCC takes all sources but the one that includes them for headers.
  target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)
endfunction()

# pipescout_optimise_lightly(<target>)
#
# -O1 in place of -O3 in Release builds, for what only parses a command line, reads files of a few
# lines and calls libraries. CLI11 consists of inline functions, which each source that adds a
# command compiles again: measured with GCC 12, 8.1 s of CPU in place of 11.5 for
# `param_commands.cpp`.
function(pipescout_optimise_lightly target)
  target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1>)
endfunction()

# pipescout_add_library(<target>
#   [SOURCES <file>...]               default: src/*.cpp
#   [DEPENDENCIES <target>...]        part of the public headers
#   [PRIVATE_DEPENDENCIES <target>...])
#
# A shared library with its public headers in include/, known as pipescout::<name> when <target> is
# pipescout_<name>; installed, and exported by pipescout_export_package(). Of six sources or more that
# use Eigen, Eigen is compiled beforehand.
function(pipescout_add_library target)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "SOURCES;DEPENDENCIES;PRIVATE_DEPENDENCIES")
  if(arg_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "pipescout_add_library(${target}): ${arg_UNPARSED_ARGUMENTS}?")
  endif()
  if(NOT arg_SOURCES)
    file(GLOB arg_SOURCES CONFIGURE_DEPENDS src/*.cpp)
  endif()
  string(REGEX REPLACE "^pipescout_" "" name ${target})

  add_library(${target} SHARED ${arg_SOURCES})
  add_library(pipescout::${name} ALIAS ${target})
  target_compile_features(${target} PUBLIC cxx_std_20)
  target_include_directories(${target} PUBLIC
    $<BUILD_INTERFACE:${CMAKE_CURRENT_SOURCE_DIR}/include>
    $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  target_link_libraries(${target} PUBLIC ${arg_DEPENDENCIES})
  foreach(dependency IN LISTS arg_PRIVATE_DEPENDENCIES)
    # Users of the library need not know of it.
    target_link_libraries(${target} PRIVATE $<BUILD_INTERFACE:${dependency}>)
  endforeach()
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${name} VERSION ${PROJECT_VERSION}
    SOVERSION ${PROJECT_VERSION_MAJOR})
  pipescout_enable_warnings(${target})
  _pipescout_precompile_for_library(${target})
  pipescout_export_target(${target})
endfunction()

# Parsing Eigen takes more than a second, half of the compile time of an average source that uses it;
# compiling it beforehand takes 3 to 5. Measured with GCC 12: `test/benchmark/run.sh build`.
function(_pipescout_precompile_for_library target)
  get_target_property(sources ${target} SOURCES)
  get_target_property(libraries ${target} LINK_LIBRARIES)
  list(LENGTH sources count)
  if(count LESS 6 OR NOT "${libraries}" MATCHES "Eigen3::Eigen|pipescout::geometry")
    return()
  endif()
  set(headers <Eigen/Geometry> <algorithm> <array> <cmath> <functional> <limits> <numbers>
    <optional> <random> <span> <sstream> <stdexcept> <string> <vector>)
  if("${libraries}" MATCHES "pipescout::geometry")
    list(APPEND headers <pipescout/geometry/se3.hpp>)
  endif()
  pipescout_precompile(${target} ${headers})
endfunction()
