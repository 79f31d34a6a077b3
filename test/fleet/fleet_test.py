#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Four robots and a station, each in a network namespace of its own.

    fleet_test.py CASE PREFIX SCRATCH

PREFIX is where the components of the test are built. Exits with 77 where there are no namespaces.
"""

import contextlib
import json
import os
import pathlib
import shutil
import signal
import socket
import statistics
import subprocess
import sys
import time

import fleet

ROBOTS = 4
NAMES = [f"robot_{k}" for k in range(1, ROBOTS + 1)]
SKIPPED = 77
NAME_TAKEN = 69  # exit code of `pipescout run`
LONG = 60.0  # s, for what takes a second or a few on an idle machine
DELAY = 0.02  # s, of the lossy links
LEASE = 20.0  # s, after which participants forget one that is silent
PATH_MTU = 1280  # bytes, of the paths whose ends claim 1500


def pipescout(*arguments, check=True):
    result = subprocess.run(["pipescout", *arguments], stdout=subprocess.PIPE, text=True,
                            timeout=LONG)
    print(result.stdout, flush=True)
    assert not check or result.returncode == 0, f"pipescout {arguments}: {result.returncode}"
    return result.stdout


def status():
    """The robots by name, as `pipescout fleet status` has them."""
    document = json.loads(pipescout("fleet", "status", "--once", "--json"))
    return {robot["name"]: robot for robot in document["robots"]}


def start_robot(robot, host=None, composition="robot.yaml"):
    return fleet.start_on_host(host or f"robot_{robot}", "pipescout", "run",
                               fleet.HERE / composition, "--namespace", f"robot_{robot}",
                               log=f"again_{robot}.log")


def discovery(station):
    station.await_all()
    robots = {}

    def all_batteries():
        robots.update(status())
        return all(robots.get(name, {}).get("battery_percent") for name in NAMES)

    # One look lasts 2.5 s, in which a busy machine need not hear of all batteries.
    fleet.wait_until(all_batteries, LONG, "not all batteries are heard of")
    assert sorted(name for name in robots if name != "/") == NAMES, robots
    for name in NAMES:
        robot = robots[name]
        assert robot["nodes"] == 6, robot  # five components and their host
        assert robot["started"] and robot["cpu_percent"] is not None, robot
        assert robot["battery_percent"] == 50.0, robot
        assert abs(robot["clock_offset_s"]) < 0.5, robot  # they share one clock
    table = pipescout("fleet", "status", "--once")
    assert all(name in table for name in NAMES)


def link(station):
    station.await_all()
    fleet.wait_until(lambda: station.heard_since(0.0, topic="finding"), LONG, "no findings come")
    fleet.set_link(2, False)
    down = time.monotonic()
    others = [name for name in NAMES if name != "robot_2"]
    fleet.wait_until(lambda: time.monotonic() > down + LEASE + 5.0, LONG, "time stands still")
    assert not station.heard_since(down + 1.0, ["robot_2"]), "the link is not down"
    assert station.heard_since(time.monotonic() - 5.0, others), "the others suffered"
    fleet.set_link(2, True)
    took = station.await_all(robots=["robot_2"])
    print(f"data again {took:.2f} s after the link was up", flush=True)
    # What was found meanwhile comes too.
    up = time.monotonic()
    fleet.wait_until(lambda: station.heard_since(up + 2.0, ["robot_2"], "finding"), LONG,
                     "no new findings")
    fleet.wait_until(lambda: not station.lost_findings("robot_2"), LONG, "findings are lost")


def lossy(station):
    """A radio channel that loses frames: each state is late, and no finding is lost."""
    station.await_all()
    fleet.wait_until(lambda: station.heard_since(0.0, topic="finding"), LONG, "no findings come")
    begin = time.monotonic()
    fleet.wait_until(lambda: station.heard_since(begin + 10.0, topic="finding"), LONG,
                     "findings stop")
    fleet.wait_until(lambda: not any(map(station.lost_findings, NAMES)), LONG, "findings are lost")
    ages = [age for of_one in station.ages.values() for age in of_one]
    assert min(ages) >= DELAY, f"{min(ages)} s: the delay is not there"
    print(f"{len(ages)} states; median age {1e3 * statistics.median(ages):.1f} ms", flush=True)


def killed(station):
    station.await_all()
    assert fleet.kill_robot(3) == 1
    fell_silent = time.monotonic()
    station.await_all(robots=[name for name in NAMES if name != "robot_3"])
    robot = start_robot(3)
    try:
        took = station.await_all(robots=["robot_3"])
        print(f"data again {took:.2f} s after the new start", flush=True)
        assert station.heard_since(fell_silent)
    finally:
        robot.terminate()
    assert robot.wait(LONG) == 0


def start_server():
    return subprocess.Popen(["pipescout", "discovery", "start"])


def server(station):
    """All is found through a discovery server; one that is killed serves again once it is back."""
    said = pipescout("discovery", "list", check=False)
    assert "does not answer" in said, said
    running = start_server()
    station.await_all()
    assert "answers" in pipescout("discovery", "list")
    assert set(NAMES) <= set(status())
    running.kill()
    running.wait()
    station.await_all()  # who know each other need no server
    running = start_server()
    assert fleet.kill_robot(4) == 1
    killed_at = time.monotonic()
    robot = start_robot(4)
    try:
        fleet.wait_until(lambda: station.heard_since(killed_at + 1.0, ["robot_4"]), LONG,
                         "the new robot is not found")
        station.await_all()
    finally:
        robot.terminate()
        robot.wait(LONG)
        running.terminate()
    assert running.wait(LONG) == 0


def moved(station):
    """A server that is known by two places, of which the first one is given up."""
    first = start_server()
    station.await_all()
    first.terminate()
    assert first.wait(LONG) == 0
    second = fleet.start_on_host("robot_2", "pipescout", "discovery", "start", "--server-id", "1",
                                 log="second_server.log")
    assert fleet.kill_robot(4) == 1
    killed_at = time.monotonic()
    robot = start_robot(4)
    try:
        fleet.wait_until(lambda: station.heard_since(killed_at + 1.0, ["robot_4"]), LONG,
                         "the new robot is not found")
        station.await_all()
    finally:
        robot.terminate()
        robot.wait(LONG)
        second.terminate()
        second.wait(LONG)


def mtu(station):
    """Paths swallow what their ends believe to fit; a robot that comes then is found and heard."""
    for host in (*NAMES, "station"):
        fleet.in_fleet("ip", "link", "set", f"to_{host}", "mtu", PATH_MTU)
    assert sizes_that_arrive((PATH_MTU - 100, PATH_MTU + 100, 100)) == [PATH_MTU - 100, 100]
    assert fleet.kill_robot(3) == 1
    robot = start_robot(3, composition="robot_with_images.yaml")
    try:
        for topic in ("state", "finding", "image"):
            begin = time.monotonic()
            fleet.wait_until(lambda: station.heard_since(begin + 1.0, topic=topic), LONG,
                             f"a topic is silent: {topic}")
        assert set(NAMES) <= set(status())
    finally:
        robot.terminate()
    assert robot.wait(LONG) == 0


def sizes_that_arrive(sizes):
    """Of datagrams from robot_1, until the last one."""
    port = 9999
    send = ("import socket, sys; s = socket.socket(type=socket.SOCK_DGRAM); "
            f"[s.sendto(bytes(int(n)), ('{fleet.STATION_ADDRESS}', {port})) for n in sys.argv[1:]]")
    arrived = []
    with socket.socket(type=socket.SOCK_DGRAM) as listener:
        listener.bind((fleet.STATION_ADDRESS, port))
        listener.settimeout(LONG)
        sender = fleet.start_on_host("robot_1", sys.executable, "-c", send, *sizes)
        while not arrived or arrived[-1] != sizes[-1]:
            arrived.append(len(listener.recv(65536)))
        assert sender.wait(LONG) == 0
    return arrived


def names(station):
    """A robot of a name that is taken is refused; of two that meet later the later one gives way."""
    station.await_all()
    refused = start_robot(1, host="robot_4")
    assert refused.wait(LONG) == NAME_TAKEN
    assert "has a node /robot_1/" in pathlib.Path("again_1.log").read_text()
    fleet.set_reach(4, False)
    fleet.wait_until(lambda: not fleet_knows("robot_4"), LONG, "robot_4 is still known")
    second = start_robot(1, host="robot_4")
    said = lambda: pathlib.Path("again_1.log").read_text()  # noqa: E731
    try:
        fleet.wait_until(lambda: "components are active" in said(), LONG, "it did not start")
        begin = time.monotonic()
        fleet.set_reach(4, True)
        fleet.wait_until(lambda: "the components become inactive" in said(), LONG,
                         "the later one does not give way")
        # Both have a status of that name; a list of the fleet shows the one that came last.
        with subprocess.Popen(["pipescout", "topic", "echo", "-f", "/diagnostics"], text=True,
                              stdout=subprocess.PIPE) as heard:
            try:
                assert any("this one gives way" in line for line in heard.stdout), "nobody says so"
            finally:
                heard.terminate()
        # The earlier one goes on as if nothing had been.
        station.await_all(robots=["robot_1"])
        print(f"the later one gave way {time.monotonic() - begin:.2f} s after they met", flush=True)
    finally:
        second.terminate()
        code = second.wait(LONG)
    assert code == NAME_TAKEN, code
    station.await_all(robots=["robot_1"])


def fleet_knows(name):
    return status().get(name, {"nodes": 0})["nodes"] > 0


def export(station):
    """What is not exported stays on the robot, where the command line still hears it."""
    station.await_all()
    fleet.wait_until(lambda: station.heard_since(0.0, topic="image"), LONG, "no reduced images")
    fleet.wait_until(lambda: "nobody publishes /robot_1/nothing" in status()["robot_1"]["message"],
                     LONG, "nobody says that an exported topic is not published")
    assert not station.findings, "findings have left a robot"
    echo = ["pipescout", "topic", "echo", "--once", "/robot_1/finding"]
    with_memory = subprocess.run(["nsenter", "-t", str(fleet.robot_processes(1)[0]), "-n", "-m",
                                  *echo], stdout=subprocess.PIPE, text=True, timeout=LONG)
    assert "frame_id" in with_memory.stdout, with_memory


@contextlib.contextmanager
def running(*arguments):
    """`pipescout run`, until the end of the block."""
    process = subprocess.Popen(["pipescout", "run", *map(str, arguments)])
    try:
        yield
    finally:
        process.terminate()
        code = process.wait(LONG)
    assert code == 0, f"pipescout run: {code}"


def seen_from_outside():
    """Nodes and topics of two robots, and a state that each follower has from its own robot."""
    with_nodes = []

    def all_there():
        with_nodes[:] = pipescout("node", "list").split()
        return sum("follower" in name for name in with_nodes) == 8

    topics = []

    def as_many_topics_of_both():
        # A process whose announcement was lost is missing from a list, until the next one.
        topics[:] = sorted(pipescout("topic", "list", "--show-types").splitlines())
        of_1, of_2 = (sum(topic.startswith(f"/robot_{robot}/") for topic in topics)
                      for robot in (1, 2))
        return of_1 == of_2 > 0

    fleet.wait_until(all_there, LONG, "not all nodes are there")
    fleet.wait_until(as_many_topics_of_both, LONG, "not all topics are there")
    numbers = {}
    for robot in (1, 2):
        for follower in (1, 2, 3, 4):
            text = pipescout("topic", "echo", "--once", f"/robot_{robot}/follower_{follower}/state")
            numbers[robot, follower] = float(text.split("x:")[1].split()[0]) >= 1e6
    # Each process has a host of its own, with other services and /diagnostics of it.
    nodes = [name for name in with_nodes if "container" not in name]
    return sorted(nodes), topics, numbers


def twice(scratch):
    """A composition twice in one process is to others what it is in two."""
    scratch.mkdir(parents=True, exist_ok=True)
    os.chdir(scratch)
    with running(fleet.HERE / "two_robots.yaml"):
        together = seen_from_outside()
    robot = fleet.HERE / "robot.yaml"
    with running(robot, "--namespace", "robot_1"), \
            running(robot, "first_number:=1000000", "--namespace", "robot_2"):
        apart = seen_from_outside()
    assert together == apart, f"{together}\n{apart}"
    assert together[2] == {(robot, follower): robot == 2 for robot in (1, 2)
                           for follower in (1, 2, 3, 4)}, together[2]


def words_of(process):
    """Its command line."""
    with contextlib.suppress(OSError):
        return pathlib.Path(f"/proc/{process}/cmdline").read_bytes().decode().split("\0")
    return []


def with_word(word):
    """The command lines with this word of all processes."""
    every = (words_of(folder.name) for folder in pathlib.Path("/proc").iterdir()
             if folder.name.isdigit())
    return [words for words in every if word in words]


def ended(scratch, env):
    """Nothing of a fleet is left when its script ends, whichever way."""
    shutil.rmtree(scratch, ignore_errors=True)
    scratch.mkdir(parents=True)
    composition = scratch / "robot.yaml"
    shutil.copy(fleet.HERE / "robot.yaml", composition)
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGKILL):
        with open(scratch / "fleet.log", "ab") as log:
            script = subprocess.Popen([str(fleet.FLEET_SH), "2", "--delay", "1", str(composition)],
                                      cwd=scratch, env=env, stdout=log, stderr=log)
        fleet.wait_until(lambda: sum("--namespace" in words for words in
                                     with_word(str(composition))) == 2, LONG, "no robots")
        script.send_signal(number)
        assert script.wait(LONG) != 0
        fleet.wait_until(lambda: not with_word(str(composition)), LONG,
                         f"processes are left after {number.name}")
        print(f"after {number.name} nothing is left", flush=True)


def secured(station):
    """Export and the profile for Wi-Fi with security: as without, and a stranger hears nothing."""
    export(station)
    stranger = subprocess.run(["pipescout", "topic", "list"], stdout=subprocess.PIPE, text=True,
                              timeout=LONG, env=os.environ | {"ROS_SECURITY_ENABLE": "false"})
    assert "robot_" not in stranger.stdout, stranger.stdout


def make_keystore(keystore, env):
    """One enclave for all. What its processes need in the environment."""
    shutil.rmtree(keystore, ignore_errors=True)
    keystore.parent.mkdir(parents=True, exist_ok=True)
    for arguments in (("create-keystore", keystore), ("create-enclave", keystore, "/")):
        subprocess.run(["pipescout", "security", *map(str, arguments)], check=True, timeout=LONG,
                       env=env)
    return {"ROS_SECURITY_ENABLE": "true", "ROS_SECURITY_STRATEGY": "Enforce",
            "ROS_SECURITY_KEYSTORE": str(keystore)}


CASES = {case.__name__: case for case in
         (discovery, link, lossy, mtu, killed, server, moved, names, export, secured)}
LINKS = {"lossy": ("--loss", "5", "--delay", f"{1e3 * DELAY:g}", "--rate", "20", "--shared")}
WIFI = {"PIPESCOUT_NETWORK": "wifi"}
MORE = {"server": {"ROS_DISCOVERY_SERVER": fleet.SERVER},
        "moved": {"ROS_DISCOVERY_SERVER": f"{fleet.STATION_ADDRESS};10.77.0.2"},
        "lossy": WIFI, "mtu": WIFI, "secured": WIFI}
COMPOSITIONS = {"export": "exporting_robot.yaml", "secured": "exporting_robot.yaml",
                "mtu": "robot_with_images.yaml"}


def inside(case):
    station = fleet.Station(ROBOTS)
    CASES[case](station)
    station.stop()
    print(f"{case}: passed", flush=True)


def main():
    if sys.argv[1] == "--inside":
        inside(sys.argv[2])
        return 0
    case = sys.argv[1]
    prefix, scratch = (pathlib.Path(each).resolve() for each in sys.argv[2:4])
    if case == "twice":
        os.environ.update(fleet.environment(prefix, ROS_LOCALHOST_ONLY="1"))
        twice(scratch)
        return 0
    if reason := fleet.why_not():
        print(f"SKIPPED: {reason}")
        return SKIPPED
    env = fleet.environment(prefix, PYTHONDONTWRITEBYTECODE="1", **MORE.get(case, {}))
    if case == "ended":
        ended(scratch, env)
        return 0
    if case == "secured":
        env |= make_keystore(scratch.parent / "keystore", env)
    return fleet.run(ROBOTS, fleet.HERE / COMPOSITIONS.get(case, "robot.yaml"),
                     [sys.executable, pathlib.Path(__file__).resolve(), "--inside", case], scratch,
                     env, timeout=280, links=LINKS.get(case, ()))


if __name__ == "__main__":
    sys.exit(main())
