#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# What run.sh and sanitize.sh ask of packages, to be sourced in the root of the project: colcon only
# warns of a name that it does not know, and tests its packages by themselves, where locks between
# tests do not hold.

# packages: the names of all.
packages() { colcon --log-base /dev/null list --names-only; }

# require_packages PACKAGE...: ends the script with 2 unless there are packages of these names.
require_packages() {
  local known name
  known=$(packages)
  for name in "$@"; do
    if ! grep -qxF -e "$name" <<<"$known"; then
      echo "${0##*/}: no package '$name'; there are:" >&2
      echo "$known" >&2
      exit 2
    fi
  done
}

# run_tests BASE PACKAGE...: runs the tests of packages that were built in BASE/build and installed in
# BASE/install, side by side, in one run of ctest; test/results.py says what came out. Fails when a
# test did, or a package was not built.
run_tests() {
  local base=$1 build=$1/build name untold=()
  shift
  # Results of earlier runs must not count.
  rm -rf "$build"/*/test_results "$build/ctest_results.xml"
  : >"$build/CTestTestfile.cmake"
  for name in "$@"; do
    if [ -f "$build/$name/CTestTestfile.cmake" ]; then
      echo "subdirs($name)" >>"$build/CTestTestfile.cmake"
    else
      untold+=("$name")
    fi
  done
  (
    # The script that colcon writes reads variables that may not be set.
    set +u
    # shellcheck source=/dev/null
    source "$base/install/local_setup.bash"
    ctest --test-dir "$build" --parallel "$(nproc)" --timeout 300 --output-junit ctest_results.xml \
      --test-output-size-passed 1 --test-output-size-failed 200000
  ) || true # the results tell
  if [ ${#untold[@]} -ne 0 ]; then
    echo "not built: ${untold[*]}"
  fi
  "$(dirname "${BASH_SOURCE[0]}")/results.py" "$build" && [ ${#untold[@]} -eq 0 ]
}
