#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Installs the Debian packages that building, running and testing need: those of apt-packages.txt.
# Does nothing when all are there. Needs root or sudo only when something is missing. What apt says goes into a
# log, log/setup_<UTC time>.log.
#
#   launch_scripts/setup.sh            install what is missing
#   launch_scripts/setup.sh --check    only say what is missing; exits 1 if something is
#
# Nothing is removed, and nothing that is installed is upgraded, except where a missing package needs a newer version
# of it: these are named before anything is changed.
set -euo pipefail
unset CDPATH
folder=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)

usage() { sed -n '3,11s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"; }

check_only=false
case "${1:-}" in
  "") ;;
  --check) check_only=true ;;
  -h | --help) usage; exit 0 ;;
  *) usage >&2; exit 2 ;;
esac

if ! command -v dpkg-query >/dev/null; then
  echo "setup.sh: this machine has no Debian packages; see $folder/apt-packages.txt" >&2
  exit 1
fi

mapfile -t wanted < <(grep -v '^#' "$folder/apt-packages.txt" | grep -v '^$')
missing=()
installed=$(dpkg-query -W -f='${Package} ${db:Status-Status}\n' "${wanted[@]}" 2>/dev/null |
  awk '$2 == "installed" { print $1 }') || true
for package in "${wanted[@]}"; do
  grep -qxF "$package" <<<"$installed" || missing+=("$package")
done

if [ ${#missing[@]} -eq 0 ]; then
  echo "All ${#wanted[@]} packages are installed."
  exit 0
fi
echo "${#missing[@]} of ${#wanted[@]} packages are missing: ${missing[*]}"
if $check_only; then
  exit 1
fi

as_root=()
if [ "$(id -u)" -ne 0 ]; then
  if ! command -v sudo >/dev/null; then
    echo "setup.sh: installing needs root: run it as root, or install sudo" >&2
    exit 1
  fi
  as_root=(sudo)
fi

log=$folder/../log/setup_$(date -u +%Y-%m-%dT%H-%M-%SZ).log
mkdir -p "$(dirname "$log")"
log=$(realpath "$log")

# shellcheck source=launch_scripts/progress.sh
source "$folder/progress.sh"
apt_get() { # progress here, all else into the log; fails as apt-get does
  echo "== apt-get $*" >>"$log"
  # Behind sudo, which closes what is no standard stream. The status has a stream of its own: apt makes it one that does not
  # block, and what packages print at their installation would fail on it.
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive LC_ALL=C.UTF-8 bash -c \
    'exec apt-get -q -o Dpkg::Use-Pty=0 -o APT::Status-Fd=3 "$@" 3>&1 >>"$0" 2>&1 </dev/null' "$log" "$@" | awk -F: '
      $1 == "dlstatus" { printf "%d downloading\n", $3; fflush() }
      $1 == "pmstatus" { printf "%d installing %s\n", $3, $2; fflush() }' | show_progress
}
failed() {
  echo "setup.sh: $1; the end of $log:" >&2
  tail -n 20 "$log" >&2
  exit 1
}

echo "Updating the package lists; the log is $log"
apt_get update || failed "the package lists cannot be updated"

install=(install --no-install-recommends --no-remove "${missing[@]}")
plan=$(LC_ALL=C.UTF-8 apt-get -s -q "${install[@]}" 2>&1) || { echo "$plan" >>"$log"; failed "apt cannot install them"; }
echo "$plan" >>"$log"
# "Inst NAME [installed version] (new version ...)": a new package has no version in brackets.
mapfile -t upgraded < <(sed -n 's/^Inst \([^ ]*\) \[\([^]]*\)\] (\([^ ]*\) .*/\1 \2 -> \3/p' <<<"$plan")
new=$(grep -c '^Inst [^ ]* (' <<<"$plan") || true
sizes=$("${as_root[@]}" env LC_ALL=C.UTF-8 apt-get -q --assume-no "${install[@]}" 2>/dev/null |
  sed -n 's/^Need to get \(.*\) of archives\.$/\1 to download/p; s/^After this operation, \(.*\) of additional.*/\1 on disk/p' |
  paste -sd, | sed 's/,/, /') || true
if [ ${#upgraded[@]} -ne 0 ]; then
  echo "Upgraded too, since missing packages need newer versions of what is installed (${#upgraded[@]}):"
  printf '  %s\n' "${upgraded[@]}"
fi
echo "Installing ${#missing[@]} packages and what they need, $new in all${sizes:+ ($sizes)}"
apt_get -y "${install[@]}" || failed "not everything could be installed"
echo "Installed ${#missing[@]} packages."
