# SPDX-License-Identifier: Apache-2.0

# pipescout_find_class_loader()
#
# Defines the target pipescout_class_loader: class_loader as Debian ships it. Debian's own
# class_loaderConfig.cmake asks for parts of ament that Debian does not have.
function(pipescout_find_class_loader)
  if(TARGET pipescout_class_loader)
    return()
  endif()
  find_library(CLASS_LOADER_LIBRARY class_loader REQUIRED)
  find_library(CONSOLE_BRIDGE_LIBRARY console_bridge REQUIRED)
  find_path(CLASS_LOADER_INCLUDE_DIR class_loader/class_loader.hpp PATH_SUFFIXES class_loader REQUIRED)
  find_path(RCPPUTILS_INCLUDE_DIR rcpputils/filesystem_helper.hpp PATH_SUFFIXES rcpputils REQUIRED)
  find_path(RCUTILS_INCLUDE_DIR rcutils/types.h PATH_SUFFIXES rcutils REQUIRED)
  add_library(pipescout_class_loader INTERFACE IMPORTED GLOBAL)
  target_include_directories(pipescout_class_loader SYSTEM INTERFACE
    ${CLASS_LOADER_INCLUDE_DIR} ${RCPPUTILS_INCLUDE_DIR} ${RCUTILS_INCLUDE_DIR})
  target_link_libraries(pipescout_class_loader INTERFACE
    ${CLASS_LOADER_LIBRARY} ${CONSOLE_BRIDGE_LIBRARY})
endfunction()

# pipescout_add_component(<target>
#   CLASSES <class>...                component classes that the library registers, fully qualified
#   [WHOLE_GRAPH <class>...]          those of them that look at endpoints of others: behind a discovery server their process
#                                     is told everything
#   [SOURCES <file>...]               default: src/*.cpp
#   [DEPENDENCIES <target>...]        beside pipescout::runtime
#   [PRIVATE_DEPENDENCIES <target>...])
#
# A library as pipescout_add_library() makes it, its sources compiled together, whose components are entered into the index by which
# they are found by name:
#   <prefix>/share/ament_index/resource_index/pipescout_components/<project>
# with a line "<class>;<library file, relative to the prefix>" per class, and ";sees_whole_graph" behind those of WHOLE_GRAPH. One
# call a package.
function(pipescout_add_component target)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "CLASSES;WHOLE_GRAPH;SOURCES;DEPENDENCIES;PRIVATE_DEPENDENCIES")
  if(NOT arg_CLASSES)
    message(FATAL_ERROR "pipescout_add_component(${target}) needs CLASSES")
  endif()
  if(NOT TARGET pipescout::runtime)
    message(FATAL_ERROR
      "pipescout_add_component(${target}): find_package(pipescout_runtime REQUIRED) goes before")
  endif()
  pipescout_find_class_loader()
  pipescout_add_library(${target}
    SOURCES ${arg_SOURCES}
    DEPENDENCIES pipescout::runtime ${arg_DEPENDENCIES}
    PRIVATE_DEPENDENCIES pipescout_class_loader ${arg_PRIVATE_DEPENDENCIES})
  # Loaded by the name that stands in the index, never linked by its soname.
  set_property(TARGET ${target} PROPERTY VERSION)
  set_property(TARGET ${target} PROPERTY SOVERSION)

  # Parsing the headers of runtime and messages is half of their time.
  pipescout_compile_together(${target})

  set(index "")
  set(index_of_ros "")
  foreach(class IN LISTS arg_CLASSES)
    set(line "${class};${CMAKE_INSTALL_LIBDIR}/$<TARGET_FILE_NAME:${target}>")
    string(APPEND index_of_ros "${line}\n")
    if(class IN_LIST arg_WHOLE_GRAPH)
      string(APPEND line ";sees_whole_graph")
    endif()
    string(APPEND index "${line}\n")
  endforeach()
  pipescout_index_resource(pipescout_components ${PROJECT_NAME} "${index}")
  # For `ros2 component types`: see docs/deployment.md for who can load them.
  pipescout_index_resource(rclcpp_components ${PROJECT_NAME} "${index_of_ros}")
endfunction()
