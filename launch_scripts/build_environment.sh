#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# How the scripts of the project build, to be sourced before `colcon build`; what is set already stays.
# For a shell of your own: source launch_scripts/build_environment.sh

# Without this colcon limits a build by the load of the machine, and another job starves it.
export MAKEFLAGS=${MAKEFLAGS:--j$(nproc)}
# Ninja does not read MAKEFLAGS.
export CMAKE_BUILD_PARALLEL_LEVEL=${CMAKE_BUILD_PARALLEL_LEVEL:-$(nproc)}

export CMAKE_GENERATOR=${CMAKE_GENERATOR:-Ninja}
export CMAKE_EXPORT_COMPILE_COMMANDS=${CMAKE_EXPORT_COMPILE_COMMANDS:-ON}

if command -v ccache >/dev/null; then
  export CMAKE_C_COMPILER_LAUNCHER=${CMAKE_C_COMPILER_LAUNCHER-ccache}
  export CMAKE_CXX_COMPILER_LAUNCHER=${CMAKE_CXX_COMPILER_LAUNCHER-ccache}
  # Without this ccache takes nothing that precompiled headers go into.
  export CCACHE_SLOPPINESS=${CCACHE_SLOPPINESS:-pch_defines,time_macros}
  # And without this it takes a precompiled header for one whose comments differ, which GCC then refuses.
  export CCACHE_COMMENTS=${CCACHE_COMMENTS:-true}
  # Clones of the project find what another one compiled.
  CCACHE_BASEDIR=${CCACHE_BASEDIR-$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd -P)}
  export CCACHE_BASEDIR
fi
