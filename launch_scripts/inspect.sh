#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Installs what is missing, builds, and runs inspections. Ends with their tables, folders and pictures.
#
#   inspect.sh [OPTION...]                   1. the ten odometer readings of the paper (Wang and others,
#                                               2008): replay -> consensus fusion
#                                            2. a simulated crawler in a pipe of 60 joints: odometers and
#                                               eddy currents -> welds -> position; its welds aligned
#                                               with the pipe's ledger
#                                            3. a simulated UAV over a rack of pipes: images -> pose and
#                                               offsets of the pipes -> servo loop along way-points
#                                            4. a simulated ground robot on patrol that drives itself
#                                               through a plant of collectors: thermal pictures ->
#                                               leaks, their places, a report
#   inspect.sh READINGS.csv [OPTION...]      your own readings: docs/components/odometer_replay.md
#
# Options, of the readings:
#   --sigma A,B,...       standard deviation of each odometer, m. Needed for your own readings unless
#                         they have columns NAME.standard_deviation
#   --offsets A,B,...     added to each odometer's readings before they are fused, m
#   --epsilon E           largest confidence distance of odometers that support each other, in (0, 1)
#   --weighting W         maximum_likelihood (default) or paper_equation_13
#   --period S            time between two readings that have no stamps, s
#   --rate R              speed of the replay, as a multiple of the recording's
#   --reference COLUMN    column of your file that the fused distance is compared with
#   --out DIR             the mission folder; default: missions/<name>_<UTC time>. That of the crawler
#                         is DIR_crawler, that of the rack DIR_rack, that of the patrol DIR_patrol
#   -h, --help            this text
#
# Stays on this machine: ROS_LOCALHOST_ONLY is 1 unless it is set. Two missions at once on one machine
# need a ROS_DOMAIN_ID each.
#
# Exit code: 0 when everything was recorded, 1 when not (also for a value that is out of range), 2 for
# a wrong command line.
set -euo pipefail
unset CDPATH
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

usage() { sed -n '3,34s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"; }
wrong() {
  echo "inspect.sh: $1" >&2
  echo "inspect.sh --help tells the options." >&2
  exit 2
}

# A number as a floating point number in YAML: "1" alone would be an integer.
number='^[-+]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][-+]?[0-9]+)?$'
real() {
  [[ $2 =~ $number ]] || wrong "$1: '$2' is not a number"
  if [[ $2 =~ ^[-+]?[0-9]+$ ]]; then echo "$2.0"; else echo "$2"; fi
}
list() {
  local option=$1 items item result=""
  IFS=, read -r -a items <<<"$2"
  [ ${#items[@]} -gt 0 ] || wrong "$option: no numbers"
  for item in "${items[@]}"; do
    item=$(real "$option" "${item//[[:blank:]]/}") || exit 2
    result+="${result:+, }$item"
  done
  echo "[$result]"
}

# A text in YAML, whatever is in it.
text() { printf "'%s'" "${1//\'/\'\'}"; }

readings="" reference="" out="" sigma=false parameters=()
while [ $# -gt 0 ]; do
  option=$1
  case $option in
    -h | --help) usage; exit 0 ;;
    --sigma | --offsets | --epsilon | --weighting | --period | --rate | --reference | --out)
      [ $# -ge 2 ] || wrong "$option: a value is missing"
      value=$2
      shift
      ;;
    --sigma=* | --offsets=* | --epsilon=* | --weighting=* | --period=* | --rate=* | --reference=* | --out=*)
      value=${option#*=}
      option=${option%%=*}
      ;;
  esac
  case $option in
    --sigma) value=$(list "$option" "$value") || exit 2
      sigma=true
      parameters+=(--param "odometer_replay.standard_deviations:=$value") ;;
    --offsets) value=$(list "$option" "$value") || exit 2
      parameters+=(--param "odometry_fusion.offsets:=$value") ;;
    --epsilon) value=$(real "$option" "$value") || exit 2
      parameters+=(--param "odometry_fusion.epsilon:=$value") ;;
    --weighting) parameters+=(--param "odometry_fusion.weighting:=$(text "$value")") ;;
    --period) value=$(real "$option" "$value") || exit 2
      parameters+=(--param "odometer_replay.period:=$value") ;;
    --rate) value=$(real "$option" "$value") || exit 2
      parameters+=(--param "odometer_replay.rate:=$value") ;;
    --reference) reference=$value ;;
    --out) out=$value ;;
    -*) wrong "unknown option '$option'" ;;
    *)
      [ -z "$readings" ] || wrong "one file of readings only, not also '$option'"
      [ -f "$option" ] || wrong "no file '$option'"
      readings=$(cd "$(dirname "$option")" && pwd)/$(basename "$option")
      ;;
  esac
  shift
done
if [ -n "$reference" ] && [ -z "$readings" ]; then
  wrong "--reference goes with a file of your own readings"
fi

# Said now, not after the build. The file may be UTF-16.
if [ -n "$readings" ] && ! $sigma &&
  [ "$(head -n 5 "$readings" | tr -d '\0' | grep -c standard_deviation)" = 0 ]; then
  wrong "--sigma A,B,... is missing: the standard deviation of each odometer, m; '$readings' has no columns NAME.standard_deviation"
fi

composition=$root/launch_scripts/odometry.yaml
arguments=()
with_simulations=true steps=7
if [ -n "$readings" ]; then
  with_simulations=false steps=4
  composition=$root/launch_scripts/own_readings.yaml
  arguments=("readings:=$(text "$readings")")
  if [ -n "$reference" ]; then
    arguments+=("reference_file:=$(text "$readings")" "reference_column:=$reference")
  fi
fi
now=$(date -u +%Y-%m-%dT%H-%M-%SZ)
crawler_out=missions/crawler_$now
rack_out=missions/rack_$now
patrol_out=missions/patrol_$now
if [ -n "$out" ]; then
  crawler_out=${out%/}_crawler
  rack_out=${out%/}_rack
  patrol_out=${out%/}_patrol
else
  out=missions/$(basename "$composition" .yaml)_$now
fi

number_of_step=0
step() {
  number_of_step=$((number_of_step + 1))
  printf '\n== %s/%s %s (%s)\n' "$number_of_step" "$steps" "$1" "$(date -u +%H:%M:%S)"
}

step "Packages"
"$root/launch_scripts/setup.sh"

step "Build"
# Made before the build, so that what changes during it is built the next time.
stamp=$root/install/.inspect_built
sources=(idl interfaces src components colcon.meta)
if [ -f "$stamp" ] && [ -z "$(cd "$root" && find "${sources[@]}" -newer "$stamp" -print -quit)" ]; then
  echo "Nothing has changed since the last build."
else
  (
    cd "$root"
    mkdir -p install
    rm -f "$stamp"
    touch "$stamp.new"
    launch_scripts/build_product.sh
    mv "$stamp.new" "$stamp"
  )
fi

# The script that colcon writes reads variables that may not be set.
set +u
# shellcheck source=/dev/null
source "$root/install/local_setup.bash"
set -u
export ROS_LOCALHOST_ONLY=${ROS_LOCALHOST_ONLY-1}

# share PACKAGE: where the package's data are installed.
share() {
  local prefix prefixes
  IFS=: read -r -a prefixes <<<"${AMENT_PREFIX_PATH-}:${CMAKE_PREFIX_PATH-}"
  for prefix in "${prefixes[@]}"; do
    if [ -d "$prefix/share/$1" ]; then
      echo "$prefix/share/$1"
      return
    fi
  done
  echo "inspect.sh: package $1 is not installed" >&2
  return 1
}

step "Mission: odometer readings"
pipescout run "$composition" "${arguments[@]}" "${parameters[@]}" --out "$out"
missions=("$out")

if $with_simulations; then
  step "Mission: a crawler in a pipe"
  tally=$(share pipescout_crawler_simulation)/tally.csv
  columns=$(share pipescout_summary)/welds.yaml
  pipescout run "$root/launch_scripts/crawler.yaml" --out "$crawler_out"
  echo
  echo "The welds that the crawler saw, aligned with the ledger of the pipe:"
  echo
  pipescout ledger align "$crawler_out/crawler/welds.csv" "$tally" --columns "$columns" \
    --name crawler --date "$now" --out "$crawler_out/ledger.csv" \
    --report "$crawler_out/alignment.csv"

  step "Mission: a UAV over a rack of pipes"
  pipescout run "$root/launch_scripts/rack.yaml" --out "$rack_out"

  step "Mission: a patrol through a plant of collectors"
  pipescout run "$root/launch_scripts/patrol.yaml" --out "$patrol_out"
  missions+=("$crawler_out" "$rack_out" "$patrol_out")
fi

step "Pictures"
first=() notes=$(mktemp)
trap 'rm -f "$notes"' EXIT
for folder in "${missions[@]}"; do
  drawn=$(pipescout plot "$folder" 2>"$notes") || { cat "$notes" >&2; exit 1; }
  echo "$folder/pictures:"
  # "path<tab>what it shows", the one to open first first.
  while IFS=$'\t' read -r picture shows; do
    printf '  %-30s %s\n' "$(basename "$picture")" "$shows"
  done <<<"$drawn"
  first+=("${drawn%%$'\n'*}")
done

printf '\nDone in %d min %d s. Open first:\n' $((SECONDS / 60)) $((SECONDS % 60))
! $with_simulations || first=("$patrol_out/report/report.html"$'\t'"the leaks that the patrol found: to look at and to hand on" "${first[@]}")
for each in "${first[@]}"; do printf '  %s\n      %s\n' "${each%%$'\t'*}" "${each#*$'\t'}"; done
printf 'Then: source install/setup.bash; pipescout --help. With your own data: README.md, "Where to go next".\n'
