# SPDX-License-Identifier: Apache-2.0
"""A fleet on one machine, for tests and the benchmark: launch_scripts/fleet.sh, and what goes on inside."""

import collections
import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import threading
import time

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
FLEET_SH = ROOT / "launch_scripts" / "fleet.sh"
STATION_ADDRESS = "10.77.0.254"
SERVER = f"{STATION_ADDRESS}:11811"


def why_not():
    """Why a fleet cannot be brought up here; nothing when it can."""
    if os.geteuid() != 0:
        return "network namespaces need root"
    for tool in ("ip", "unshare", "setpriv", "nsenter"):
        if shutil.which(tool) is None:
            return f"{tool} is not on PATH"
    tried = subprocess.run(["unshare", "--net", "--mount", "--ipc", "--pid", "--fork", "--mount-proc",
                            "ip", "link", "add", "trial", "type", "bridge"], text=True,
                           stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    return "" if tried.returncode == 0 else f"no network namespaces: {tried.stdout.strip()}"


def environment(prefix, **more):
    """That of a fleet whose components are built below the prefix."""
    result = {name: value for name, value in os.environ.items()
              if name not in ("ROS_LOCALHOST_ONLY", "ROS_DISCOVERY_SERVER", "ROS_STATIC_PEERS",
                              "ROS_SUPER_CLIENT", "PIPESCOUT_NETWORK")}
    result["AMENT_PREFIX_PATH"] = f"{prefix}:{result.get('AMENT_PREFIX_PATH', '')}"
    result["PATH"] = f"{pathlib.Path(prefix) / 'bin'}:{result['PATH']}"
    return result | more


def built_environment(prefix=None):
    """That in which benchmarks run: of the components that are built below the prefix; without one they are built first."""
    if prefix:
        return environment(prefix.resolve())
    command = (f". {ROOT}/launch_scripts/build_environment.sh && colcon build --packages-up-to "
               "pipescout_fleet --event-handlers console_start_end- console_direct- "
               "--cmake-args -DCMAKE_BUILD_TYPE=Release >&2 && set +u && . install/setup.bash "
               "&& env -0")
    result = subprocess.run(["bash", "-c", command], cwd=ROOT, stdout=subprocess.PIPE, check=True)
    pairs = result.stdout.decode().split("\0")
    built = dict(pair.split("=", 1) for pair in pairs if "=" in pair)
    prefix = ROOT / "build" / "pipescout_fleet" / "prefix"
    env = environment(prefix) | {
        name: built[name] for name in ("LD_LIBRARY_PATH", "CMAKE_PREFIX_PATH") if name in built}
    env["AMENT_PREFIX_PATH"] = f"{env['AMENT_PREFIX_PATH']}:{built['AMENT_PREFIX_PATH']}"
    env["PATH"] = f"{prefix / 'bin'}:{built['PATH']}"
    return env


def run(robots, composition, station, scratch, env, timeout, links=()):
    """Brings a fleet up, runs the command `station` in the station, takes all down. The exit code.

    `links`: options of fleet.sh."""
    shutil.rmtree(scratch, ignore_errors=True)
    scratch.mkdir(parents=True)
    with subprocess.Popen([str(FLEET_SH), str(robots), *links, str(composition), "--", *map(str, station)],
                          cwd=scratch, env=env) as process:
        try:
            return process.wait(timeout)
        except subprocess.TimeoutExpired:
            process.terminate()
            raise


# What follows is for the command in the station, which shares a namespace of processes with the fleet.

def in_fleet(*command, **options):
    """Runs a command where the bridge and the links to the hosts are."""
    return subprocess.run(["nsenter", "-t", "1", "-n", "-m", *map(str, command)], check=True,
                          **options)


def set_link(robot, up):
    in_fleet("ip", "link", "set", f"to_robot_{robot}", "up" if up else "down")


def set_reach(robot, reached):
    """Whether frames pass; the robot itself sees a link that is up."""
    in_fleet("ip", "link", "set", f"to_robot_{robot}", *(["master", "bridge"] if reached else
                                                          ["nomaster"]))


def bytes_on_all_links():
    """All bytes that the bridge has taken from and given to the hosts so far."""
    links = json.loads(in_fleet("ip", "-s", "-j", "link", stdout=subprocess.PIPE).stdout)
    return sum(link["stats64"][way]["bytes"] for link in links
               if link["ifname"].startswith("to_") for way in ("rx", "tx"))


def channel_bytes(robots):
    """(bytes that the hosts gave to the emulated links of robots, bytes that came out of them)"""
    given = taken = 0
    for robot in range(1, robots + 1):
        for command, sent, received in ((["ip", "-n", f"robot_{robot}"], "eth0", "eth0"),
                                        (["ip"], f"to_robot_{robot}", f"to_robot_{robot}")):
            said = in_fleet(*command, "-s", "-j", "link", "show", sent, stdout=subprocess.PIPE).stdout
            statistics = json.loads(said)[0]["stats64"]
            given += statistics["tx"]["bytes"]
            taken += statistics["rx"]["bytes"]
    return given, taken


def start_recording(path):
    """Of all frames on the links of robots, for traffic.py, until it is terminated."""
    return subprocess.Popen(["nsenter", "-t", "1", "-n", "-m", sys.executable, "-B",
                             str(HERE / "traffic.py"), "record", str(path)])


def start_on_host(host, *command, log=None):
    """Starts a command as one of fleet.sh's own."""
    inside = 'mount -t tmpfs -o size=256m tmpfs /dev/shm; exec "$@"'
    output = open(log, "ab") if log else None
    # Its missions are written where those of the others are, which the namespace of mounts forgets.
    return subprocess.Popen(["nsenter", "-t", "1", "-n", "-m", f"--wdns={pathlib.Path.cwd()}", "ip",
                             "netns", "exec", host, "bash", "-c", inside, "_", *map(str, command)],
                            stdout=output, stderr=output)


def robot_processes(robot):
    """The ids of the processes `pipescout run ... --namespace robot_K`."""
    found = []
    for folder in pathlib.Path("/proc").iterdir():
        if folder.name.isdigit():
            try:
                words = (folder / "cmdline").read_bytes().decode().split("\0")
            except OSError:
                continue
            if words[0].endswith("pipescout") and f"robot_{robot}" in words:
                found.append(int(folder.name))
    return found


def kill_robot(robot):
    processes = robot_processes(robot)
    for process in processes:
        os.kill(process, signal.SIGKILL)
    return len(processes)


def resident_bytes(process):
    """Of the memory of a process what is in RAM and its own."""
    for line in pathlib.Path(f"/proc/{process}/status").read_text().splitlines():
        if line.startswith("RssAnon:"):
            return 1024 * int(line.split()[1])
    raise AssertionError(f"/proc/{process}/status has no RssAnon")


def wait_until(holds, timeout, what):
    end = time.monotonic() + timeout
    while not holds():
        if time.monotonic() > end:
            raise AssertionError(f"after {timeout} s: {what}")
        time.sleep(0.05)


class Station:
    """Runs fleet_station and keeps what it hears."""

    def __init__(self, robots):
        self.robots = [f"robot_{k}" for k in range(1, robots + 1)]
        self.lock = threading.Lock()
        self.last = {}  # (robot, topic): time of the last message
        self.ages = collections.defaultdict(list)  # of the states of a robot
        self.numbered = collections.defaultdict(dict)  # likewise, by their numbers
        self.publish_times = collections.defaultdict(list)  # of the images of a robot, s
        self.findings = collections.defaultdict(set)
        self.repeated = 0  # findings that came more than once
        self.times = collections.defaultdict(list)  # of the states of a robot
        self.started = time.monotonic()
        self.process = subprocess.Popen(["fleet_station", str(robots)], stdout=subprocess.PIPE,
                                        text=True)
        self.thread = threading.Thread(target=self._listen, daemon=True)
        self.thread.start()

    def _listen(self):
        for line in self.process.stdout:
            moment, robot, topic, number, age = line.split()
            with self.lock:
                self.last[robot, topic] = float(moment)
                if topic == "finding":
                    self.repeated += int(number) in self.findings[robot]
                    self.findings[robot].add(int(number))
                elif topic == "state":
                    self.ages[robot].append(float(age))
                    self.numbered[robot][int(number)] = float(age)
                    self.times[robot].append(float(moment))
                elif topic == "publish_time":
                    self.publish_times[robot].append(1e-9 * float(number))

    def heard_since(self, moment, robots=None, topic="state"):
        with self.lock:
            return all(self.last.get((robot, topic), 0.0) > moment
                       for robot in (self.robots if robots is None else robots))

    def await_all(self, timeout=60.0, robots=None):
        """Until a state of each robot comes that comes after now."""
        now = time.monotonic()
        wait_until(lambda: self.heard_since(now, robots), timeout,
                   f"not all states came; heard of {sorted(self.last)}")
        return time.monotonic() - now

    def first_state_after(self, moment, robot):
        """How long after that moment a state came."""
        with self.lock:
            return next(each for each in self.times[robot] if each > moment) - moment

    def missing_findings(self, robot, first, last):
        """Of those from `first` to `last`, both included."""
        with self.lock:
            return sorted(set(range(first, last + 1)) - self.findings[robot])

    def lost_findings(self, robot):
        with self.lock:
            found = self.findings[robot]
            return sorted(set(range(max(found) + 1)) - found) if found else []

    def stop(self):
        self.process.terminate()
        code = self.process.wait(10)
        assert code == 0, f"fleet_station: {code}"
