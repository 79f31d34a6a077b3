#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Builds the Debian packages pipescout-runtime, -components, -tools and -dev:
#
#   launch_scripts/package.sh [--no-build] [--out DIR] [--version VERSION] [PACKAGE...]
#
# --no-build: from the workspace as it is built, by inspect.sh or build_product.sh, for example. DIR: build/package/debs
# by default. VERSION: by default 0.1.0 and the revision. PACKAGE: only these packages of the workspace and what they need, and the host. On the robot:
#
#   apt install ./pipescout-*.deb && systemctl enable --now pipescout@crawler
set -euo pipefail
unset CDPATH
cd "$(dirname "${BASH_SOURCE[0]}")/.."
scripts=launch_scripts/debian

usage() { sed -n '3,10s/^# \{0,1\}//p' "launch_scripts/package.sh"; }

work=$PWD/build/package
out=$work/debs
version=
build=true
selected=()
while [ $# -gt 0 ]; do
  case "$1" in
    --out | --version)
      [ $# -ge 2 ] || { echo "package.sh: $1 needs a value" >&2; exit 2; }
      if [ "$1" = --out ]; then out=$(realpath -m -- "$2"); else version=$2; fi
      shift 2
      ;;
    --no-build) build=false; shift ;;
    -h | --help) usage; exit 0 ;;
    -*) echo "package.sh: unknown option $1" >&2; usage >&2; exit 2 ;;
    *) selected+=("$1"); shift ;;
  esac
done
for tool in dpkg-deb dpkg-shlibdeps fakeroot strip colcon; do
  command -v "$tool" >/dev/null || { echo "package.sh: there is no $tool; run launch_scripts/setup.sh" >&2; exit 1; }
done
[ -n "$version" ] || version=0.1.0+git$(git log -1 --format=%cd.%h --date=format:%Y%m%d 2>/dev/null || echo 0)

[ ${#selected[@]} -eq 0 ] || selected=(pipescout_host "${selected[@]}")
! $build || launch_scripts/build_product.sh "${selected[@]}" >&2
mapfile -t names < <(launch_scripts/build_product.sh --list "${selected[@]}")

stage=$work/stage
rm -rf "$stage"
mkdir -p "$stage"/pipescout-{runtime,components,tools,dev} "$out"
python3 $scripts/split_packages.py install build "$stage" "${names[@]}"

runtime=$stage/pipescout-runtime
for unit in pipescout@.service pipescout-discovery.service; do
  install -D -m 0644 "$scripts/$unit" "$runtime/lib/systemd/system/$unit"
done
install -D -m 0644 $scripts/environment "$runtime/etc/pipescout/environment"
for composition in launch_scripts/*.yaml; do
  install -D -m 0644 "$composition" "$stage/pipescout-components/etc/pipescout/$(basename "$composition")"
done

summary_of() {
  case "$1" in
    pipescout-runtime) echo "runs compositions of robot components, as a service of systemd" ;;
    pipescout-components) echo "components that inspect pipelines" ;;
    pipescout-tools) echo "subcommands: recordings, reports, keys, plots" ;;
    pipescout-dev) echo "headers and CMake packages" ;;
  esac
}

# dpkg-shlibdeps finds libraries of the packages next to it, and wants a source package.
mkdir -p "$stage/debian"
printf 'Source: pipescout\n\nPackage: pipescout\nArchitecture: any\n' >"$stage/debian/control"
libraries=()
for package in runtime components tools; do libraries+=("-l$stage/pipescout-$package/usr/lib"); done

depends_of() {
  local files=()
  mapfile -t files < <(find "$stage/$1/usr" -type f \( -name '*.so*' -o -path '*/bin/*' \) -exec sh -c \
    'head -c 4 "$1" | grep -q ELF && echo "$1"' _ {} \;)
  local depends=
  if [ ${#files[@]} -gt 0 ]; then
    depends=$(cd "$stage" && dpkg-shlibdeps --ignore-missing-info -O "${libraries[@]}" "${files[@]}" \
      2>/dev/null | sed -n 's/^shlibs:Depends=//p')
  fi
  case "$1" in
    pipescout-runtime) depends+=", adduser" ;;
    pipescout-components) depends+=", pipescout-runtime (= $version)" ;;
    pipescout-tools) depends+=", pipescout-runtime (= $version), pipescout-components (= $version)" ;;
    pipescout-dev)
      depends+=", pipescout-runtime (= $version), pipescout-components (= $version), pipescout-tools (= $version)"
      # What the headers and CMake packages of the others name.
      depends+=", cmake, make, g++, libclass-loader-dev, libcli11-dev, libeigen3-dev, libfastcdr-dev, libyaml-cpp-dev"
      depends+=", nlohmann-json3-dev"
      ;;
  esac
  if find "$stage/$1/usr" -name '*.py' | grep -q .; then depends+=", python3"; fi
  sed 's/^, //' <<<"$depends"
}

for package in pipescout-runtime pipescout-components pipescout-tools pipescout-dev; do
  root=$stage/$package
  mkdir -p "$root/DEBIAN" "$root/usr/share/doc/$package"
  cp LICENSE "$root/usr/share/doc/$package/copyright"
  architecture=$(dpkg --print-architecture)
  {
    printf 'Package: %s\nVersion: %s\nArchitecture: %s\nSection: science\nPriority: optional\n' \
      "$package" "$version" "$architecture"
    printf 'Maintainer: Pipescout developers <developers@pipescout.org>\n'
    printf 'Installed-Size: %s\n' "$(du -sk --exclude=DEBIAN "$root" | cut -f1)"
    printf 'Depends: %s\n' "$(depends_of "$package")"
    [ $package != pipescout-tools ] || printf 'Recommends: python3-matplotlib, python3-yaml, libimage-exiftool-perl\n'
    printf 'Description: Pipescout: %s\n Components for robots that inspect pipelines, over DDS, as nodes of ROS 2.\n' \
      "$(summary_of "$package")"
  } >"$root/DEBIAN/control"
  # What the operator edits survives an upgrade.
  (cd "$root" && find etc -type f 2>/dev/null | sed 's|^|/|' | sort) >"$root/DEBIAN/conffiles" || true
  [ -s "$root/DEBIAN/conffiles" ] || rm "$root/DEBIAN/conffiles"
  for script in postinst prerm postrm; do
    [ ! -f "$scripts/$package.$script" ] || install -m 0755 "$scripts/$package.$script" "$root/DEBIAN/$script"
  done
  chmod -R go-w,go+rX "$root"
  fakeroot dpkg-deb --build -Zxz "$root" "$out/${package}_${version}_$architecture.deb" >&2
done
ls "$out"/*"_${version}_"*.deb
