# What the CMakeLists.txt of a package with components is made of. Everything that these functions
# build is installed, and exported as pipescout::<name>; pipescout_export_package() closes the list.

# pipescout_add_library(<target> SOURCES <file>... [DEPENDENCIES <target>...])
#
# A shared library with its public headers in include/, known as pipescout::<name> when <target> is
# pipescout_<name>. DEPENDENCIES are public.
function(pipescout_add_library target)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "SOURCES;DEPENDENCIES")
  include(GNUInstallDirs)
  string(REGEX REPLACE "^pipescout_" "" name ${target})

  add_library(${target} SHARED ${arg_SOURCES})
  add_library(pipescout::${name} ALIAS ${target})
  target_compile_features(${target} PUBLIC cxx_std_20)
  target_include_directories(${target} PUBLIC
    $<BUILD_INTERFACE:${CMAKE_CURRENT_SOURCE_DIR}/include>
    $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  target_link_libraries(${target} PUBLIC ${arg_DEPENDENCIES})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${name}
    INSTALL_RPATH "$ORIGIN" INSTALL_RPATH_USE_LINK_PATH ON)
  pipescout_enable_warnings(${target})
  install(TARGETS ${target} EXPORT ${PROJECT_NAME}Targets
    LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
endfunction()

# pipescout_add_component(<target>
#   CLASSES <class>...         component classes that the library registers, fully qualified
#   SOURCES <file>...
#   [DEPENDENCIES <target>...] beside pipescout::runtime and pipescout::catalogue)
#
# Such a library with components, which are entered into the index by which they are found by name:
#   <prefix>/share/ament_index/resource_index/pipescout_components/<project>
# with a line "<class>;<library file, relative to the prefix>" per class.
function(pipescout_add_component target)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "CLASSES;SOURCES;DEPENDENCIES")
  if(NOT arg_CLASSES OR NOT arg_SOURCES)
    message(FATAL_ERROR "pipescout_add_component(${target}) needs CLASSES and SOURCES")
  endif()
  include(GNUInstallDirs)
  pipescout_add_library(${target}
    SOURCES ${arg_SOURCES}
    DEPENDENCIES pipescout::runtime pipescout::catalogue ${arg_DEPENDENCIES})
  target_link_libraries(${target} PRIVATE $<BUILD_INTERFACE:pipescout_class_loader>)

  set(index "")
  foreach(class ${arg_CLASSES})
    string(APPEND index "${class};${CMAKE_INSTALL_LIBDIR}/$<TARGET_FILE_NAME:${target}>\n")
  endforeach()
  set(index_file ${CMAKE_CURRENT_BINARY_DIR}/pipescout_components/${PROJECT_NAME})
  file(GENERATE OUTPUT ${index_file} CONTENT "${index}")
  install(FILES ${index_file}
    DESTINATION ${CMAKE_INSTALL_DATADIR}/ament_index/resource_index/pipescout_components)
endfunction()

# pipescout_export_package([DEPENDENCIES <package>...])
#
# Installs the package's public headers and package.xml, and what find_package(<project>) needs.
# DEPENDENCIES: the packages that users of its targets need, beside pipescout_runtime, and for components
# pipescout_catalogue.
function(pipescout_export_package)
  cmake_parse_arguments(PARSE_ARGV 0 arg "" "" "DEPENDENCIES")
  include(CMakePackageConfigHelpers)
  include(GNUInstallDirs)
  set(cmake_dir ${CMAKE_INSTALL_LIBDIR}/cmake/${PROJECT_NAME})
  set(config ${CMAKE_CURRENT_BINARY_DIR}/${PROJECT_NAME}Config.cmake)
  set(version ${CMAKE_CURRENT_BINARY_DIR}/${PROJECT_NAME}ConfigVersion.cmake)

  set(content "include(CMakeFindDependencyMacro)\n")
  set(packages pipescout_runtime)
  if(pipescout_catalogue_FOUND)
    list(APPEND packages pipescout_catalogue)
  endif()
  foreach(package ${packages} ${arg_DEPENDENCIES})
    string(APPEND content "find_dependency(${package})\n")
  endforeach()
  string(APPEND content "include(\"\${CMAKE_CURRENT_LIST_DIR}/${PROJECT_NAME}Targets.cmake\")\n")
  file(WRITE ${config} "${content}")
  write_basic_package_version_file(${version} COMPATIBILITY SameMinorVersion)

  if(IS_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR}/include)
    install(DIRECTORY include/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
  endif()
  install(EXPORT ${PROJECT_NAME}Targets NAMESPACE pipescout:: DESTINATION ${cmake_dir})
  install(FILES ${config} ${version} DESTINATION ${cmake_dir})
  install(FILES package.xml DESTINATION ${CMAKE_INSTALL_DATADIR}/${PROJECT_NAME})
endfunction()
