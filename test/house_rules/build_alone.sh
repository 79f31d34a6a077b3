#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Builds and tests one package and what it declares that it needs, in an environment that knows
# nothing else of the project: build_alone.sh PACKAGE SCRATCH
set -euo pipefail
unset CDPATH
package=$1 scratch=$2
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
rm -rf "$scratch"
mkdir -p "$scratch"
unset CMAKE_PREFIX_PATH AMENT_PREFIX_PATH COLCON_PREFIX_PATH LD_LIBRARY_PATH
places=(--build-base "$scratch/build" --install-base "$scratch/install")
colcon --log-base "$scratch/log" build "${places[@]}" --packages-up-to "$package" \
  --cmake-args -DCMAKE_BUILD_TYPE=Release
colcon --log-base "$scratch/log" test "${places[@]}" --packages-select "$package" \
  --return-code-on-test-failure
