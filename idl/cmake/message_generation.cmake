# SPDX-License-Identifier: Apache-2.0
# Messages, services and actions of a package, from their definitions.

include(GNUInstallDirs)

# pipescout_generate_messages(TARGET target FILES file... [DEPENDENCIES package...])
#
# Makes the shared library `target` with the types of the FILES: msg/Type.msg, srv/Type.srv,
# action/Type.action, or Type.idl in any of these folders, relative to the current source folder.
# They belong to the ROS package that is named as the project. All types of pipescout_idl can be
# used in them, and those of DEPENDENCIES, packages made in the same way; each is searched with
# find_package().
#
# In the same build, link `target` and include <project/msg/type.hpp>. Installed are
#   the library, the headers (in include/project), the definitions (in share/project)
#   a CMake package: find_package(project), target_link_libraries(... project::target)
#   the entries in the ament index by which tools find the types at run time, those of ROS 2 too
#   package.xml
function(pipescout_generate_messages)
  cmake_parse_arguments(PARSE_ARGV 0 ARG "" "TARGET" "FILES;DEPENDENCIES")
  if(NOT ARG_TARGET OR NOT ARG_FILES)
    message(FATAL_ERROR "pipescout_generate_messages(TARGET target FILES file...)")
  endif()
  if(ARG_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "pipescout_generate_messages: unknown ${ARG_UNPARSED_ARGUMENTS}")
  endif()
  set(package "${PROJECT_NAME}")
  set(output "${CMAKE_CURRENT_BINARY_DIR}/pipescout_messages")
  set(library "${CMAKE_INSTALL_LIBDIR}/${CMAKE_SHARED_LIBRARY_PREFIX}${ARG_TARGET}${CMAKE_SHARED_LIBRARY_SUFFIX}")
  set(roots "${pipescout_idl_IDL_DIR}")
  set(libraries pipescout::idl)
  set(find_dependencies "find_dependency(pipescout_idl)\n")
  foreach(dependency IN LISTS ARG_DEPENDENCIES)
    find_package("${dependency}" REQUIRED)
    list(APPEND roots "${${dependency}_MESSAGES_ROOT}")
    list(APPEND libraries ${${dependency}_MESSAGES_TARGET})
    string(APPEND find_dependencies "find_dependency(${dependency})\n")
  endforeach()
  pipescout_message_sources(
    PACKAGE "${package}" FOLDER "${CMAKE_CURRENT_SOURCE_DIR}" FILES ${ARG_FILES}
    OUTPUT_DIR "${output}" ROOTS ${roots} LIBRARY "${library}" HEADERS headers SOURCE source
    TEXTS texts)

  add_library("${ARG_TARGET}" SHARED "${source}" ${headers})
  add_library("${package}::${ARG_TARGET}" ALIAS "${ARG_TARGET}")
  target_compile_features("${ARG_TARGET}" PUBLIC cxx_std_20)
  target_include_directories("${ARG_TARGET}" SYSTEM PUBLIC
    "$<BUILD_INTERFACE:${output}>"
    "$<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/${package}>")
  target_link_libraries("${ARG_TARGET}" PUBLIC ${libraries} PRIVATE fastcdr)
  set_target_properties("${ARG_TARGET}" PROPERTIES INSTALL_RPATH_USE_LINK_PATH ON)

  set(cmake_dir "${CMAKE_INSTALL_LIBDIR}/cmake/${package}")
  install(TARGETS "${ARG_TARGET}" EXPORT "${package}_messages"
          LIBRARY DESTINATION "${CMAKE_INSTALL_LIBDIR}")
  install(EXPORT "${package}_messages" NAMESPACE "${package}::" DESTINATION "${cmake_dir}")
  file(CONFIGURE OUTPUT "${output}/${package}Config.cmake" @ONLY CONTENT
"get_filename_component(@package@_MESSAGES_ROOT \"\${CMAKE_CURRENT_LIST_DIR}\" REALPATH)
string(REGEX REPLACE \"/@cmake_dir@$\" \"/@CMAKE_INSTALL_DATADIR@\"
       @package@_MESSAGES_ROOT \"\${@package@_MESSAGES_ROOT}\")
set(@package@_MESSAGES_TARGET @package@::@ARG_TARGET@)
include(CMakeFindDependencyMacro)
@find_dependencies@include(\"\${CMAKE_CURRENT_LIST_DIR}/@package@_messages.cmake\")
")
  install(FILES "${output}/${package}Config.cmake" DESTINATION "${cmake_dir}")
  foreach(file header IN ZIP_LISTS ARG_FILES headers)
    cmake_path(GET file PARENT_PATH kind)
    install(FILES "${header}"
            DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}/${package}/${package}/${kind}")
  endforeach()
  pipescout_install_definitions(
    PACKAGE "${package}" FOLDER "${CMAKE_CURRENT_SOURCE_DIR}" FILES ${ARG_FILES} TEXTS ${texts}
    MANIFEST "${CMAKE_CURRENT_SOURCE_DIR}/package.xml")
  install(FILES "${output}/${package}/pipescout_messages" RENAME "${package}"
          DESTINATION "${CMAKE_INSTALL_DATADIR}/ament_index/resource_index/pipescout_messages")
endfunction()

# pipescout_install_definitions(PACKAGE name FOLDER dir FILES file... [TEXTS file...] MANIFEST file)
#
# Installs the definitions FILES, relative to FOLDER, and TEXTS, their .msg, .srv and .action forms,
# where ROS 2 has those of a package, and enters the package into the ament index: `ros2 interface`
# lists and shows them. MANIFEST is installed as its package.xml.
function(pipescout_install_definitions)
  cmake_parse_arguments(PARSE_ARGV 0 ARG "" "PACKAGE;FOLDER;MANIFEST" "FILES;TEXTS")
  set(share "${CMAKE_INSTALL_DATADIR}/${ARG_PACKAGE}")
  set(index "${CMAKE_INSTALL_DATADIR}/ament_index/resource_index")
  list(TRANSFORM ARG_FILES PREPEND "${ARG_FOLDER}/" OUTPUT_VARIABLE installed)
  list(APPEND installed ${ARG_TEXTS})
  set(names "")
  foreach(file IN LISTS installed)
    cmake_path(GET file PARENT_PATH folder)
    cmake_path(GET folder FILENAME kind)
    cmake_path(GET file FILENAME name)
    install(FILES "${file}" DESTINATION "${share}/${kind}")
    list(APPEND names "${kind}/${name}")
  endforeach()
  list(SORT names)
  list(JOIN names "\n" names)
  set(entries "${CMAKE_CURRENT_BINARY_DIR}/ament_index/${ARG_PACKAGE}")
  file(CONFIGURE OUTPUT "${entries}/packages" CONTENT "" @ONLY)
  file(CONFIGURE OUTPUT "${entries}/rosidl_interfaces" CONTENT "@names@\n" @ONLY)
  foreach(entry IN ITEMS packages rosidl_interfaces)
    install(FILES "${entries}/${entry}" RENAME "${ARG_PACKAGE}" DESTINATION "${index}/${entry}")
  endforeach()
  install(FILES "${ARG_MANIFEST}" RENAME package.xml DESTINATION "${share}")
endfunction()

# rosidl's rule for header names: NavSatFix -> nav_sat_fix, TFMessage -> tf_message.
function(pipescout_snake_case camel result)
  string(REGEX REPLACE "(.)([A-Z][a-z]+)" "\\1_\\2" snake "${camel}")
  string(REGEX REPLACE "([a-z0-9])([A-Z])" "\\1_\\2" snake "${snake}")
  string(TOLOWER "${snake}" snake)
  set(${result} "${snake}" PARENT_SCOPE)
endfunction()

# pipescout_message_sources(PACKAGE name FOLDER dir FILES file... OUTPUT_DIR dir
#                           [ROOTS dir...] [DEPENDS file...] [LIBRARY path]
#                           HEADERS variable SOURCE variable [TEXTS variable])
#
# Adds the step that writes the C++ of the FILES, relative to FOLDER. Sets HEADERS to
# OUTPUT_DIR/PACKAGE/{msg,srv,action}/type.hpp and SOURCE to OUTPUT_DIR/PACKAGE/type_support.cpp, TEXTS
# to what definitions in IDL are in .msg, .srv and .action: OUTPUT_DIR/PACKAGE/msg/Type.msg.
# ROOTS hold the definitions of other packages, PACKAGE/{msg,srv,action}; DEPENDS are files of those.
# LIBRARY: where the library will be, relative to the prefix; the list of types for the ament index
# is then written to OUTPUT_DIR/PACKAGE/pipescout_messages. A definition that changes rewrites only
# what differs.
function(pipescout_message_sources)
  cmake_parse_arguments(PARSE_ARGV 0 ARG "" "PACKAGE;FOLDER;OUTPUT_DIR;LIBRARY;HEADERS;SOURCE;TEXTS"
                        "FILES;ROOTS;DEPENDS")
  set(headers)
  set(texts)
  foreach(file IN LISTS ARG_FILES)
    cmake_path(GET file PARENT_PATH kind)
    cmake_path(GET file STEM type)
    pipescout_snake_case("${type}" snake)
    list(APPEND headers "${ARG_OUTPUT_DIR}/${ARG_PACKAGE}/${kind}/${snake}.hpp")
    if(file MATCHES "\\.idl$")
      list(APPEND texts "${ARG_OUTPUT_DIR}/${ARG_PACKAGE}/${kind}/${type}.${kind}")
    endif()
  endforeach()
  set(source "${ARG_OUTPUT_DIR}/${ARG_PACKAGE}/type_support.cpp")
  set(outputs ${headers} ${texts} "${source}")
  list(TRANSFORM ARG_FILES PREPEND "${ARG_FOLDER}/" OUTPUT_VARIABLE inputs)
  set(options)
  foreach(root IN LISTS ARG_ROOTS)
    list(APPEND options --root "${root}")
  endforeach()
  if(ARG_LIBRARY)
    list(APPEND options --library "${ARG_LIBRARY}")
    list(APPEND outputs "${ARG_OUTPUT_DIR}/${ARG_PACKAGE}/pipescout_messages")
  endif()
  add_custom_command(
    OUTPUT ${outputs}
    COMMAND pipescout::idl_generator cpp --package "${ARG_PACKAGE}" --folder "${ARG_FOLDER}" ${options}
            --output "${ARG_OUTPUT_DIR}" ${ARG_FILES}
    DEPENDS ${inputs} ${ARG_DEPENDS} pipescout::idl_generator
    COMMENT "Generating the messages of ${ARG_PACKAGE}"
    VERBATIM)
  set(${ARG_HEADERS} ${headers} PARENT_SCOPE)
  set(${ARG_SOURCE} "${source}" PARENT_SCOPE)
  if(ARG_TEXTS)
    set(${ARG_TEXTS} ${texts} PARENT_SCOPE)
  endif()
endfunction()

# pipescout_merged_idl(<output>.idl)
#
# Adds the step that writes one .idl file with all types of pipescout_idl, for the compilers of other
# DDS vendors.
function(pipescout_merged_idl output)
  set(definitions)
  set(types)
  foreach(kind IN ITEMS msg srv action)
    file(GLOB files CONFIGURE_DEPENDS RELATIVE "${pipescout_idl_IDL_DIR}"
         "${pipescout_idl_IDL_DIR}/*/${kind}/*.idl" "${pipescout_idl_IDL_DIR}/*/${kind}/*.${kind}")
    list(APPEND definitions ${files})
  endforeach()
  list(TRANSFORM definitions REPLACE "\\.[a-z]+$" "" OUTPUT_VARIABLE types)
  list(TRANSFORM definitions PREPEND "${pipescout_idl_IDL_DIR}/")
  add_custom_command(
    OUTPUT "${output}"
    COMMAND pipescout::idl_generator idl --root "${pipescout_idl_IDL_DIR}" --output "${output}"
            ${types}
    DEPENDS ${definitions} pipescout::idl_generator
    COMMENT "Merging all messages into one file"
    VERBATIM)
endfunction()
