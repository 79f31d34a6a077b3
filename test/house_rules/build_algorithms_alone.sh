#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Builds the algorithm packages, src/*, in an environment that knows nothing else of the project, each
# seeing only what it declares that it needs: build_algorithms_alone.sh SCRATCH
#
# Libraries only, and not optimised: the same tests in the same environment are what the ordinary
# build runs, since colcon shows a package only its declared dependencies there too.
set -euo pipefail
unset CDPATH
scratch=$1
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
rm -rf "$scratch"
mkdir -p "$scratch"
unset CMAKE_PREFIX_PATH AMENT_PREFIX_PATH COLCON_PREFIX_PATH LD_LIBRARY_PATH
colcon --log-base "$scratch/log" build --base-paths src \
  --build-base "$scratch/build" --install-base "$scratch/install" \
  --cmake-args -DCMAKE_BUILD_TYPE=Debug -DCMAKE_CXX_FLAGS_DEBUG=-O0 -DBUILD_TESTING=OFF
