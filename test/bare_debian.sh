#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Installs the Debian packages in a bare Debian 12 (debootstrap), runs a composition there as its service does,
# builds a component of another project with pipescout-dev, upgrades, removes and purges them:
#
#   test/bare_debian.sh DEBS [--base DIR] [--composition NAME]
#
# DEBS: folder with one version of the packages, see launch_scripts/package.sh. --base: a bare system to start
# from, kept as it is; else one is made. Needs root; without root or debootstrap it says so and exits with 77.
set -euo pipefail
unset CDPATH

usage() { sed -n '3,9s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"; }
[ $# -ge 1 ] || { usage >&2; exit 2; }
[ "$1" != -h ] && [ "$1" != --help ] || { usage; exit 0; }
debs=$(realpath -- "$1")
shift
first_component=$(realpath -- "$(dirname "${BASH_SOURCE[0]}")/../docs/first_component")
base=
composition=crawler
while [ $# -gt 0 ]; do
  [ $# -ge 2 ] || { usage >&2; exit 2; }
  case "$1" in
    --base) base=$(realpath -- "$2") ;;
    --composition) composition=$2 ;;
    *) usage >&2; exit 2 ;;
  esac
  shift 2
done

if [ "$(id -u)" -ne 0 ]; then echo "SKIPPED: bare_debian.sh needs root" >&2; exit 77; fi
if [ -z "$base" ] && ! command -v debootstrap >/dev/null; then
  echo "SKIPPED: bare_debian.sh needs debootstrap" >&2
  exit 77
fi

work=$(mktemp -d /var/tmp/pipescout_bare_XXXXXX)
system=$work/system
leave() {
  for mount in dev/shm dev proc sys; do umount "$system/$mount" 2>/dev/null || true; done
  # A mount that is still there must not be emptied.
  if mount | grep -q " $system/"; then echo "still mounted: $system" >&2; else rm -rf "$work"; fi
}
trap leave EXIT

if [ -n "$base" ]; then
  cp -a "$base" "$system"
else
  debootstrap --variant=minbase --include=ca-certificates bookworm "$system" >"$work/log" 2>&1 ||
    { tail -n 5 "$work/log" >&2; exit 1; }
fi
for mount in proc sys dev dev/shm; do mkdir -p "$system/$mount"; mount --bind "/$mount" "$system/$mount"; done
cp /etc/resolv.conf "$system/etc/" 2>/dev/null || true
mkdir "$system/debs"
cp "$debs"/pipescout-{runtime,components,tools}_*.deb "$system/debs/"
mkdir "$system/development"
cp "$debs"/pipescout-dev_*.deb "$system/development/"

inside() {
  chroot "$system" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin LANG=C.UTF-8 DEBIAN_FRONTEND=noninteractive "$@"
}
failures=0
expect() {
  local what=$1
  shift
  if "$@" >"$work/out" 2>&1; then echo "ok: $what"; else
    echo "FAILED: $what" >&2
    tail -n 20 "$work/out" >&2
    failures=$((failures + 1))
  fi
}
not() { ! "$@"; }

inside apt-get -qq update
expect "apt installs the packages and what they need" \
  inside bash -c 'apt-get install -qq -y --no-install-recommends /debs/pipescout-*.deb'
expect "no compiler came with them" not inside bash -c 'command -v g++ || command -v cmake'
expect "pipescout runs" inside pipescout --help
expect "pipescout security is found" inside pipescout security --help
expect "all libraries are found" inside bash -c \
  '! ldd /usr/bin/pipescout* /usr/lib/libpipescout_*.so* 2>/dev/null | grep "not found"'
expect "the user of the service is there" inside id pipescout
expect "the state folder belongs to it" inside bash -c '[ "$(stat -c %U:%a /var/lib/pipescout)" = pipescout:750 ]'

# What systemd would do for pipescout@NAME: the user, the folder, the command line of the unit.
command_line=$(sed -n 's/^ExecStart=//p' "$system/lib/systemd/system/pipescout@.service" |
  sed "s/%i/$composition/g; s/ \$PIPESCOUT_ARGUMENTS//")
inside install -d -o pipescout -g pipescout "/var/lib/pipescout/$composition"
expect "the service's command runs to its end as the service's user" \
  timeout 500 chroot "$system" setpriv --reuid=pipescout --regid=pipescout --clear-groups --no-new-privs \
  env -i PATH=/usr/bin:/bin ROS_LOCALHOST_ONLY=1 ROS_DOMAIN_ID=77 bash -c "cd /var/lib/pipescout/$composition && $command_line"
expect "its mission has a summary" inside bash -c "ls /var/lib/pipescout/$composition/missions/*/summary.json"

expect "apt installs the development package" inside bash -c \
  'apt-get install -qq -y --no-install-recommends /development/pipescout-dev_*.deb'
cp -r "$first_component" "$system/outside"
expect "all CMake packages are found, with what they need" inside bash -c '
  mkdir /all && cd /all && {
    echo "cmake_minimum_required(VERSION 3.22)"
    echo "project(all LANGUAGES CXX)"
    for folder in /usr/lib/cmake/pipescout_*; do echo "find_package($(basename "$folder") REQUIRED)"; done
  } >CMakeLists.txt && cmake -S . -B build'
expect "a project outside builds a component" inside bash -c '
  cmake -S /outside -B /outside/build -DBUILD_TESTING=OFF -DCMAKE_INSTALL_PREFIX=/opt/outside &&
  cmake --build /outside/build && cmake --install /outside/build'
expect "pipescout finds that component" inside bash -c \
  'AMENT_PREFIX_PATH=/opt/outside pipescout component types | grep tutorial::SlipAlarm'

expect "systemd finds no fault with the units" inside bash -c '
  apt-get install -qq -y --no-install-recommends systemd >/dev/null &&
  ! systemd-analyze verify --man=no "pipescout@$1.service" pipescout-discovery.service 2>&1 | grep .' _ "$composition"

echo "# the operator's" >>"$system/etc/pipescout/environment"
mkdir "$work/new"
for deb in "$system"/debs/*.deb "$system"/development/*.deb; do
  rm -rf "$work/unpacked"
  dpkg-deb --raw-extract "$deb" "$work/unpacked"
  version=$(sed -n 's/^Version: //p' "$work/unpacked/DEBIAN/control")
  sed -i "s/$version/$version.1/g" "$work/unpacked/DEBIAN/control"
  [ ! -f "$work/unpacked/etc/pipescout/environment" ] || echo "# the next version's" >>"$work/unpacked/etc/pipescout/environment"
  dpkg-deb --build -Znone "$work/unpacked" "$work/new/" >/dev/null
done
rm "$system"/debs/*.deb "$system"/development/*.deb
cp "$work"/new/*.deb "$system/debs/"
expect "apt upgrades them" inside bash -c \
  'apt-get install -qq -y --no-install-recommends -o Dpkg::Options::=--force-confdef -o Dpkg::Options::=--force-confold /debs/pipescout-*.deb'
expect "the operator's configuration survives the upgrade" grep -q "the operator's" "$system/etc/pipescout/environment"
expect "pipescout runs after the upgrade" inside pipescout --help

expect "apt removes them" inside bash -c 'apt-get remove -qq -y "pipescout-*"'
expect "nothing of them stays in /usr and /lib" not inside bash -c \
  'find /usr /lib/systemd -name "*pipescout*" -not -path "*/python3*" | grep .'
expect "the operator's configuration survives the removal" test -f "$system/etc/pipescout/environment"
expect "apt purges them" inside bash -c 'apt-get purge -qq -y "pipescout-*"'
expect "the configuration is gone after the purge" not test -e "$system/etc/pipescout"
expect "the missions survive the purge" test -d "$system/var/lib/pipescout/$composition"
[ $failures -eq 0 ] && echo "all passed" || { echo "$failures failed" >&2; exit 1; }
