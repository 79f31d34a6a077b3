#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# How the scripts show the progress of long work, to be sourced.

# show_progress: reads lines "PERCENT text". On a terminal one line that is overwritten; otherwise a line for every 10 %.
show_progress() {
  local percent text shown=-10
  while read -r percent text; do
    if [ -t 1 ]; then
      printf '\r\033[K  %3d %% %s' "$percent" "${text:0:70}"
    elif ((percent < shown || percent >= shown + 10)); then
      printf '  %3d %% %s\n' "$percent" "$text"
      shown=$((percent / 10 * 10))
    fi
  done
  [ ! -t 1 ] || printf '\r\033[K'
}
