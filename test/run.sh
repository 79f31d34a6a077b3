#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Installs what is missing, builds everything in Release (with warnings as errors where CI is set),
# and runs every test.
#
#   test/run.sh                     all packages
#   test/run.sh PACKAGE...          these packages and what they need
#
# Closes with "N passed, N failed, N skipped". Exits with 0 when everything built, ran and passed, with
# 2 for a package that there is not, else with another code.
set -euo pipefail
unset CDPATH
cd "$(dirname "${BASH_SOURCE[0]}")/.."

case "${1:-}" in
  -h | --help)
    sed -n '3,10s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"
    exit 0
    ;;
esac

launch_scripts/setup.sh
source test/packages.sh

select_build=() select_test=()
if [ $# -gt 0 ]; then
  require_packages "$@"
  select_build=(--packages-up-to "$@")
  select_test=(--packages-select "$@")
fi

# Tests speak DDS on loopback and shared memory only.
export ROS_LOCALHOST_ONLY=1

# Without this colcon limits the build by the load of the machine, and another job starves it.
export MAKEFLAGS=${MAKEFLAGS:--j$(nproc)}

step() { printf '\n== %s (%s)\n' "$1" "$(date -u +%H:%M:%S)"; }

step "Building"
colcon build --event-handlers console_start_end+ "${select_build[@]}" \
  --cmake-args -DCMAKE_BUILD_TYPE=Release -DBUILD_TESTING=ON \
  "-DCMAKE_PROJECT_INCLUDE=$PWD/test/light_tests.cmake" \
  ${CI:+-DCMAKE_COMPILE_WARNING_AS_ERROR=ON}

step "Testing"
forget_results build
colcon_failed=false
# Its own failures only: what tests say is read from their results.
colcon test --event-handlers console_start_end+ "${select_test[@]}" --ctest-args --timeout 300 ||
  colcon_failed=true

step "Results"
# colcon says "Summary: T tests, E errors, F failures, S skipped".
results=$(colcon test-result --all || true)
texts=$(colcon test-result --verbose || true)
tail -n 200 <<<"$texts"
read -r tests errors failures skipped < <(awk '/^Summary:/ {
  gsub(",", ""); print $2, $4, $6, $8 }' <<<"$results") || true
mapfile -t tested < <(if [ $# -gt 0 ]; then printf '%s\n' "$@"; else packages; fi)
mapfile -t untold < <(without_results build "${tested[@]}")
if [ ${#untold[@]} -ne 0 ]; then
  echo "no results of ${untold[*]}"
fi
if $colcon_failed; then
  echo "colcon test failed"
fi
if [ -z "${tests:-}" ] || [ "$tests" -eq 0 ]; then
  echo "no test ran"
  echo "0 passed, 0 failed"
  exit 1
fi
failed=$((errors + failures))
if [ "$failed" -ne 0 ]; then
  echo "failed, by name:"
  grep '^- ' <<<"$texts" || true
fi
echo "$((tests - failed - skipped)) passed, $failed failed, $skipped skipped"
[ "$failed" -eq 0 ] && [ ${#untold[@]} -eq 0 ] && ! $colcon_failed
