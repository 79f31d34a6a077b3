#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Runs a composition on N robots, each in a network namespace of its own behind a bridge, and a station in another.
#
#   launch_scripts/fleet.sh N [--loss PERCENT] [--delay MS] [--rate MBIT] [--apart] COMPOSITION [-- STATION COMMAND]
#
# Robot K has the namespace robot_K and the address 10.77.0.K, the station 10.77.0.254. Loss, delay and rate hold for
# each robot's link, in each direction. The link of robot K is the interface to_robot_K of the bridge where the fleet's
# first process is: "nsenter -t 1 -n ip link set to_robot_K down" from within cuts it, "nomaster" takes the robot out of
# reach, "master bridge" back; with --apart all begin out of reach. Ends with the station command, or, without one, when
# it is interrupted.
# Needs root, for the namespaces. All lives in namespaces that die with this script, even when it is killed.
set -euo pipefail
unset CDPATH

usage() { sed -n '3,12s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"; }
fail() { echo "fleet.sh: $1" >&2; exit "${2:-2}"; }

# Runs a command as host NAME: with a network and a /dev/shm of its own.
on_host() {
  local name=$1
  shift
  ip netns exec "$name" bash -c 'mount -t tmpfs -o size=256m tmpfs /dev/shm; exec "$@"' _ "$@"
}

add_host() {
  local name=$1 address=$2
  ip netns add "$name"
  ip link add "to_$name" type veth peer name eth0 netns "$name"
  ip link set "to_$name" master bridge up
  ip -n "$name" link set lo up
  ip -n "$name" address add "$address/24" dev eth0
  ip -n "$name" link set eth0 up
  ip -n "$name" route add 224.0.0.0/4 dev eth0
}

# A rate alone is kept by tbf, which kernels without netem have too: bursts of ten frames, queues of 50 ms.
impair() {
  local name=$1
  if [ ${#netem[@]} -eq 2 ] && [ "${netem[0]}" = rate ]; then
    tc qdisc add dev "to_$name" root tbf "${netem[@]}" burst 15kb latency 50ms
    tc -n "$name" qdisc add dev eth0 root tbf "${netem[@]}" burst 15kb latency 50ms
    return
  fi
  [ ${#netem[@]} -gt 0 ] || return 0
  tc qdisc add dev "to_$name" root netem "${netem[@]}" ||
    fail "the kernel does not take \"netem ${netem[*]}\": --loss and --delay need sch_netem" 1
  tc -n "$name" qdisc add dev eth0 root netem "${netem[@]}"
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
  local robot
  for ((robot = 1; robot <= robots; ++robot)); do
    add_host "robot_$robot" "10.77.0.$robot"
    [ -z "$apart" ] || ip link set "to_robot_$robot" nomaster
    impair "robot_$robot"
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
robots="" composition="" netem=() apart="" station=()
while [ $# -gt 0 ]; do
  case "$1" in
    -h | --help) usage; exit 0 ;;
    --loss | --delay | --rate)
      [ $# -ge 2 ] || fail "$1 needs a value"
      case "$1" in
        --loss) number "$1" "$2" 0 100; netem+=(loss "$2%") ;;
        --delay) number "$1" "$2" 0 10000; netem+=(delay "$2ms") ;;
        --rate) number "$1" "$2" 0.01 10000; netem+=(rate "$2mbit") ;;
      esac
      shift 2 ;;
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
[ -r "$composition" ] || fail "cannot read the composition $composition"

if [ "${PIPESCOUT_FLEET_INSIDE:-}" = 1 ]; then
  unset PIPESCOUT_FLEET_INSIDE
  inside
  exit
fi
[ "$(id -u)" -eq 0 ] || fail "network namespaces need root: run it as root" 1
for tool in ip tc unshare setpriv pipescout; do
  command -v "$tool" >/dev/null || fail "$tool is not on PATH" 1
done

PIPESCOUT_FLEET_INSIDE=1 setpriv --pdeathsig KILL unshare --net --mount --ipc --pid --fork --mount-proc --kill-child \
  bash "${BASH_SOURCE[0]}" "${all[@]}" &
fleet=$!
trap 'kill -KILL "$fleet" 2>/dev/null; exit 143' TERM INT
wait "$fleet"
