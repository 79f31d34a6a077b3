#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Runs the tests of the runtime, the algorithms and the components under sanitizers:
#
#   test/sanitize.sh [address|thread] [PACKAGE...]
#
# Without a sanitizer: both, one after the other. Without packages: all but the benchmark and the
# house rules; what packages need beside them is built without its tests. Closes with a line per
# sanitizer. Exits with 0 when nothing was found, with 2 for a package that there is not, else with
# another code.
set -euo pipefail
unset CDPATH
cd "$(dirname "${BASH_SOURCE[0]}")/.."

case "${1:-}" in
  -h | --help)
    sed -n '3,11s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"
    exit 0
    ;;
  address | thread) sanitizers=("$1"); shift ;;
  *) sanitizers=(address thread) ;;
esac

launch_scripts/setup.sh
source launch_scripts/build_environment.sh
source test/packages.sh
if [ $# -gt 0 ]; then
  require_packages "$@"
  select=(--packages-select "$@")
  tested=("$@")
else
  skipped=(pipescout_benchmark pipescout_house_rules)
  select=(--packages-skip "${skipped[@]}")
  mapfile -t tested < <(packages | grep -vxF "${skipped[@]/#/-e}")
fi
export ROS_LOCALHOST_ONLY=1
# Fast DDS is not instrumented: what its own threads do among themselves is not judged.
export TSAN_OPTIONS="suppressions=$PWD/test/thread_sanitizer_suppressions.txt halt_on_error=1 second_deadlock_stack=1"
# Containers that cross into libraries which are not instrumented would be misjudged.
# Fast DDS deletes one of its writers through a base of another size.
export ASAN_OPTIONS="detect_container_overflow=0 new_delete_type_mismatch=0 strict_string_checks=1 detect_stack_use_after_return=1"
export UBSAN_OPTIONS="halt_on_error=1 print_stacktrace=1"

status=0
for sanitizer in "${sanitizers[@]}"; do
  case $sanitizer in
    address) flags="-fsanitize=address,undefined -fno-sanitize-recover=all" ;;
    thread) flags="-fsanitize=thread" ;;
  esac
  places=(--build-base "build/sanitize_$sanitizer/build" --install-base "build/sanitize_$sanitizer/install")
  log=(--log-base "build/sanitize_$sanitizer/log")
  mkdir -p "build/sanitize_$sanitizer"
  touch build/COLCON_IGNORE
  build() {
    local testing=$1
    shift
    colcon "${log[@]}" build "${places[@]}" --event-handlers console_start_end+ "$@" --cmake-args \
      -DCMAKE_BUILD_TYPE=RelWithDebInfo "-DCMAKE_CXX_FLAGS=$flags -fno-omit-frame-pointer -O1" \
      "-DCMAKE_C_FLAGS=$flags" -DPIPESCOUT_TIMEOUT_FACTOR=6 "-DBUILD_TESTING=$testing"
  }
  if [ $# -gt 0 ]; then
    # The packages themselves too: what the tests of one need may need another.
    build OFF --packages-up-to "$@"
  fi
  build ON "${select[@]}"
  if run_tests "build/sanitize_$sanitizer" "${tested[@]}"; then
    echo "$sanitizer: nothing found"
  else
    echo "$sanitizer: FAILED"
    status=1
  fi
done
exit $status
