# SPDX-License-Identifier: Apache-2.0

# pipescout_export_target(<target>)
#
# Installs a library or an executable as part of what pipescout_export_package() exports. An executable
# can be started by `ros2 run <project> <name>`, too.
function(pipescout_export_target target)
  # Tells the packages that link it which package to look for: see pipescout_export_package().
  set_target_properties(${target} PROPERTIES PIPESCOUT_PACKAGE ${PROJECT_NAME}
    EXPORT_PROPERTIES PIPESCOUT_PACKAGE)
  install(TARGETS ${target} EXPORT ${PROJECT_NAME}Targets
    LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}
    RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
  set_property(DIRECTORY ${PROJECT_SOURCE_DIR} APPEND PROPERTY PIPESCOUT_EXPORTED ${target})
  get_target_property(type ${target} TYPE)
  if(type STREQUAL "EXECUTABLE")
    _pipescout_index_executable(${target})
  endif()
endfunction()

# The packages of the project that users of this one's targets need: those of its public dependencies.
function(_pipescout_packages_of_dependencies result)
  get_property(targets DIRECTORY ${PROJECT_SOURCE_DIR} PROPERTY PIPESCOUT_EXPORTED)
  set(packages)
  foreach(target IN LISTS targets)
    get_target_property(dependencies ${target} INTERFACE_LINK_LIBRARIES)
    foreach(dependency IN LISTS dependencies)
      if(TARGET "${dependency}")
        get_target_property(package ${dependency} PIPESCOUT_PACKAGE)
        if(package)
          list(APPEND packages ${package})
        endif()
      endif()
    endforeach()
  endforeach()
  list(REMOVE_DUPLICATES packages)
  list(REMOVE_ITEM packages ${PROJECT_NAME})
  list(SORT packages)
  set(${result} ${packages} PARENT_SCOPE)
endfunction()

# pipescout_export_package(
#   [DEPENDENCIES <package>...]       what find_package() needs to find for users of the targets,
#                                     a version with it: "Eigen3 3.4". Packages of this project are
#                                     known from what the targets link
#   [DATA <file or folder>...])       installed to share/<project>; <project>_DATA_DIR is where
#
# Installs the public headers, what find_package(<project>) needs, and the package's entry in the ament
# index. Closes the list of what a package exports.
function(pipescout_export_package)
  cmake_parse_arguments(PARSE_ARGV 0 arg "" "" "DEPENDENCIES;DATA")
  if(arg_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "pipescout_export_package: ${arg_UNPARSED_ARGUMENTS}?")
  endif()
  include(CMakePackageConfigHelpers)
  set(cmake_dir ${CMAKE_INSTALL_LIBDIR}/cmake/${PROJECT_NAME})
  set(config ${CMAKE_CURRENT_BINARY_DIR}/${PROJECT_NAME}Config.cmake)
  set(version ${CMAKE_CURRENT_BINARY_DIR}/${PROJECT_NAME}ConfigVersion.cmake)
  set(data_dir ${CMAKE_INSTALL_DATADIR}/${PROJECT_NAME})

  _pipescout_packages_of_dependencies(packages)
  set(find_dependencies "")
  foreach(package IN LISTS packages arg_DEPENDENCIES)
    string(APPEND find_dependencies "find_dependency(${package})\n")
  endforeach()
  set(data_dir_line "")
  if(arg_DATA)
    # Before the dependencies: their own files may set PACKAGE_PREFIX_DIR anew.
    set(data_dir_line "set_and_check(${PROJECT_NAME}_DATA_DIR \"\${PACKAGE_PREFIX_DIR}/${data_dir}\")\n")
  endif()
  configure_package_config_file(
    ${CMAKE_CURRENT_FUNCTION_LIST_DIR}/pipescout_package_config.cmake.in ${config}
    INSTALL_DESTINATION ${cmake_dir})
  write_basic_package_version_file(${version} COMPATIBILITY SameMinorVersion)

  if(IS_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR}/include)
    install(DIRECTORY include/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
  endif()
  foreach(each IN LISTS arg_DATA)
    if(IS_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR}/${each})
      install(DIRECTORY ${each} DESTINATION ${data_dir})
    else()
      install(FILES ${each} DESTINATION ${data_dir})
    endif()
  endforeach()
  install(EXPORT ${PROJECT_NAME}Targets NAMESPACE pipescout:: DESTINATION ${cmake_dir})
  install(FILES ${config} ${version} DESTINATION ${cmake_dir})
  pipescout_index_package()
endfunction()
