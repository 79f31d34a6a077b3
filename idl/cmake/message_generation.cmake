# SPDX-License-Identifier: Apache-2.0
# The build step that writes the C++ of message definitions.

# rosidl's rule for header names: NavSatFix -> nav_sat_fix, TFMessage -> tf_message.
function(pipescout_snake_case camel result)
  string(REGEX REPLACE "(.)([A-Z][a-z]+)" "\\1_\\2" snake "${camel}")
  string(REGEX REPLACE "([a-z0-9])([A-Z])" "\\1_\\2" snake "${snake}")
  string(TOLOWER "${snake}" snake)
  set(${result} "${snake}" PARENT_SCOPE)
endfunction()

# pipescout_message_sources(PACKAGE name FOLDER dir FILES file... OUTPUT_DIR dir
#                           [ROOTS dir...] [DEPENDS file...] HEADERS variable SOURCE variable)
#
# Adds the step that writes the C++ of the FILES, msg/Type.msg, srv/Type.srv, action/Type.action or
# .idl in any of these folders, relative to FOLDER. Sets HEADERS to
# OUTPUT_DIR/PACKAGE/{msg,srv,action}/type.hpp and SOURCE to OUTPUT_DIR/PACKAGE/type_support.cpp.
# ROOTS hold the definitions of other packages, PACKAGE/{msg,srv,action}; DEPENDS are files of those.
# A definition that changes rewrites only what differs.
function(pipescout_message_sources)
  cmake_parse_arguments(PARSE_ARGV 0 ARG "" "PACKAGE;FOLDER;OUTPUT_DIR;HEADERS;SOURCE"
                        "FILES;ROOTS;DEPENDS")
  set(headers)
  foreach(file IN LISTS ARG_FILES)
    cmake_path(GET file PARENT_PATH kind)
    cmake_path(GET file STEM type)
    pipescout_snake_case("${type}" snake)
    list(APPEND headers "${ARG_OUTPUT_DIR}/${ARG_PACKAGE}/${kind}/${snake}.hpp")
  endforeach()
  set(source "${ARG_OUTPUT_DIR}/${ARG_PACKAGE}/type_support.cpp")
  list(TRANSFORM ARG_FILES PREPEND "${ARG_FOLDER}/" OUTPUT_VARIABLE inputs)
  set(roots)
  foreach(root IN LISTS ARG_ROOTS)
    list(APPEND roots --root "${root}")
  endforeach()
  add_custom_command(
    OUTPUT ${headers} "${source}"
    COMMAND pipescout::idl_generator --package "${ARG_PACKAGE}" --folder "${ARG_FOLDER}" ${roots}
            --output "${ARG_OUTPUT_DIR}" ${ARG_FILES}
    DEPENDS ${inputs} ${ARG_DEPENDS} pipescout::idl_generator
    COMMENT "Generating the messages of ${ARG_PACKAGE}"
    VERBATIM)
  set(${ARG_HEADERS} ${headers} PARENT_SCOPE)
  set(${ARG_SOURCE} "${source}" PARENT_SCOPE)
endfunction()
