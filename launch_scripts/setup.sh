#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Installs the Debian packages that building, running and testing need: those of apt-packages.txt.
# Does nothing when all are there. Needs root or sudo only when something is missing.
#
#   launch_scripts/setup.sh            install what is missing
#   launch_scripts/setup.sh --check    only say what is missing; exits 1 if something is
set -euo pipefail
unset CDPATH
folder=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)

usage() { sed -n '3,7s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"; }

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
apt_get() { "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -q -o Dpkg::Use-Pty=0 "$@"; }

echo "Updating the package lists ..."
apt_get update
echo "Installing ..."
apt_get install -y --no-install-recommends "${missing[@]}"
echo "Installed ${#missing[@]} packages."
