#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Builds (Release) and runs one benchmark: NAME_benchmark.cpp, a program, with its peer in the same run,
# or NAME_benchmark.py, a script with options of its own (--help):
#
#   test/benchmark/run.sh NAME [--json FILE] [options of Google Benchmark or of the script]
#
# Prints a table; FILE gets {"figures": {name: number}, "rows": [...], "seeds": [...]}.
set -euo pipefail
unset CDPATH
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
names=$(cd "$here" && ls ./*_benchmark.cpp ./*_benchmark.py | sed 's|^\./||; s|_benchmark\.[a-z]*$||' | sort)

usage() {
  sed -n '3,8s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"
  printf 'NAME is one of:\n%s\n' "$names"
}
case "${1:-}" in
  -h | --help) usage; exit 0 ;;
  "") usage >&2; exit 2 ;;
esac
name=$1
shift
if ! grep -qx -- "$name" <<<"$names"; then
  echo "no benchmark '$name'" >&2
  usage >&2
  exit 2
fi
arguments=()
while [ $# -gt 0 ]; do
  if [ "$1" = --json ]; then
    [ $# -ge 2 ] || { echo "--json needs a file" >&2; exit 2; }
    arguments+=(--json "$(realpath -m -- "$2")")
    shift 2
  else
    arguments+=("$1")
    shift
  fi
done

if [ -f "$here/${name}_benchmark.py" ]; then
  exec "$here/${name}_benchmark.py" "${arguments[@]}"
fi

cd "$here/../.."
# shellcheck source=launch_scripts/build_environment.sh
source launch_scripts/build_environment.sh
colcon build --event-handlers console_start_end- console_direct- --packages-up-to pipescout_benchmark \
  --cmake-args -DCMAKE_BUILD_TYPE=Release >&2
set +u
# shellcheck disable=SC1091
source install/setup.bash
set -u
export ROS_LOCALHOST_ONLY=1
# One core: neither ViSP nor the linear algebra that it uses may take more.
export OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1
exec "install/pipescout_benchmark/lib/pipescout_benchmark/${name}_benchmark" "${arguments[@]}"
