#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Installs the npm packages that the tests of bags compare with, next to this file. Without npm or a
# registry it says so and exits with 0: those tests then say that they were not run.
set -euo pipefail
unset CDPATH
cd "$(dirname "${BASH_SOURCE[0]}")"

if [ -d node_modules/@mcap/core ] && [ -d node_modules/@foxglove/rosbag2 ]; then
  exit 0
fi
if ! command -v npm >/dev/null; then
  echo "bag readers: no npm, so bags are not compared with @mcap/core and @foxglove/rosbag2" >&2
  exit 0
fi
# No package runs a script of its own.
if ! timeout 300 npm install --no-fund --no-audit --no-package-lock --ignore-scripts --loglevel error; then
  echo "bag readers: npm failed, so bags are not compared with @mcap/core and @foxglove/rosbag2" >&2
fi
