# SPDX-License-Identifier: Apache-2.0
# Generates the C++ class of one .idl file. Run by the build:
#   cmake -DFASTDDSGEN=program -DIDL_DIR=dir -DIDL_FILE=PACKAGE/KIND/Type.idl -DOUTPUT_DIR=dir
#         -P run_fastddsgen.cmake
# writes OUTPUT_DIR/PACKAGE/KIND/Type.h and Type.cxx.
cmake_minimum_required(VERSION 3.22)

cmake_path(REMOVE_EXTENSION IDL_FILE OUTPUT_VARIABLE base)
cmake_path(GET base FILENAME type)
set(scratch "${OUTPUT_DIR}/scratch/${base}")
file(REMOVE_RECURSE "${scratch}")
file(MAKE_DIRECTORY "${scratch}")

# Without these the virtual machine spends half of its second on compiling itself.
set(ENV{JAVA_TOOL_OPTIONS} "$ENV{JAVA_TOOL_OPTIONS} -XX:TieredStopAtLevel=1 -XX:+UseSerialGC")
execute_process(
  COMMAND "${FASTDDSGEN}" -typeros2 -cs -replace -I . -d "${scratch}" -t "${scratch}" "${IDL_FILE}"
  WORKING_DIRECTORY "${IDL_DIR}"
  RESULT_VARIABLE result
  OUTPUT_VARIABLE output
  ERROR_VARIABLE output)

function(fail reason)
  string(ASCII 27 escape)
  string(REGEX REPLACE "${escape}\\[[0-9;]*m" "" text "${output}")
  string(REGEX REPLACE "(^|\n)Picked up JAVA_TOOL_OPTIONS[^\n]*\n" "\\1" text "${text}")
  # Indented, so that CMake leaves the lines as they are.
  string(REPLACE "\n" "\n  " text "\n${text}")
  message(FATAL_ERROR "${IDL_FILE}: ${reason}${text}")
endfunction()

# fastddsgen can report an error and still exit with 0.
if(NOT result EQUAL 0 OR output MATCHES "(error|ERROR|Exception)[^\n]*:")
  fail("fastddsgen failed (${result})")
endif()
foreach(extension IN ITEMS .h .cxx PubSubTypes.cxx)
  if(NOT EXISTS "${scratch}/${type}${extension}")
    fail("fastddsgen wrote no ${type}${extension}")
  endif()
endforeach()

# Dependencies between files are not tracked (see idl_generate), which structures and constants need
# not, as the generated code only names them.
file(READ "${IDL_DIR}/${IDL_FILE}" idl)
if(idl MATCHES "\n *(typedef|enum|union|bitmask|bitset) ")
  fail("${CMAKE_MATCH_1} is not supported; ROS 2 messages are made of structures and constants")
endif()

# The file must hold the type that its path promises.
string(REPLACE "/" "::" class "${base}")
string(REGEX REPLACE "::${type}$" "::dds_::${type}_" dds_name "${class}")
set(dds_names "${dds_name}")
if(base MATCHES "/srv/")
  set(dds_names "${dds_name}Request_" "${dds_name}Response_")
endif()
file(READ "${scratch}/${type}PubSubTypes.cxx" topic_types)
foreach(dds_name IN LISTS dds_names)
  string(FIND "${topic_types}" "setName(\"${dds_name}\")" position)
  if(position EQUAL -1)
    fail("does not define the type that DDS calls ${dds_name}")
  endif()
endforeach()

file(READ "${scratch}/${type}.h" header)
file(READ "${scratch}/${type}.cxx" source)

# Bounded strings would be a class of Fast DDS, whose headers nobody should need for a message. They
# are the same on the wire as unbounded ones.
if(header MATCHES "fixed_string")
  fail("has a bounded string; declare it as string and state the bound in a comment")
endif()
string(REPLACE "#include <fastrtps/utils/fixed_size_string.hpp>\n" "" header "${header}")

# fastcdr trusts the length of a sequence: read through the functions that do not.
string(REGEX REPLACE "dcdr >> (m_[A-Za-z0-9_]+);" "pipescout::idl::read(dcdr, \\1);"
       source "${source}")
string(REPLACE "#include <fastcdr/Cdr.h>\n" "#include \"bounded_reading.hpp\"\n" source "${source}")
if(source MATCHES "dcdr >>" OR NOT source MATCHES "bounded_reading.hpp")
  fail("fastddsgen reads a field in a form that this step does not know")
endif()

# Addresses of Java objects differ from run to run; without them the output is reproducible.
string(REGEX REPLACE "\n *// m_[A-Za-z0-9_]+ com\\.eprosima\\.[^\n]*" "" source "${source}")

file(WRITE "${OUTPUT_DIR}/${base}.h" "${header}")
file(WRITE "${OUTPUT_DIR}/${base}.cxx" "${source}")
file(REMOVE_RECURSE "${scratch}")
