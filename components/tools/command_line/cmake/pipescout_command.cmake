# SPDX-License-Identifier: Apache-2.0

# pipescout_add_command(<name> <summary> [SOURCES <file>...] [DEPENDENCIES <target>...])
#
# The executable pipescout-<name>, which `pipescout` runs as `pipescout <name>`; the target is
# pipescout_<name>_command. <summary>, one line, goes into the list of commands that `pipescout --help`
# shows; the sources, src/main.cpp by default, see it as PIPESCOUT_SUMMARY. They call command_main(), which answers
# a shell that completes words, and so the list says. Installed and exported by pipescout_export_package().
function(pipescout_add_command name summary)
  cmake_parse_arguments(PARSE_ARGV 2 arg "" "" "SOURCES;DEPENDENCIES")
  if(NOT arg_SOURCES)
    set(arg_SOURCES src/main.cpp)
  endif()
  set(target pipescout_${name}_command)
  add_executable(${target} ${arg_SOURCES})
  set_target_properties(${target} PROPERTIES OUTPUT_NAME pipescout-${name})
  target_compile_definitions(${target} PRIVATE PIPESCOUT_SUMMARY="${summary}"
    PIPESCOUT_VERSION="${PROJECT_VERSION}")
  target_link_libraries(${target} PRIVATE pipescout::command_line ${arg_DEPENDENCIES})
  pipescout_enable_warnings(${target})
  pipescout_optimise_lightly(${target})
  pipescout_compile_together(${target})
  pipescout_export_target(${target})

  set(summary_file ${CMAKE_CURRENT_BINARY_DIR}/pipescout_commands/${name})
  file(CONFIGURE OUTPUT ${summary_file} CONTENT "${summary}\ncompletion\n" @ONLY)
  install(FILES ${summary_file} DESTINATION ${CMAKE_INSTALL_DATADIR}/pipescout/commands)
endfunction()
