#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# A compiler launcher: runs the compiler and appends "<CPU seconds> <object file>" to the file that
# COMPILE_TIMES names. Of build_benchmark.py.
"$@"
result=$?
object=
for ((i = 1; i < $#; ++i)); do
  if [ "${!i}" = -o ]; then
    next=$((i + 1))
    object=${!next}
  fi
done
# Into a file: in a pipe the shell would report the times of another process. Its second line is
# that of the children, "0m1.200s 0m0.050s".
own=$(mktemp "$COMPILE_TIMES.XXXXXX")
times >"$own"
{ read -r _ && read -r user system; } <"$own"
rm -f "$own"
printf '%s %s %s\n' "$user" "$system" "$PWD/$object" >>"$COMPILE_TIMES"
exit $result
