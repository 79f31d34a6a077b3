# SPDX-License-Identifier: Apache-2.0
set(_pipescout_test_headers ${CMAKE_CURRENT_LIST_DIR}/../test_headers)

# Counts what a thread takes from the heap: #include "heap_guard.hpp". It takes the place of malloc in
# the program that links it.
if(NOT TARGET pipescout::heap_guard)
  add_library(pipescout::heap_guard INTERFACE IMPORTED)
  set_target_properties(pipescout::heap_guard PROPERTIES
    INTERFACE_SOURCES "${CMAKE_CURRENT_LIST_DIR}/../heap_guard/heap_guard.cpp"
    INTERFACE_INCLUDE_DIRECTORIES "${CMAKE_CURRENT_LIST_DIR}/../heap_guard")
endif()

# pipescout_add_tests(
#   [NAME <executable>]               default: <project>_tests
#   [SOURCES <file>...]               default: test/*.cpp but the *_test.cpp of earlier calls
#   [DEPENDENCIES <target>...]        pipescout::<name> that is not known yet is that of the package
#                                     pipescout_<name>
#   [DEFINITIONS <name>=<value>...]
#   [CASES <number>]                  that each property of rapidcheck is tried on; default: 100
#   [ENVIRONMENT <name>=<value>...]
#   [LABEL unit|dds|mission]          default: unit
#   [TIMEOUT <seconds>]               of each entry of ctest; default: 300
#   [SHARDS <number> | ISOLATED])     default: one shard
#
# Google tests as one executable. It is built only where BUILD_TESTING is on, and sees the package's
# own headers in src/ and test/. ctest has one entry for each shard, <executable> or
# <executable>.<shard>, which leaves its results in test_results/<entry>.xml. With ISOLATED each test
# is an entry and a process of its own: for what a process cannot take back, such as the profiles that
# Fast DDS loads once.
#
# Where tests are slow by intention, under a sanitizer, -DPIPESCOUT_TIMEOUT_FACTOR=<number> gives them
# more time.
#
# `ctest -j` is safe: tests with the label dds or mission have a DDS domain of their own, ROS_DOMAIN_ID,
# and wait for each other where two share one.
function(pipescout_add_tests)
  cmake_parse_arguments(PARSE_ARGV 0 arg "ISOLATED" "NAME;CASES;LABEL;TIMEOUT;SHARDS"
    "SOURCES;DEPENDENCIES;DEFINITIONS;ENVIRONMENT")
  if(arg_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "pipescout_add_tests: ${arg_UNPARSED_ARGUMENTS}?")
  endif()
  if(NOT BUILD_TESTING)
    return()
  endif()
  if(NOT arg_NAME)
    set(arg_NAME ${PROJECT_NAME}_tests)
  endif()
  if(NOT arg_CASES)
    set(arg_CASES 100)
  endif()
  if(NOT arg_SHARDS)
    set(arg_SHARDS 1)
  endif()
  _pipescout_test_sources(sources ${arg_SOURCES})

  find_package(GTest REQUIRED)
  foreach(dependency IN LISTS arg_DEPENDENCIES)
    if(dependency STREQUAL "rapidcheck")
      find_package(rapidcheck REQUIRED)
      list(APPEND arg_DEPENDENCIES rapidcheck_gtest)
    elseif(dependency MATCHES "^pipescout::(.+)$" AND NOT TARGET ${dependency})
      find_package(pipescout_${CMAKE_MATCH_1} REQUIRED)
    endif()
  endforeach()

  set(property_cases ${CMAKE_CURRENT_FUNCTION_LIST_DIR}/property_cases.cpp)
  add_executable(${arg_NAME} ${sources} ${property_cases})
  target_include_directories(${arg_NAME} PRIVATE ${PROJECT_SOURCE_DIR}/src
    ${PROJECT_SOURCE_DIR}/test)
  target_compile_definitions(${arg_NAME} PRIVATE
    PIPESCOUT_PROPERTY_CASES="${arg_CASES}" ${arg_DEFINITIONS})
  target_link_libraries(${arg_NAME} PRIVATE ${arg_DEPENDENCIES} GTest::gmock_main)
  _pipescout_test_options(${arg_NAME})
  _pipescout_precompiled_for_tests(${arg_NAME})

  if(arg_ISOLATED)
    include(GoogleTest)
    gtest_discover_tests(${arg_NAME} DISCOVERY_TIMEOUT 60 TEST_PREFIX ${arg_NAME}.)
    # gtest_discover_tests takes no property that is a list, as ENVIRONMENT is: ctest sets them itself.
    _pipescout_test_properties(properties ${arg_NAME}
      "${arg_LABEL}" "${arg_TIMEOUT}" ${arg_ENVIRONMENT})
    set(quoted "")
    foreach(each IN LISTS properties)
      string(APPEND quoted " [==[${each}]==]")
    endforeach()
    set(script ${CMAKE_CURRENT_BINARY_DIR}/${arg_NAME}_properties.cmake)
    file(WRITE ${script} "set_tests_properties(\${${arg_NAME}_TESTS} PROPERTIES${quoted})\n")
    set_property(DIRECTORY APPEND PROPERTY TEST_INCLUDE_FILES ${script})
    return()
  endif()
  set(results ${PROJECT_BINARY_DIR}/test_results)
  math(EXPR last "${arg_SHARDS} - 1")
  foreach(shard RANGE ${last})
    set(entry ${arg_NAME})
    set(environment ${arg_ENVIRONMENT})
    if(arg_SHARDS GREATER 1)
      set(entry ${arg_NAME}.${shard})
      list(APPEND environment GTEST_TOTAL_SHARDS=${arg_SHARDS} GTEST_SHARD_INDEX=${shard})
    endif()
    add_test(NAME ${entry} COMMAND ${arg_NAME} --gtest_output=xml:${results}/${entry}.xml)
    _pipescout_test_properties(properties ${entry}
      "${arg_LABEL}" "${arg_TIMEOUT}" ${environment})
    set_tests_properties(${entry} PROPERTIES ${properties})
  endforeach()
endfunction()

# pipescout_describe_test(<entry of ctest>
#   [LABEL unit|dds|mission] [TIMEOUT <seconds>] [ENVIRONMENT <name>=<value>...])
#
# The same properties for a test that is not a Google test.
function(pipescout_describe_test entry)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "LABEL;TIMEOUT" "ENVIRONMENT")
  _pipescout_test_properties(properties ${entry}
    "${arg_LABEL}" "${arg_TIMEOUT}" ${arg_ENVIRONMENT})
  set_tests_properties(${entry} PROPERTIES ${properties})
endfunction()

# <label>, <timeout>: may be empty. The rest: the environment.
function(_pipescout_test_properties result entry label timeout)
  if(NOT label)
    set(label unit)
  endif()
  if(NOT timeout)
    set(timeout 300)
  endif()
  if(DEFINED PIPESCOUT_TIMEOUT_FACTOR)
    math(EXPR timeout "${timeout} * ${PIPESCOUT_TIMEOUT_FACTOR}")
  endif()
  set(environment ${ARGN})
  # The longest begin first, so that none of them is left for the end.
  set(properties LABELS ${label} TIMEOUT ${timeout} COST ${timeout})
  if(NOT label STREQUAL "unit")
    _pipescout_dds_domain(domain ${entry})
    list(PREPEND environment ROS_DOMAIN_ID=${domain} ROS_LOCALHOST_ONLY=1)
    list(APPEND properties RESOURCE_LOCK dds_domain_${domain})
  endif()
  if(environment)
    # A list within the list.
    string(REPLACE ";" "\\;" environment "${environment}")
    list(APPEND properties ENVIRONMENT "${environment}")
  endif()
  set(${result} "${properties}" PARENT_SCOPE)
endfunction()

function(_pipescout_test_sources result)
  set(sources ${ARGN})
  get_property(taken DIRECTORY PROPERTY PIPESCOUT_TEST_SOURCES)
  if(NOT sources)
    file(GLOB sources CONFIGURE_DEPENDS RELATIVE ${CMAKE_CURRENT_SOURCE_DIR} test/*.cpp)
    list(REMOVE_ITEM sources ${taken})
  endif()
  set(${result} ${sources} PARENT_SCOPE)
  # Others are what tests share.
  list(FILTER sources INCLUDE REGEX "_test\\.cpp$")
  set_property(DIRECTORY APPEND PROPERTY PIPESCOUT_TEST_SOURCES ${sources})
endfunction()

# Those that a compiled header must share with what includes it.
function(_pipescout_test_options target)
  pipescout_enable_warnings(${target})
  # What tests do themselves is not measured. With so little optimisation GCC 12 takes the buffer of a
  # short string for a long one's.
  target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1>
    $<$<CXX_COMPILER_ID:GNU>:-Wno-array-bounds>)
endfunction()

# What all tests include has been compiled in this package (test_headers/): once, since its 120 to 170 MB
# and 5 s a package are more than most packages' tests are. GCC reads the text of a header whose
# compiled form was made with other options.
function(_pipescout_precompiled_for_tests target)
  set(headers without_eigen)
  if(TARGET Eigen3::Eigen)
    set(headers with_eigen)
    target_link_libraries(${target} PRIVATE Eigen3::Eigen)
  endif()
  set(header ${_pipescout_test_headers}/${headers}.hpp)
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND EXISTS ${header}.gch)
    target_compile_options(${target} PRIVATE -Winvalid-pch -Wno-error=invalid-pch
      "SHELL:-include ${header}")
  endif()
endfunction()

# One of 100 domains, the same for a name on every machine. 0 is for people.
function(_pipescout_dds_domain result name)
  string(MD5 digest "${name}")
  string(SUBSTRING ${digest} 0 6 digest)
  math(EXPR domain "0x${digest} % 100 + 1")
  set(${result} ${domain} PARENT_SCOPE)
endfunction()
