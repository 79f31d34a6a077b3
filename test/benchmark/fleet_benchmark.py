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
                         the 20 s in which participants forget each other; all links at once
recovery_kill_p100_s     the longest time from the new start of a killed robot until its states came
recovery_p100_s          the longer of the two
recovery_lost_findings   numbered findings of the outages, kept for late comers, that never came
recovery_server_p100_s   the longest silence of any robot while the discovery server is killed and
                         started again
wifi_state_p99_ms        age of the states of four robots that send an image every 2 s, each over
                         a link of 5 Mbit/s, with PIPESCOUT_NETWORK=wifi:2
state_p99_ms             age of the states of twenty robots, four of which send two images of 160x128
                         a second, over one radio channel of 20 Mbit/s that loses 5 % and delays by
                         20 ms, with PIPESCOUT_NETWORK=wifi:1 and a discovery server; a lost state
                         counts with the age that it has when the next one comes
lost_findings            numbered findings of these robots that never came
duplicate_names_started  robots that started although another one of their name ran, or both of two that were started
                         together: on one machine (loopback), of --names starts
duplicate_names_lossy    the same on four hosts whose links lose 5 % and delay by 20 ms
events_lost              of the numbered events (QoS of `weld`) of all robots, those that never came to a station
                         that was there before --events outages of 30 s each; all links at once, so that
                         20 outages of four robots take five times 30 s
late_events_missing      of the events that robots kept before a station came, those that it does not
                         have 10 s after its first one, over links that lose 5 % and delay by 20 ms, with
                         the default network profile
away_megabytes           growth of the memory of a robot that nobody can reach: by default for 60 s
                         with ten times as many messages as usual, as many as in ten minutes;
                         above 90 s with the usual ones, of which 1000 findings are kept
publish_p99_ratio        99 % of the images are published within so many times the time that it takes
                         without the reader behind a link of 1 Mbit/s (publish_p99_us with it)

Builds what it runs.
"""
import argparse
import json
import os
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
           "recovery_server_p100_s": 3.0,
           "wifi_state_p99_ms": 100.0, "state_p99_ms": 100.0, "lost_findings": 0,
           "duplicate_names_started": 0, "duplicate_names_lossy": 0, "events_lost": 0,
           "late_events_missing": 0,
           "away_megabytes": 20.0, "publish_p99_ratio": 1.2}
LOSSY = ("--loss", "5", "--delay", "20", "--rate", "20", "--shared")
WITH_IMAGES = 4  # robots of the lossy channel
SLOW = ("--rate", "1")
STATE_PERIOD = 0.1  # s
LOSSY_LINKS = ("--loss", "5", "--delay", "20")
EVENT_OUTAGE = 30.0  # s, longer than the 20 s in which participants forget each other
NAME_TAKEN = 69  # exit code of `pipescout run`
LONGEST_AT_TEN_TIMES = 90.0  # s, in which the findings are fewer than a robot keeps


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


def start_robot(robot, composition, host=None):
    name = f"robot_{robot}"
    return fleet.start_on_host(host or name, "pipescout", "run", composition, "--namespace", name,
                               log="again.log")


def measure_discovery(options):
    server = start_server() if options.server else None
    await_robots(options.robots)
    station = fleet.Station(options.robots)
    time.sleep(2.0)  # No event: the station has nobody to hear of.
    recording = options.traffic and fleet.start_recording(
        f"{options.traffic}.server" if options.server else options.traffic)
    before = fleet.bytes_on_all_links()
    begin = time.monotonic()
    for robot in range(1, options.robots + 1):
        fleet.set_reach(robot, True)
    fleet.wait_until(lambda: station.heard_since(begin), LONG, "not all states came")
    took = time.monotonic() - begin
    time.sleep(max(0.0, begin + WINDOW - time.monotonic()))  # No event: the end of the window.
    sent = fleet.bytes_on_all_links() - before
    if recording:
        recording.terminate()
        recording.wait()
    station.stop()
    if server:
        server.terminate()
    return {"complete_s": round(took, 3), "megabytes": round(sent / 1e6, 3)}


def measure_recovery(options):
    station = fleet.Station(options.robots)
    station.await_all(LONG)
    outages = []
    for first in range(0, options.outages, options.robots):
        cut = range(1, 1 + min(options.robots, options.outages - first))
        for robot in cut:
            fleet.set_link(robot, False)
        time.sleep(options.outage)  # No event: the links are down so long.
        up = {}
        for robot in cut:
            fleet.set_link(robot, True)
            up[f"robot_{robot}"] = time.monotonic()
        station.await_all(LONG, up)
        outages += [station.first_state_after(moment, robot) for robot, moment in up.items()]
    time.sleep(3.0)  # No event: what is not repeated by now is lost.
    lost = sum(len(station.lost_findings(robot)) for robot in station.robots)
    kills = []
    for number in range(options.kills):
        robot = 1 + number % options.robots
        assert fleet.kill_robot(robot) == 1
        time.sleep(0.5)  # No event: its last messages arrive.
        begin = time.monotonic()
        start_robot(robot, COMPOSITION)
        fleet.wait_until(lambda: station.heard_since(begin, [f"robot_{robot}"]), LONG,
                         "a killed robot is not back")
        kills.append(time.monotonic() - begin)
    station.stop()
    return {"outages_s": [round(each, 3) for each in outages], "lost_findings": lost,
            "kills_s": [round(each, 3) for each in kills]}


def start_named(name, host, log):
    """A robot of a name on a host of the fleet, or on this one with loopback alone."""
    pathlib.Path(log).unlink(missing_ok=True)
    command = ["pipescout", "run", COMPOSITION, "--namespace", name]
    if host:
        return fleet.start_on_host(host, *command, log=log)
    with open(log, "ab") as output:
        return subprocess.Popen(list(map(str, command)), stdout=output, stderr=output,
                                env=os.environ | {"ROS_LOCALHOST_ONLY": "1"})


def is_active(log):
    return "components are active" in pathlib.Path(log).read_text()


def measure_names(options):
    """Robots whose name another one has, and pairs of robots of one new name, round by round."""
    hosts = [None] * options.robots if options.local else \
        [f"robot_{k}" for k in range(1, options.robots + 1)]
    holders = []
    if options.local:
        # As robots that run before; those of fleet.sh hear nobody on the loopback interface.
        holders = [start_named(f"robot_{k}", None, f"holder_{k}.log")
                   for k in range(1, options.robots + 1)]
        fleet.wait_until(lambda: all(is_active(f"holder_{k}.log")
                                     for k in range(1, options.robots + 1)), LONG,
                         "the holders do not start")
    else:
        station = fleet.Station(options.robots)
        station.await_all(LONG)
        station.stop()
    counts = {"starts": 0, "duplicates": 0, "pairs": 0, "pairs_of_which_none_started": 0,
              "other_exit_codes": 0}
    seconds = []
    turn = 0
    while counts["starts"] < options.names:
        turn += 1
        # Each robot's name once more on the next host; and new names, each on two hosts.
        late = [(f"robot_{k + 1}", hosts[(k + 1) % len(hosts)], f"late_{k}.log")
                for k in range(len(hosts))]
        pairs = [(f"new_{turn}_{k}", hosts[k + way], f"new_{k}_{way}.log")
                 for k in range(0, len(hosts) - 1, 2) for way in (0, 1)]
        begin = time.monotonic()
        running = {each[2]: start_named(*each) for each in late + pairs}
        fleet.wait_until(lambda: all(process.poll() is not None or is_active(log)
                                     for log, process in running.items()), LONG,
                         "a start neither succeeds nor fails")
        seconds.append(time.monotonic() - begin)
        counts["starts"] += len(late) + len(pairs) // 2
        counts["pairs"] += len(pairs) // 2
        counts["duplicates"] += sum(is_active(log) for _, _, log in late)
        for one, other in zip(pairs[::2], pairs[1::2]):
            active = is_active(one[2]) + is_active(other[2])
            counts["duplicates"] += active == 2
            counts["pairs_of_which_none_started"] += active == 0
        for log, process in running.items():
            if process.poll() is None:
                process.terminate()
            elif process.returncode != NAME_TAKEN:
                counts["other_exit_codes"] += 1
                print(pathlib.Path(log).read_text(), flush=True)
        for process in running.values():
            process.wait(LONG)
    for holder in holders:
        assert holder.poll() is None, "a holder has ended"
        holder.terminate()
        holder.wait(LONG)
    return counts | {"median_turn_s": round(statistics.median(seconds), 2)}


def measure_events(options):
    """Outages of all links at once."""
    station = fleet.Station(options.robots)
    station.await_all(LONG)
    fleet.wait_until(lambda: station.heard_since(0.0, topic="finding"), LONG, "no events come")
    first = {robot: min(station.findings[robot]) for robot in station.robots}
    outages = 0
    while outages < options.events:
        for robot in range(1, options.robots + 1):
            fleet.set_link(robot, False)
        time.sleep(EVENT_OUTAGE)  # No event: the links are down so long.
        for robot in range(1, options.robots + 1):
            fleet.set_link(robot, True)
        up = time.monotonic()
        station.await_all(LONG)
        fleet.wait_until(lambda: station.heard_since(up, topic="finding"), LONG, "no events come")
        outages += options.robots
    last = {robot: max(station.findings[robot]) for robot in station.robots}
    # What has not come long after a later one never will.
    time.sleep(10.0)  # No event: the time of three heartbeats of the default profile.
    lost = {robot: station.missing_findings(robot, first[robot], last[robot])
            for robot in station.robots}
    station.stop()
    return {"outages": outages, "events": sum(last[robot] - first[robot] + 1 for robot in last),
            "lost": sum(map(len, lost.values())), "repeated": station.repeated}


def measure_late(options):
    """A station that comes when robots have kept events for a while."""
    await_robots(options.robots)
    time.sleep(70.0)  # No event: as many events as that are kept.
    station = fleet.Station(options.robots)
    fleet.wait_until(lambda: station.heard_since(0.0, topic="finding"), LONG, "no events come")
    heard = time.monotonic()
    last = {robot: max(station.findings[robot]) for robot in station.robots}
    time.sleep(max(0.0, heard + 10.0 - time.monotonic()))  # No event: the time that it gets.
    missing = {robot: station.missing_findings(robot, 0, last[robot]) for robot in station.robots}
    station.stop()
    return {"kept": sum(last.values()) + len(last), "missing": sum(map(len, missing.values())),
            "repeated": station.repeated}


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


def measure_restarts(options):
    """Kills of the discovery server, upon each of which it is started again."""
    server = start_server()
    station = fleet.Station(options.robots)
    station.await_all(LONG)
    begin = time.monotonic()
    for _ in range(options.restarts):
        server.kill()
        server.wait()
        time.sleep(1.0)  # No event: there is no server for so long.
        server = start_server()
        time.sleep(5.0)  # No event: a server is silent for 3.5 s, then tells all to all.
    station.await_all(LONG)
    with station.lock:
        silences = [max(b - a for a, b in zip(times, times[1:]))
                    for times in ([t for t in each if t > begin] for each in station.times.values())]
    lost = sum(len(station.lost_findings(robot)) for robot in station.robots)
    station.stop()
    server.terminate()
    return {"silences_s": [round(each, 3) for each in silences], "lost_findings": lost}


def measure_lossy(options):
    recording = options.traffic and fleet.start_recording(options.traffic)
    server = start_server()
    await_robots(options.robots)
    for robot in range(1, WITH_IMAGES + 1):
        fleet.kill_robot(robot)
        start_robot(robot, fleet.HERE / "robot_with_previews.yaml")
    station = fleet.Station(options.robots)
    station.await_all(LONG)
    time.sleep(10.0)  # No event: discovery has ended.
    with station.lock:
        station.numbered.clear()
    given, taken = fleet.channel_bytes(options.robots)
    time.sleep(options.sample)  # No event: a sample of so long.
    now_given, now_taken = fleet.channel_bytes(options.robots)
    given, taken = now_given - given, now_taken - taken
    if recording:
        recording.terminate()
        recording.wait()
    with station.lock:
        numbered = {robot: dict(ages) for robot, ages in station.numbered.items()}
        images = sum(topic == "image" for _, topic in station.last)
    up_to = time.monotonic()
    fleet.wait_until(lambda: station.heard_since(up_to + 3.0, topic="finding"), LONG,
                     "findings stop")
    lost_findings = sum(len(station.lost_findings(robot)) for robot in station.robots)
    station.stop()
    server.terminate()
    ages = []
    lost = 0
    for of_robot in numbered.values():
        arrived = sorted(of_robot)
        for number, following in zip(arrived, arrived[1:]):
            ages.append(of_robot[number])
            lost += following - number - 1
            ages += [of_robot[following] + STATE_PERIOD * (following - missing)
                     for missing in range(number + 1, following)]
    return {"state_p99_ms": round(1e3 * statistics.quantiles(ages, n=100)[98], 1),
            "state_p95_ms": round(1e3 * statistics.quantiles(ages, n=20)[18], 1),
            "state_median_ms": round(1e3 * statistics.median(ages), 1), "states": len(ages),
            "lost_states": lost, "lost_findings": lost_findings, "robots_with_images": images,
            "offered_megabit_per_s": round(8e-6 * given / options.sample, 2),
            "delivered_megabit_per_s": round(8e-6 * taken / options.sample, 2)}


def measure_away(options):
    station = fleet.Station(options.robots)
    station.await_all(LONG)
    time.sleep(20.0)  # No event: what grows at the start has grown.
    processes = {robot: fleet.robot_processes(robot)[0] for robot in range(1, options.robots + 1)}
    before = {robot: fleet.resident_bytes(process) for robot, process in processes.items()}
    for robot in processes:
        fleet.set_reach(robot, False)
    most = dict(before)
    end = time.monotonic() + options.away
    while time.monotonic() < end:
        time.sleep(1.0)  # No event: memory is looked at once a second.
        for robot, process in processes.items():
            most[robot] = max(most[robot], fleet.resident_bytes(process))
    for robot in processes:
        fleet.set_reach(robot, True)
    back = station.await_all(LONG)
    fleet.wait_until(lambda: not any(map(station.lost_findings, station.robots)), LONG,
                     "findings are lost")
    station.stop()
    return {"megabytes": [round(1e-6 * (most[robot] - before[robot]), 2) for robot in processes],
            "back_s": round(back, 3)}


def measure_slow_reader(options):
    """Images of robot_2 on the station's host, with a reader there; in turns with one on robot_1's.

    The two on the station's host share memory, as on a robot: the images do not wait for the rate."""
    robot = subprocess.Popen(["pipescout", "run", fleet.HERE / "robot_ten_times.yaml",
                              "--namespace", "robot_2"])
    station = fleet.Station(2)
    fleet.wait_until(lambda: station.heard_since(0.0, ["robot_2"], "image"), LONG, "no images come")
    times = {False: [], True: []}
    for turn in range(2 * options.turns):
        slow = turn % 2 == 1
        reader = slow and fleet.start_on_host("robot_1", "fleet_station", 2, log="reader.log")
        time.sleep(5.0)  # No event: the reader is found.
        with station.lock:
            station.publish_times.clear()
        time.sleep(options.sample / 2.0)  # No event: a sample of so long.
        with station.lock:
            times[slow] += station.publish_times["robot_2"]
        if reader:
            reader.terminate()
            reader.wait()
    station.stop()
    robot.terminate()
    # Of the slow reader: else nothing was measured.
    result = {"heard": pathlib.Path("reader.log").read_text().count(" robot_2 ")}
    assert result["heard"] > 0, "the slow reader hears nothing"
    for slow, name in ((False, "without"), (True, "with")):
        result[f"{name}_p99_us"] = round(1e6 * statistics.quantiles(times[slow], n=100)[98], 1)
        result[f"{name}_median_us"] = round(1e6 * statistics.median(times[slow]), 1)
        result[f"{name}_images"] = len(times[slow])
    return result


MEASUREMENTS = {each.__name__: each for each in
                (measure_discovery, measure_names, measure_events, measure_late, measure_recovery, measure_restarts, measure_wifi, measure_lossy,
                 measure_away, measure_slow_reader)}


def in_fleet(options, measurement, robots, env, server=False, composition=COMPOSITION, links=(),
             local=False):
    """Brings a fleet up, and gives what the measurement in its station gives."""
    with tempfile.TemporaryDirectory(prefix="pipescout_fleet_") as scratch:
        result = pathlib.Path(scratch) / "result.json"
        station = [sys.executable, "-B", __file__, "--inside", measurement, "--result", result,
                   "--robots", robots, "--outages", options.outages, "--outage", options.outage,
                   "--kills", options.kills, "--restarts", options.restarts, "--away",
                   options.away, "--sample", options.sample, "--turns", options.turns]
        station += ["--names", options.names, "--events", options.events]
        station += ["--local"] if local else []
        station += ["--server"] if server else []
        station += ["--traffic", options.traffic.resolve()] if options.traffic else []
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
    parser.add_argument("--restarts", type=int, default=3,
                        help="of the discovery server (default: 3)")
    parser.add_argument("--away", type=float, default=60.0,
                        help="s in which no robot can be reached (default: 60)")
    parser.add_argument("--sample", type=float, default=20.0,
                        help="s for which states and images are looked at (default: 20)")
    parser.add_argument("--turns", type=int, default=3,
                        help="with and without a slow reader (default: 3)")
    parser.add_argument("--names", type=int, default=200,
                        help="starts of robots whose name is taken (default: 200)")
    parser.add_argument("--events", type=int, default=20,
                        help="outages of 30 s in which events happen (default: 20)")
    parts = ("discovery", "names", "events", "recovery", "restarts", "wifi", "lossy", "away", "slow_reader")
    parser.add_argument("--traffic", metavar="FILE", type=pathlib.Path,
                        help="records the lossy channel, or with --only discovery that by "
                        "multicast (and by server in FILE.server), for test/fleet/traffic.py")
    parser.add_argument("--only", nargs="+", choices=parts, default=parts, help="only these")
    parser.add_argument("--prefix", type=pathlib.Path,
                        help="run what is built there, in the present environment")
    parser.add_argument("--inside", choices=list(MEASUREMENTS), help=argparse.SUPPRESS)
    parser.add_argument("--result", type=pathlib.Path, help=argparse.SUPPRESS)
    parser.add_argument("--server", action="store_true", help=argparse.SUPPRESS)
    parser.add_argument("--local", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.inside:
        options.result.write_text(json.dumps(MEASUREMENTS[options.inside](options)))
        return
    if reason := fleet.why_not():
        sys.exit(f"cannot run: {reason}")
    env = fleet.built_environment(options.prefix)
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
    if "names" in options.only:
        for name, links in (("duplicate_names_started", ()), ("duplicate_names_lossy", LOSSY_LINKS)):
            found = in_fleet(options, "measure_names", 4, env, links=links, local=not links)
            rows.append({"case": "names that are taken", "links": " ".join(links) or "loopback"} |
                        found)
            print(rows[-1], flush=True)
            figures[name] = found["duplicates"]
    if "events" in options.only:
        found = in_fleet(options, "measure_events", 4, env)
        rows.append({"case": "events and outages", "robots": 4, "outage_s": EVENT_OUTAGE} | found)
        print(rows[-1], flush=True)
        figures["events_lost"] = found["lost"]
        found = in_fleet(options, "measure_late", 4, env, links=LOSSY_LINKS)
        rows.append({"case": "a late station", "links": " ".join(LOSSY_LINKS)} | found)
        print(rows[-1], flush=True)
        figures["late_events_missing"] = found["missing"]
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
    if "restarts" in options.only:
        found = in_fleet(options, "measure_restarts", 4,
                         env | {"ROS_DISCOVERY_SERVER": fleet.SERVER})
        rows.append({"case": "restarts of the discovery server", "robots": 4} | found)
        print(rows[-1], flush=True)
        figures["recovery_server_p100_s"] = max(found["silences_s"])
    if "lossy" in options.only:
        found = in_fleet(options, "measure_lossy", options.robots,
                         env | {"PIPESCOUT_NETWORK": "wifi:1",
                                "ROS_DISCOVERY_SERVER": fleet.SERVER}, links=LOSSY)
        rows.append({"case": f"one lossy channel ({' '.join(LOSSY)})", "robots": options.robots} |
                    found)
        print(rows[-1], flush=True)
        figures["state_p99_ms"] = found["state_p99_ms"]
        figures["lost_findings"] = found["lost_findings"]
    if "away" in options.only:
        found = in_fleet(options, "measure_away", 4, env,
                         composition=fleet.HERE / "robot_ten_times.yaml"
                         if options.away <= LONGEST_AT_TEN_TIMES else COMPOSITION)
        rows.append({"case": "out of reach", "robots": 4, "away_s": options.away} | found)
        print(rows[-1], flush=True)
        figures["away_megabytes"] = max(found["megabytes"])
    if "slow_reader" in options.only:
        found = in_fleet(options, "measure_slow_reader", 1,
                         env | {"PIPESCOUT_NETWORK": "wifi:1"}, links=SLOW)
        rows.append({"case": "a reader behind a link of 1 Mbit/s"} | found)
        print(rows[-1], flush=True)
        figures["publish_p99_us"] = found["with_p99_us"]
        figures["publish_p99_ratio"] = round(found["with_p99_us"] / found["without_p99_us"], 3)
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
