# SPDX-License-Identifier: Apache-2.0
# cmake -DSOURCE=<folder> -DOUTPUT=<file> -P write_revision.cmake: a header with the git revision that
# is checked out there; empty outside of a repository. Rewritten only when it has changed.
cmake_minimum_required(VERSION 3.22)
execute_process(
  COMMAND git describe --always --abbrev=40 --exclude=* --dirty=-changed
  WORKING_DIRECTORY ${SOURCE}
  OUTPUT_VARIABLE revision OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE failed)
if(failed)
  set(revision "")
endif()
file(CONFIGURE OUTPUT ${OUTPUT} CONTENT
"// SPDX-License-Identifier: Apache-2.0
#pragma once
/// Of the sources, 40 hexadecimal digits, \"-changed\" if files differ from it; empty: not known.
#define PIPESCOUT_REVISION \"${revision}\"
" @ONLY)
