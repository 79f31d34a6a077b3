# SPDX-License-Identifier: Apache-2.0
# find_package(pipescout_cmake REQUIRED), after project(): the settings that all packages share, and
# the functions that their CMakeLists.txt are made of. README.md lists them.
include("${CMAKE_CURRENT_LIST_DIR}/pipescout_settings.cmake")
include("${CMAKE_CURRENT_LIST_DIR}/pipescout_ament_index.cmake")
include("${CMAKE_CURRENT_LIST_DIR}/pipescout_library.cmake")
include("${CMAKE_CURRENT_LIST_DIR}/pipescout_component.cmake")
include("${CMAKE_CURRENT_LIST_DIR}/pipescout_export.cmake")
include("${CMAKE_CURRENT_LIST_DIR}/pipescout_tests.cmake")
