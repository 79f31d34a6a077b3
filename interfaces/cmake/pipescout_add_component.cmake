# pipescout_add_component(<target>
#   CLASSES <class>...        component classes that the library registers, fully qualified
#   SOURCES <file>...
#   DEPENDENCIES <target>...  beside pipescout::interfaces)
#
# Builds a component library, installs it, and enters its classes into the index by which
# components are found by name:
#   <prefix>/share/ament_index/resource_index/pipescout_components/<project>
# with a line "<class>;<library file, relative to the prefix>" per class.
function(pipescout_add_component target)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "CLASSES;SOURCES;DEPENDENCIES")
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
  install(TARGETS ${target} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})

  set(index "")
  foreach(class ${arg_CLASSES})
    string(APPEND index "${class};${CMAKE_INSTALL_LIBDIR}/$<TARGET_FILE_NAME:${target}>\n")
  endforeach()
  set(index_file ${CMAKE_CURRENT_BINARY_DIR}/pipescout_components/${PROJECT_NAME})
  file(GENERATE OUTPUT ${index_file} CONTENT "${index}")
  install(FILES ${index_file}
    DESTINATION ${CMAKE_INSTALL_DATADIR}/ament_index/resource_index/pipescout_components)
  # By this marker colcon knows that the prefix belongs into AMENT_PREFIX_PATH.
  file(WRITE ${CMAKE_CURRENT_BINARY_DIR}/packages/${PROJECT_NAME} "")
  install(FILES ${CMAKE_CURRENT_BINARY_DIR}/packages/${PROJECT_NAME}
    DESTINATION ${CMAKE_INSTALL_DATADIR}/ament_index/resource_index/packages)
endfunction()
