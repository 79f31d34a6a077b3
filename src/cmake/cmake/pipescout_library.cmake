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

# pipescout_add_library(<target>
#   [SOURCES <file>...]               default: src/*.cpp
#   [DEPENDENCIES <target>...]        part of the public headers
#   [PRIVATE_DEPENDENCIES <target>...])
#
# A shared library with its public headers in include/, known as pipescout::<name> when <target> is
# pipescout_<name>; installed, and exported by pipescout_export_package().
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
  pipescout_export_target(${target})
endfunction()
