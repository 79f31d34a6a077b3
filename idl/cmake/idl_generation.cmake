# SPDX-License-Identifier: Apache-2.0
# What the build makes of .idl files. Everything is derived from their paths, PACKAGE/KIND/Type.idl
# with KIND msg or srv, below one folder.

set(_idl_generation_dir "${CMAKE_CURRENT_LIST_DIR}")

# rosidl's rule for header names: NavSatFix -> nav_sat_fix, TFMessage -> tf_message.
function(idl_snake_case camel result)
  string(REGEX REPLACE "(.)([A-Z][a-z]+)" "\\1_\\2" snake "${camel}")
  string(REGEX REPLACE "([a-z0-9])([A-Z])" "\\1_\\2" snake "${snake}")
  string(TOLOWER "${snake}" snake)
  set(${result} "${snake}" PARENT_SCOPE)
endfunction()

# idl_generate(OUTPUT_DIR dir IDL_DIR dir FILES file...)
#
# Adds, for each FILE (relative to IDL_DIR), the build step that runs fastddsgen for that file alone
# and writes OUTPUT_DIR/PACKAGE/KIND/Type.{h,cxx}. The code that is generated for a type names the
# types of the files that it includes, and takes nothing else from them, so only the file itself is
# a dependency of its step: touching one file regenerates one. What uses it is recompiled through
# the included headers.
function(idl_generate)
  cmake_parse_arguments(PARSE_ARGV 0 ARG "" "OUTPUT_DIR;IDL_DIR" "FILES")
  find_program(FASTDDSGEN fastddsgen REQUIRED)
  foreach(file IN LISTS ARG_FILES)
    cmake_path(REMOVE_EXTENSION file OUTPUT_VARIABLE base)
    add_custom_command(
      OUTPUT "${ARG_OUTPUT_DIR}/${base}.h" "${ARG_OUTPUT_DIR}/${base}.cxx"
      COMMAND "${CMAKE_COMMAND}" "-DFASTDDSGEN=${FASTDDSGEN}" "-DIDL_DIR=${ARG_IDL_DIR}"
              "-DIDL_FILE=${file}" "-DOUTPUT_DIR=${ARG_OUTPUT_DIR}"
              -P "${_idl_generation_dir}/run_fastddsgen.cmake"
      DEPENDS "${ARG_IDL_DIR}/${file}" "${_idl_generation_dir}/run_fastddsgen.cmake"
      COMMENT "Generating ${base}"
      VERBATIM)
  endforeach()
endfunction()

# idl_type_support(OUTPUT_DIR dir TEMPLATE_DIR dir FILES file...)
#
# Writes, at configure time, the type support of each FILE: OUTPUT_DIR/PACKAGE/KIND/type.{hpp,cpp},
# and OUTPUT_DIR/registry.cpp with the table of all of them.
function(idl_type_support)
  cmake_parse_arguments(PARSE_ARGV 0 ARG "" "OUTPUT_DIR;TEMPLATE_DIR" "FILES")
  set(messages)
  foreach(idl_file IN LISTS ARG_FILES)
    cmake_path(REMOVE_EXTENSION idl_file OUTPUT_VARIABLE name)
    string(REPLACE "/" ";" parts "${name}")
    list(GET parts 0 package)
    list(GET parts 1 kind)
    list(GET parts 2 type)
    set(base "${type}")
    set(namespace "${package}::${kind}")
    set(class "${namespace}::${type}")
    set(dds_name "${namespace}::dds_::${type}_")
    idl_snake_case("${type}" snake_base)
    set(template message)
    if(kind STREQUAL "srv")
      set(template service)
      list(APPEND messages "${name}_Request" "${name}_Response")
    else()
      list(APPEND messages "${name}")
    endif()
    foreach(extension IN ITEMS hpp cpp)
      configure_file("${ARG_TEMPLATE_DIR}/${template}.${extension}.in"
                     "${ARG_OUTPUT_DIR}/${package}/${kind}/${snake_base}.${extension}" @ONLY)
    endforeach()
  endforeach()

  list(SORT messages)
  list(LENGTH messages count)
  set(forward_declarations)
  set(specialisations)
  set(entries)
  foreach(message IN LISTS messages)
    string(REPLACE "/" "::" class "${message}")
    string(REGEX MATCH "^(.*)::([^:]+)$" _ "${class}")
    string(APPEND forward_declarations "namespace ${CMAKE_MATCH_1} { class ${CMAKE_MATCH_2}; }\n")
    string(APPEND specialisations "template <> const MessageType& message_type<${class}>();\n")
    string(APPEND entries "      &message_type<${class}>(),\n")
  endforeach()
  configure_file("${ARG_TEMPLATE_DIR}/registry.cpp.in" "${ARG_OUTPUT_DIR}/registry.cpp" @ONLY)
endfunction()
