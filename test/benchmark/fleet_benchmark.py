#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""How soon the robots of a fleet are found, what that costs, and how soon they are back.

Each robot, of five components, runs in a network namespace of its own, and a station in another
(launch_scripts/fleet.sh); needs root. Robots are started out of reach of each other and of the
station, so that the time to start twenty processes on one machine does not count:

discovery_server_s       from all in reach until a state of each robot has come to the station, by a
                         discovery server
discovery_multicast_s    the same by multicast
discovery_bytes_percent  bytes on all links in the first 15 s by server, in % of those by multicast
recovery_link_p100_s     the longest time from link up until states came, after outages longer than
                         the 20 s in which participants forget each other
recovery_kill_p100_s     the longest time from the new start of a killed robot until its states came
recovery_p100_s          the longer of the two
recovery_lost_findings   numbered findings of the outages, kept for late comers, that never came
wifi_state_p99_ms        age of the states of four robots that send an image every 2 s, each over
                         a link of 5 Mbit/s, with PIPESCOUT_NETWORK=wifi:2

Builds what it runs.
"""
import argparse
import json
import pathlib
import statistics
import subprocess
import sys
import tempfile
import time

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
sys.dont_write_bytecode = True
sys.path.insert(0, str(ROOT / "test" / "fleet"))
import fleet  # noqa: E402  (its folder is known only now)

COMPOSITION = fleet.HERE / "robot.yaml"
WINDOW = 15.0  # s, in which bytes are counted
LONG = 120.0  # s
TARGETS = {"discovery_server_s": 5.0, "discovery_multicast_s": 10.0,
           "discovery_bytes_percent": 2.0, "recovery_p100_s": 3.0, "recovery_lost_findings": 0,
           "wifi_state_p99_ms": 100.0}


def build():
    """The environment in which the fleets run."""
    command = (f". {ROOT}/launch_scripts/build_environment.sh && colcon build --packages-up-to "
               "pipescout_fleet --event-handlers console_start_end- console_direct- "
               "--cmake-args -DCMAKE_BUILD_TYPE=Release >&2 && set +u && . install/setup.bash "
               "&& env -0")
    result = subprocess.run(["bash", "-c", command], cwd=ROOT, stdout=subprocess.PIPE, check=True)
    pairs = result.stdout.decode().split("\0")
    return dict(pair.split("=", 1) for pair in pairs if "=" in pair)


# What follows up to `main` runs in the station.

def start_server():
    with_output = {"stdout": subprocess.PIPE, "text": True}
    server = subprocess.Popen(["pipescout", "discovery", "start"], **with_output)
    assert "listens" in server.stdout.readline()
    return server


def await_robots(robots):
    fleet.wait_until(lambda: all(fleet.robot_processes(k) for k in range(1, robots + 1)), LONG,
                     "not all robots have started")
    fleet.wait_until(lambda: len(list(pathlib.Path("missions").glob("*/mission.yaml"))) >= robots,
                     LONG, "not all robots are up")


def measure_discovery(options):
    server = start_server() if options.server else None
    await_robots(options.robots)
    station = fleet.Station(options.robots)
    time.sleep(2.0)  # No event: the station has nobody to hear of.
    before = fleet.bytes_on_all_links()
    begin = time.monotonic()
    for robot in range(1, options.robots + 1):
        fleet.set_reach(robot, True)
    fleet.wait_until(lambda: station.heard_since(begin), LONG, "not all states came")
    took = time.monotonic() - begin
    time.sleep(max(0.0, begin + WINDOW - time.monotonic()))  # No event: the end of the window.
    sent = fleet.bytes_on_all_links() - before
    station.stop()
    if server:
        server.terminate()
    return {"complete_s": round(took, 3), "megabytes": round(sent / 1e6, 3)}


def measure_recovery(options):
    station = fleet.Station(options.robots)
    station.await_all(LONG)
    outages = []
    for number in range(options.outages):
        robot = 1 + number % options.robots
        fleet.set_link(robot, False)
        time.sleep(options.outage)  # No event: the link is down so long.
        fleet.set_link(robot, True)
        outages.append(station.await_all(LONG, [f"robot_{robot}"]))
    time.sleep(3.0)  # No event: what is not repeated by now is lost.
    lost = sum(len(station.lost_findings(robot)) for robot in station.robots)
    kills = []
    for number in range(options.kills):
        robot = 1 + number % options.robots
        assert fleet.kill_robot(robot) == 1
        time.sleep(0.5)  # No event: its last messages arrive.
        begin = time.monotonic()
        fleet.start_on_host(f"robot_{robot}", "pipescout", "run", COMPOSITION, "--namespace",
                            f"robot_{robot}", log="again.log")
        fleet.wait_until(lambda: station.heard_since(begin, [f"robot_{robot}"]), LONG,
                         "a killed robot is not back")
        kills.append(time.monotonic() - begin)
    station.stop()
    return {"outages_s": [round(each, 3) for each in outages], "lost_findings": lost,
            "kills_s": [round(each, 3) for each in kills]}


def measure_wifi(options):
    station = fleet.Station(options.robots)
    station.await_all(LONG)
    fleet.wait_until(lambda: station.heard_since(0.0, topic="image"), LONG, "no images come")
    with station.lock:
        station.ages.clear()
    time.sleep(20.0)  # No event: a sample of so long.
    with station.lock:
        ages = [age for each in station.ages.values() for age in each]
        images = sum(topic == "image" for _, topic in station.last)
    station.stop()
    return {"state_p99_ms": round(1e3 * statistics.quantiles(ages, n=100)[98], 1),
            "states": len(ages), "robots_with_images": images}


MEASUREMENTS = {each.__name__: each for each in (measure_discovery, measure_recovery, measure_wifi)}


def in_fleet(options, measurement, robots, env, server=False, composition=COMPOSITION, links=()):
    """Brings a fleet up, and gives what the measurement in its station gives."""
    with tempfile.TemporaryDirectory(prefix="pipescout_fleet_") as scratch:
        result = pathlib.Path(scratch) / "result.json"
        station = [sys.executable, "-B", __file__, "--inside", measurement, "--result", result,
                   "--robots", robots, "--outages", options.outages, "--outage", options.outage,
                   "--kills", options.kills] + (["--server"] if server else [])
        code = fleet.run(robots, composition, station, pathlib.Path(scratch) / "fleet", env,
                         timeout=3600, links=links)
        if code != 0:
            sys.exit(f"{measurement} failed ({code})")
        return json.loads(result.read_text())


def main():
    parser = argparse.ArgumentParser(prog="test/benchmark/run.sh fleet", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", metavar="FILE", help="writes figures and rows to FILE")
    parser.add_argument("--robots", type=int, default=20, help="of the discovery (default: 20)")
    parser.add_argument("--outages", type=int, default=4, help="of links (default: 4)")
    parser.add_argument("--outage", type=float, default=25.0, help="s of each (default: 25)")
    parser.add_argument("--kills", type=int, default=12, help="of robots (default: 12)")
    parser.add_argument("--only", nargs="+", choices=("discovery", "recovery", "wifi"),
                        default=["discovery", "recovery", "wifi"], help="only these")
    parser.add_argument("--prefix", type=pathlib.Path,
                        help="run what is built there, in the present environment")
    parser.add_argument("--inside", choices=list(MEASUREMENTS), help=argparse.SUPPRESS)
    parser.add_argument("--result", type=pathlib.Path, help=argparse.SUPPRESS)
    parser.add_argument("--server", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.inside:
        options.result.write_text(json.dumps(MEASUREMENTS[options.inside](options)))
        return
    if reason := fleet.why_not():
        sys.exit(f"cannot run: {reason}")
    if options.prefix:
        env = fleet.environment(options.prefix)
    else:
        built = build()
        env = fleet.environment(ROOT / "build" / "pipescout_fleet" / "prefix") | {
            name: built[name] for name in ("LD_LIBRARY_PATH", "CMAKE_PREFIX_PATH") if name in built}
        env["AMENT_PREFIX_PATH"] = f"{env['AMENT_PREFIX_PATH']}:{built['AMENT_PREFIX_PATH']}"
        env["PATH"] = f"{ROOT / 'build/pipescout_fleet/prefix/bin'}:{built['PATH']}"
    figures = {}
    rows = []
    if "discovery" in options.only:
        found = {}
        for way, more in (("server", {"ROS_DISCOVERY_SERVER": fleet.SERVER}), ("multicast", {})):
            found[way] = in_fleet(options, "measure_discovery", options.robots, env | more,
                                  server=way == "server", links=("--apart",))
            rows.append({"case": f"discovery by {way}", "robots": options.robots} | found[way])
            print(rows[-1], flush=True)
            figures[f"discovery_{way}_s"] = found[way]["complete_s"]
        figures["discovery_bytes_percent"] = round(
            100.0 * found["server"]["megabytes"] / found["multicast"]["megabytes"], 2)
    if "recovery" in options.only:
        found = in_fleet(options, "measure_recovery", 4, env)
        rows.append({"case": "recovery", "robots": 4, "outage_s": options.outage} | found)
        print(rows[-1], flush=True)
        figures["recovery_link_p100_s"] = max(found["outages_s"])
        figures["recovery_kill_p100_s"] = max(found["kills_s"])
        figures["recovery_p100_s"] = max(found["outages_s"] + found["kills_s"])
        figures["recovery_lost_findings"] = found["lost_findings"]
    if "wifi" in options.only:
        found = in_fleet(options, "measure_wifi", 4, env | {"PIPESCOUT_NETWORK": "wifi:2"},
                         composition=fleet.HERE / "robot_with_images.yaml", links=("--rate", "5"))
        rows.append({"case": "images over links of 5 Mbit/s", "robots": 4} | found)
        print(rows[-1], flush=True)
        figures["wifi_state_p99_ms"] = found["state_p99_ms"]
    print()
    for name, value in figures.items():
        target = TARGETS.get(name)
        said = "" if target is None else \
            f"   at most {target:8.3f}   {'met' if value <= target else 'NOT MET'}"
        print(f"{name:<28}{value:12.3f}{said}")
    if options.json:
        document = {"figures": figures, "rows": rows, "seeds": []}
        pathlib.Path(options.json).write_text(json.dumps(document, indent=2) + "\n")


if __name__ == "__main__":
    main()
