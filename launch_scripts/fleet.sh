#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Runs a composition on N robots, each in a network namespace of its own behind a bridge, and a station in another.
#
#   launch_scripts/fleet.sh N [--loss PERCENT] [--delay MS] [--rate MBIT [--shared]] [--apart] COMPOSITION
#                           [-- STATION COMMAND]
#
# Robot K has the namespace robot_K and the address 10.77.0.K, the station 10.77.0.254. Loss, delay and rate hold for
# each robot's link, in each direction; with --shared the rate is that of one radio channel for all robots and both
# directions. pipescout_link_emulator (a package of that name) makes them: the kernel needs no netem. The link of robot
# K is the interface to_robot_K of the bridge where the fleet's first process is: "nsenter -t 1 -n ip link set to_robot_K
# down" from within cuts it, "nomaster" takes the robot out of reach, "master bridge" back; with --apart all begin out of
# reach. Ends with the station command, or, without one, when it is interrupted.
# Needs root, for the namespaces. All lives in namespaces that die with this script, even when it is killed.
set -euo pipefail
unset CDPATH

usage() { sed -n '3,13s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"; }
fail() { echo "fleet.sh: $1" >&2; exit "${2:-2}"; }

# Runs a command as host NAME: with a network and a /dev/shm of its own.
on_host() {
  local name=$1
  shift
  ip netns exec "$name" bash -c 'mount -t tmpfs -o size=256m tmpfs /dev/shm; exec "$@"' _ "$@"
}

# A host's network is eth0: the other end of its link to the bridge, or a TAP device that the emulator connects to it.
add_host() {
  local name=$1 address=$2 emulated=${3:-}
  ip netns add "$name"
  if [ -n "$emulated" ]; then
    ip link add "to_$name" type veth peer name "$name" netns air
    ip -n air link set "$name" up
    ip -n "$name" tuntap add dev eth0 mode tap vnet_hdr
  else
    ip link add "to_$name" type veth peer name eth0 netns "$name"
  fi
  ip link set "to_$name" master bridge up
  ip -n "$name" link set lo up
  ip -n "$name" address add "$address/24" dev eth0
  ip -n "$name" link set eth0 up
  ip -n "$name" route add 224.0.0.0/4 dev eth0
}

# Until frames pass the links of all robots.
emulate_links() {
  local names=() robot ready
  for ((robot = 1; robot <= robots; ++robot)); do names+=("robot_$robot"); done
  exec {ready}< <(exec nice -n -20 pipescout_link_emulator "${links[@]}" "${names[@]}")
  read -r -u "$ready" _ || fail "the links cannot be emulated" 1
}

# The first process of the fleet's namespaces: when it ends, the kernel ends all others and removes the links.
inside() {
  trap 'exit 143' TERM INT
  mount -t tmpfs tmpfs /run
  unset ROS_LOCALHOST_ONLY
  ip link set lo up
  ip link add bridge type bridge
  ip link set bridge up
  add_host station 10.77.0.254
  [ ${#links[@]} -eq 0 ] || ip netns add air
  local robot
  for ((robot = 1; robot <= robots; ++robot)); do
    add_host "robot_$robot" "10.77.0.$robot" "${links[*]}"
    [ -z "$apart" ] || ip link set "to_robot_$robot" nomaster
  done
  [ ${#links[@]} -eq 0 ] || emulate_links
  for ((robot = 1; robot <= robots; ++robot)); do
    on_host "robot_$robot" pipescout run "$composition" --namespace "robot_$robot" &
  done
  if [ ${#station[@]} -gt 0 ]; then
    on_host station "${station[@]}" &
    wait $!
  else
    wait
    fail "all robots have ended" 1
  fi
}

number() { # OPTION VALUE LOWEST HIGHEST
  [[ $2 =~ ^[0-9]+(\.[0-9]+)?$ ]] && awk -v v="$2" -v l="$3" -v h="$4" 'BEGIN { exit !(v >= l && v <= h) }' ||
    fail "$1 is \"$2\", not a number from $3 to $4"
}

all=("$@")
robots="" composition="" links=() apart="" shared="" station=()
while [ $# -gt 0 ]; do
  case "$1" in
    -h | --help) usage; exit 0 ;;
    --loss | --delay | --rate)
      [ $# -ge 2 ] || fail "$1 needs a value"
      case "$1" in
        --loss) number "$1" "$2" 0 100 ;;
        --delay) number "$1" "$2" 0 10000 ;;
        --rate) number "$1" "$2" 0.01 10000 ;;
      esac
      links+=("$1" "$2")
      shift 2 ;;
    --shared) shared=1; shift ;;
    --apart) apart=1; shift ;;
    --) shift; station=("$@"); break ;;
    -*) fail "unknown option $1" ;;
    *)
      if [ -z "$robots" ]; then robots=$1
      elif [ -z "$composition" ]; then composition=$1
      else fail "unexpected argument \"$1\""; fi
      shift ;;
  esac
done
[ -n "$composition" ] || { usage >&2; exit 2; }
[[ $robots =~ ^[0-9]{1,3}$ ]] && ((10#$robots >= 1 && 10#$robots <= 200)) ||
  fail "N is \"$robots\", not a whole number from 1 to 200"
robots=$((10#$robots))
if [ -n "$shared" ]; then
  [[ " ${links[*]} " = *" --rate "* ]] || fail "--shared says that a rate is shared, and there is no --rate"
  links+=(--shared)
fi
[ -r "$composition" ] || fail "cannot read the composition $composition"

if [ "${PIPESCOUT_FLEET_INSIDE:-}" = 1 ]; then
  unset PIPESCOUT_FLEET_INSIDE
  inside
  exit
fi
[ "$(id -u)" -eq 0 ] || fail "network namespaces need root: run it as root" 1
tools=(ip unshare setpriv pipescout)
[ ${#links[@]} -eq 0 ] || tools+=(pipescout_link_emulator)
for tool in "${tools[@]}"; do
  command -v "$tool" >/dev/null && continue
  case $tool in
    pipescout*) fail "$tool is not on PATH; launch_scripts/build_product.sh builds it, 'source install/setup.bash' puts it there" 1 ;;
    *) fail "$tool is not on PATH" 1 ;;
  esac
done

PIPESCOUT_FLEET_INSIDE=1 setpriv --pdeathsig KILL unshare --net --mount --ipc --pid --fork --mount-proc --kill-child \
  bash "${BASH_SOURCE[0]}" "${all[@]}" &
fleet=$!
trap 'kill -KILL "$fleet" 2>/dev/null; exit 143' TERM INT
wait "$fleet"
