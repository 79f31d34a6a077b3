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
test/interoperability/bag_readers/install.sh
source launch_scripts/build_environment.sh
source test/packages.sh

select_build=()
if [ $# -gt 0 ]; then
  require_packages "$@"
  select_build=(--packages-up-to "$@")
  tested=("$@")
else
  mapfile -t tested < <(packages)
fi

step() { printf '\n== %s (%s)\n' "$1" "$(date -u +%H:%M:%S)"; }

step "Building"
colcon build --event-handlers console_start_end+ "${select_build[@]}" \
  --cmake-args -DCMAKE_BUILD_TYPE=Release -DBUILD_TESTING=ON \
  ${CI:+-DCMAKE_COMPILE_WARNING_AS_ERROR=ON}

step "Testing"
# Tests speak DDS on loopback and shared memory only.
export ROS_LOCALHOST_ONLY=1
run_tests . "${tested[@]}"
