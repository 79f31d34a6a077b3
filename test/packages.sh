#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# What run.sh and sanitize.sh ask of packages, to be sourced in the root of the project: colcon only
# warns of a name that it does not know, and says nothing of tests that never ran.

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

# forget_results BUILD_BASE: results of earlier runs must not count.
forget_results() {
  if [ -d "$1" ]; then
    find "$1" -type d -name Testing -prune -exec rm -rf {} +
  fi
}

# without_results BUILD_BASE PACKAGE...: names those that were not built, or that have tests but left
# no result.
without_results() {
  local base=$1 name tests
  shift
  for name in "$@"; do
    if ! tests=$(ctest --test-dir "$base/$name" --show-only 2>/dev/null |
      awk '/^Total Tests:/ { print $3 }'); then
      echo "$name"
    elif [ "${tests:-0}" -ne 0 ] && ! compgen -G "$base/$name/Testing/*/Test.xml" >/dev/null; then
      echo "$name"
    fi
  done
}
