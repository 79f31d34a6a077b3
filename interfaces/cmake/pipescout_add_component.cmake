# pipescout_add_component(<target>
#   [EXPORTED]                also as a target pipescout::<name> that find_package(<project>) gives, with the
#                             headers in include/; DEPENDENCIES are then pipescout:: targets only
#   CLASSES <class>...        component classes that the library registers, fully qualified
#   SOURCES <file>...
#   DEPENDENCIES <target>...  beside pipescout::interfaces)
#
# Builds a component library, installs it, and enters its classes into the index by which
# components are found by name:
#   <prefix>/share/ament_index/resource_index/pipescout_components/<project>
# with a line "<class>;<library file, relative to the prefix>" per class.
function(pipescout_add_component target)
  cmake_parse_arguments(PARSE_ARGV 1 arg "EXPORTED" "" "CLASSES;SOURCES;DEPENDENCIES")
  if(NOT arg_CLASSES OR NOT arg_SOURCES)
    message(FATAL_ERROR "pipescout_add_component(${target}) needs CLASSES and SOURCES")
  endif()
  include(GNUInstallDirs)

  add_library(${target} SHARED ${arg_SOURCES})
  target_compile_features(${target} PUBLIC cxx_std_20)
  target_include_directories(${target} PUBLIC
    $<BUILD_INTERFACE:${CMAKE_CURRENT_SOURCE_DIR}/include>
    $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  target_link_libraries(${target} PUBLIC pipescout::interfaces ${arg_DEPENDENCIES})
  target_link_libraries(${target} PRIVATE $<BUILD_INTERFACE:pipescout_class_loader>)
  set_target_properties(${target} PROPERTIES INSTALL_RPATH_USE_LINK_PATH ON)
  pipescout_enable_warnings(${target})

  set(index "")
  foreach(class ${arg_CLASSES})
    string(APPEND index "${class};${CMAKE_INSTALL_LIBDIR}/$<TARGET_FILE_NAME:${target}>\n")
  endforeach()
  set(index_file ${CMAKE_CURRENT_BINARY_DIR}/pipescout_components/${PROJECT_NAME})
  file(GENERATE OUTPUT ${index_file} CONTENT "${index}")
  install(FILES ${index_file}
    DESTINATION ${CMAKE_INSTALL_DATADIR}/ament_index/resource_index/pipescout_components)

  if(arg_EXPORTED)
    string(REGEX REPLACE "^pipescout_" "" name ${target})
    set_target_properties(${target} PROPERTIES EXPORT_NAME ${name})
    install(TARGETS ${target} EXPORT ${PROJECT_NAME}Targets LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
    install(DIRECTORY include/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
    set(cmake_dir ${CMAKE_INSTALL_LIBDIR}/cmake/${PROJECT_NAME})
    install(EXPORT ${PROJECT_NAME}Targets NAMESPACE pipescout:: DESTINATION ${cmake_dir})
    set(config "include(CMakeFindDependencyMacro)\nfind_dependency(pipescout_interfaces)\n")
    foreach(dependency ${arg_DEPENDENCIES})
      string(REGEX REPLACE "^pipescout::" "pipescout_" package ${dependency})
      string(APPEND config "find_dependency(${package})\n")
    endforeach()
    string(APPEND config "include(\"\${CMAKE_CURRENT_LIST_DIR}/${PROJECT_NAME}Targets.cmake\")\n")
    set(config_file ${CMAKE_CURRENT_BINARY_DIR}/${PROJECT_NAME}Config.cmake)
    file(WRITE ${config_file} "${config}")
    install(FILES ${config_file} DESTINATION ${cmake_dir})
  else()
    install(TARGETS ${target} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
  endif()
endfunction()
