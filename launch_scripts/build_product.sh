#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Builds the product: what a robot or an engineer's desk carries, without tests.
#
#   launch_scripts/build_product.sh [PACKAGE...]           all of it, or these packages and what they need
#   launch_scripts/build_product.sh --list [PACKAGE...]    only names the packages
#
# One line of progress; what the compiler says is in log/latest_build/PACKAGE, and shown when a package fails.
set -euo pipefail
unset CDPATH
cd "$(dirname "${BASH_SOURCE[0]}")/.."

case "${1:-}" in
  -h | --help) sed -n '3,8s/^# \{0,1\}//p' launch_scripts/build_product.sh; exit 0 ;;
  --list) list=true; shift ;;
  *) list=false ;;
esac

bases=(idl interfaces src components)
# What scores the product, and is no part of it.
laboratory=(src/studies components/tools/reproduce)
names() { colcon --log-base /dev/null list --names-only "$@"; }
mapfile -t left_out < <(names --base-paths "${laboratory[@]}")
choice=(--base-paths "${bases[@]}" --packages-skip "${left_out[@]}")
[ $# -eq 0 ] || choice+=(--packages-up-to "$@")
mapfile -t packages < <(names "${choice[@]}")
if $list; then
  printf '%s\n' "${packages[@]}"
  exit
fi

# shellcheck source=launch_scripts/build_environment.sh
source launch_scripts/build_environment.sh
# shellcheck source=launch_scripts/progress.sh
source launch_scripts/progress.sh

start=$SECONDS
set +e
# What colcon prints of packages that begin and end becomes progress.
colcon build --event-handlers console_direct- console_stderr- summary- console_start_end+ "${choice[@]}" \
  --cmake-args -DCMAKE_BUILD_TYPE=Release -DBUILD_TESTING=OFF \
  ${CI:+-DCMAKE_COMPILE_WARNING_AS_ERROR=ON} 2>&1 | awk -v all=${#packages[@]} '
    /^Starting >>> / { printf "%d %d of %d packages, %s ...\n", 100 * done / all, done, all, $3; fflush(); next }
    /^Finished <<< / { ++done; printf "%d %d of %d packages\n", 100 * done / all, done, all; fflush(); next }
    NF { print >"/dev/stderr" }' | show_progress
code=${PIPESTATUS[0]}
set -e
if [ "$code" -ne 0 ]; then
  for package in "${packages[@]}"; do
    output=log/latest_build/$package/stdout_stderr.log
    if [ -f "$output" ] && [ "$(cat "build/$package/colcon_build.rc" 2>/dev/null)" != 0 ]; then
      echo "$package is not built; the end of $PWD/$output:" >&2
      tail -n 40 "$output" >&2
    fi
  done
  exit "$code"
fi
seconds=$((SECONDS - start))
echo "Built ${#packages[@]} packages in $((seconds / 60)) min $((seconds % 60)) s."
